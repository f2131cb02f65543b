/* A whole program: a window, a colonnade, and the light that a two-layer G-buffer finds behind the pillars.
   `minimal` runs until its window is closed; `minimal FRAMES FILE.ppm` saves the last of that many frames.
   Lines marked dgb use the library; the rest is what an engine has anyway. */
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#define DEEPGBUFFER_IMPLEMENTATION /* dgb */
#include "deepgbuffer.h"           /* dgb */
#include "deepgbuffer_gl.h"        /* dgb */

static dgbgl_backend gl; /* dgb */
static dgb_context dgb;  /* dgb */

/* The scene is 23 boxes, made from vertex and instance numbers; the library's text goes before theirs. */
static const char* const box_vertex =
    "uniform mat4 view, projection, previous_view, previous_projection; out vec3 v_normal, v_albedo;\n"
    "void main() {\n"
    "    int b = dgb_instance(), face = gl_VertexID / 6, corner = gl_VertexID % 6;\n" /* dgb */
    "    float z = 4.4 - 2.4 * float(b % 9);\n"
    "    vec3 cloth = b % 3 == 1 ? vec3(0.02, 0.06, 0.8) : vec3(0.9, b % 3 == 0 ? 0.15 : 0.02, 0.01);\n"
    "    vec3 low = vec3(-4.1, -0.2, -17), high = vec3(2.5, 0, 7);\n"                         /* floor */
    "    if (b < 9) low = vec3(-3.3, 0, z - 0.1), high = vec3(-2.4, 3.4, z + 0.1);\n"         /* pillars */
    "    else if (b < 18) low = vec3(-4.1, 0, z - 2.4), high = vec3(-4, 3.4, z);\n"           /* drapes behind */
    "    else if (b < 21) low = vec3(-2, 0, 3 * b - 61), high = low + vec3(0.8, 0.6, 0.9);\n" /* crates */
    "    else if (b < 22) low = vec3(-4.1, 3.4, -17), high = vec3(-2.3, 3.6, 7);\n"           /* roof */
    "    vec3 p = vec3(corner % 2, (corner + 1) / 3 % 2, face % 2), n = vec3(0, 0, 2.0 * p.z - 1.0);\n"
    "    if (face / 2 == 1) p = p.yzx, n = n.yzx; else if (face / 2 == 2) p = p.zxy, n = n.zxy;\n"
    "    vec4 world = vec4(mix(low, high, p), 1);\n"
    "    v_normal = mat3(view) * n, v_albedo = b / 9 == 1 ? cloth : vec3(0.8);\n"
    "    dgb_vertex(projection * view * world, previous_projection * previous_view * world);\n" /* dgb */
    "}\n";
static const char* const box_fragment =
    "in vec3 v_normal, v_albedo;\n"
    "void main() {\n"
    "    if (!dgb_keep()) discard;\n"                                      /* dgb */
    "    vec3 sunlit = 6.0 / 3.14159 * v_albedo * max(v_normal.x, 0.0);\n" /* from the right */
    "    dgb_store(vec4(v_albedo, 1), v_normal, vec2(0), sunlit);\n"       /* dgb */
    "}\n";
static const char* const screen_vertex = /* a triangle over the whole screen */
    "void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }\n";
static const char* const screen_fragment =
    "uniform sampler2DArray albedo, radiance; uniform sampler2D ao, irradiance; out vec4 color;\n"
    "void main() {\n"
    "    ivec3 p = ivec3(ivec2(gl_FragCoord) + 64, 0);\n" /* 64: the guard band; 0: the front layer */
    "    vec4 surface = texelFetch(albedo, p, 0), bounced = texelFetch(irradiance, p.xy, 0);\n"
    "    vec3 sky = vec3(0.2, 0.24, 0.32), open = sky * texelFetch(ao, p.xy, 0).r;\n"
    "    vec3 indirect = surface.rgb / 3.14159 * mix(open, bounced.rgb, min(2.0 * bounced.a, 1.0));\n"
    "    vec3 light = texelFetch(radiance, p, 0).rgb + indirect;\n"
    "    color = vec4(pow(1.0 - exp(-1.8 * mix(sky, light, surface.a)), vec3(1.0 / 2.2)), 1);\n"
    "}\n";

static void fail(const char* sentence) { fprintf(stderr, "minimal: %s\n", sentence), exit(2); }
static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) { /* dgb */
    (void)user, (void)result, (void)item, fail(sentence);
}

static void on_message(void* user, const char* text) { (void)user, fail(text); } /* dgb */

static void add_shader(GLuint program, GLenum stage, const char* prefix, const char* text) {
    const char* const pieces[] = {prefix, text};
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 2, pieces, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
}

static GLuint box_program(void) { /* dgb */
    static const dgbgl_varying varyings[] = {{NULL, "vec3", "v_normal"}, {NULL, "vec3", "v_albedo"}};
    static char prefix[1 << 16];
    const GLuint program = glCreateProgram();
    dgbgl_shader_prefix(&dgb, DGBGL_VERTEX, varyings, 2, prefix, sizeof prefix);
    add_shader(program, GL_VERTEX_SHADER, prefix, box_vertex);
    if (dgbgl_geometry_shader(&dgb, varyings, 2, prefix, sizeof prefix)) /* most drivers need none */
        add_shader(program, GL_GEOMETRY_SHADER, prefix, "");
    dgbgl_shader_prefix(&dgb, DGBGL_FRAGMENT, varyings, 2, prefix, sizeof prefix);
    add_shader(program, GL_FRAGMENT_SHADER, prefix, box_fragment);
    glLinkProgram(program);
    dgbgl_attach_program(&dgb, program);
    return program;
}

static void draw_scene(void* user, const dgb_draw* draw) { /* dgb */
    const char* const names[] = {"view", "projection", "previous_view", "previous_projection"};
    const float* values[] = {draw->view, draw->projection, draw->previous_view, draw->previous_projection};
    const GLuint program = *(const GLuint*)user;
    glUseProgram(program);
    for (int i = 0; i < 4; ++i) glUniformMatrix4fv(glGetUniformLocation(program, names[i]), 1, GL_FALSE, values[i]);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, 23 * draw->instances);
}

static void save(const char* path, int width, int height) {
    static unsigned char row[3 * DGB_MAX_SIZE];
    FILE* file = fopen(path, "wb");
    if (!file || fprintf(file, "P6 %d %d 255\n", width, height) < 0) fail("the picture cannot be written");
    for (int y = height; y--; fwrite(row, 3, (size_t)width, file))
        glReadPixels(0, y, width, 1, GL_RGB, GL_UNSIGNED_BYTE, row);
    if (ferror(file) || fclose(file)) fail("the picture cannot be written");
}

int main(int argc, char** argv) {
    const int frames = argc == 3 ? atoi(argv[1]) : 0;
    if (argc != 1 && frames < 1) fail("give no arguments, or FRAMES and FILE.ppm");
    glfwInit();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3), glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE), glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    GLFWwindow* window = glfwCreateWindow(960, 540, "deepgbuffer", NULL, NULL);
    if (!window) fail("no window with OpenGL 3.3: is there a display (xvfb-run -a gives one), and a driver of today?");
    glfwMakeContextCurrent(window);

    dgbgl_desc gl_desc = {.get_proc = (dgbgl_get_proc_fn)glfwGetProcAddress, .message = on_message};
    dgbgl_init(&gl, &gl_desc); /* dgb, to the blank line */
    dgb_desc desc = {.backend = &gl.backend, .log = on_log, .effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY};
    glfwGetFramebufferSize(window, &desc.width, &desc.height);
    desc.guard_band = 64; /* pixels around the image: what stands there gives light, too */
    dgb_init(&dgb, &desc);
    const dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    dgb_view view = {.view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1.6f, -6.2f, 1}, /* by columns */
                     .projection = {1.3f, 0, 0, 0, 0, 2.3f, 0, 0, -0.7f, -0.15f, -1.0033f, -1, 0, 0, -0.2f}};

    GLuint boxes = box_program(), screen = glCreateProgram(), vertex_array;
    add_shader(screen, GL_VERTEX_SHADER, "#version 330 core\n", screen_vertex);
    add_shader(screen, GL_FRAGMENT_SHADER, "#version 330 core\n", screen_fragment);
    glLinkProgram(screen);
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    glUseProgram(screen); /* stays so: the library leaves the state as it finds it */
    const dgb_slot slots[] = {DGB_ALBEDO, DGB_RADIANCE, DGB_AO, DGB_IRRADIANCE}; /* dgb */
    for (int i = 0; i < 4; ++i) {
        const GLuint texture = dgbgl_texture_name(dgb_get_texture(&dgb, slots[i])); /* dgb */
        glActiveTexture(GL_TEXTURE0 + (GLenum)i);
        glBindTexture(i < 2 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, texture);
        glUniform1i(glGetUniformLocation(screen, dgb_slot_name(slots[i])), i);
    }
    for (int frame = 0; !glfwWindowShouldClose(window) && (!frames || frame < frames); ++frame) {
        view.view[12] = -0.1f - 0.5f * sinf(0.02f * (float)frame); /* slides sideways */
        dgb_build(&dgb, &view, &params, draw_scene, &boxes);       /* dgb: both layers, one pass over the scene */
        dgb_shade(&dgb, &params);                                  /* dgb: occlusion and bounced light */
        glDrawArrays(GL_TRIANGLES, 0, 3);
        if (glGetError()) fail("OpenGL reports an error: is a shader wrong?");
        if (frame + 1 == frames) save(argv[2], desc.width, desc.height);
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    dgb_shutdown(&dgb);  /* dgb */
    dgbgl_shutdown(&gl); /* dgb */
    glfwTerminate();
}
