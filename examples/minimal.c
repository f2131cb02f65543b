/* A whole program: a window, forty boxes, ambient occlusion and one bounce of light from a two-layer G-buffer.
       minimal                    until the window is closed
       minimal FRAMES FILE.ppm    that many frames, then saves the last
   Lines marked dgb belong to the library; the rest is what an engine has already. */
#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#define DEEPGBUFFER_IMPLEMENTATION /* dgb */
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 960, HEIGHT = 540, GUARD = 48, BOXES = 41 };

static dgbgl_backend gl; /* dgb */
static dgb_context   dgb;

/* A material shader is the library's prefix, then this. The boxes come from gl_VertexID: no buffers, nothing to load. */
static const char* const material_text[3] = {
    "uniform mat4 view, projection, previous_view, previous_projection; out vec3 v_normal; out vec3 v_albedo;\n"
    "void main() {\n"
    "    int b = dgb_instance(), face = gl_VertexID / 6, axis = face / 2, corner = gl_VertexID % 6;\n" /* dgb */
    "    float row = float(b / 10), side = float(face % 2);\n"
    "    vec3 low = b == 40 ? vec3(-12, -0.2, -14) : vec3(2.0 * float(b % 10) - 9.0, 0, 3.0 * row - 10.0);\n"
    "    vec3 high = b == 40 ? vec3(12, 0, 8) : low + (row == 0.0 ? vec3(1.9, 4, 0.2) : vec3(0.4, 1.2 + 0.5 * row, 0.4));\n"
    "    vec2 uv = vec2(corner == 1 || corner == 2 || corner == 4, corner == 2 || corner >= 4);\n"
    "    vec3 p = vec3(uv, side), n = vec3(0, 0, 2.0 * side - 1.0);\n"
    "    if (axis == 1) { p = p.yzx; n = n.yzx; }\n"
    "    if (axis == 2) { p = p.zxy; n = n.zxy; }\n"
    "    vec4 world = vec4(mix(low, high, p), 1);\n"
    "    v_normal = n;\n"
    "    v_albedo = b >= 10 ? vec3(0.75) : b % 2 == 0 ? vec3(0.85, 0.08, 0.05) : vec3(0.1, 0.5, 0.85);\n"
    "    dgb_vertex(projection * (view * world), previous_projection * (previous_view * world));\n" /* dgb */
    "}\n",
    "",
    "uniform mat4 view; in vec3 v_normal; in vec3 v_albedo;\n"
    "void main() {\n"
    "    if (!dgb_keep()) discard;\n" /* dgb */
    "    float sun = 4.0 * max(dot(v_normal, normalize(vec3(0.3, 0.5, 0.8))), 0.0);\n"
    "    dgb_store(vec4(v_albedo, 1), mat3(view) * v_normal, vec2(0), v_albedo / 3.14159 * sun);\n" /* dgb */
    "}\n"};
static const char* const composite_text[3] = {
    "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }\n",
    "",
    "uniform sampler2DArray albedo, radiance; uniform sampler2D ao, irradiance; uniform int guard; out vec4 color;\n"
    "void main() {\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy) + guard;\n" /* the image sits inside the guard band */
    "    vec4 e = texelFetch(irradiance, p, 0);\n"
    "    vec3 sky = vec3(0.3, 0.4, 0.55) * texelFetch(ao, p, 0).r;\n"
    "    vec3 indirect = texelFetch(albedo, ivec3(p, 0), 0).rgb / 3.14159 * mix(sky, e.rgb, e.a);\n"
    "    color = vec4(pow(texelFetch(radiance, ivec3(p, 0), 0).rgb + indirect, vec3(1.0 / 2.2)), 1);\n"
    "}\n"};

static void fail(const char* what) {
    fprintf(stderr, "minimal: %s\n", what);
    exit(1);
}

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) { /* dgb */
    (void)user, (void)result, (void)item;
    fail(sentence);
}

static void* get_proc(const char* name) { /* dgb */
    const GLFWglproc proc = glfwGetProcAddress(name);
    void*            address;
    memcpy(&address, &proc, sizeof address);
    return address;
}

static GLuint link_program(const char* const prefix[3], const char* const text[3]) {
    static const GLenum stages[] = {GL_VERTEX_SHADER, GL_GEOMETRY_SHADER, GL_FRAGMENT_SHADER};
    const GLuint        program  = glCreateProgram();
    GLint               linked   = 0;
    for (int i = 0; i < 3; ++i) {
        const char* pieces[] = {prefix[i], text[i]};
        GLuint      shader;
        if (!prefix[i][0]) continue; /* most drivers need no geometry shader */
        shader = glCreateShader(stages[i]);
        glShaderSource(shader, 2, pieces, NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) fail("a program does not link");
    return program;
}

static GLuint material_program(void) { /* dgb */
    static const dgbgl_varying varyings[] = {{NULL, "vec3", "v_normal"}, {NULL, "vec3", "v_albedo"}};
    static char                text[3][1 << 16];
    const char*                prefix[] = {text[0], text[1], text[2]};
    GLuint                     program;
    dgbgl_shader_prefix(&dgb, DGBGL_VERTEX, varyings, 2, text[0], sizeof text[0]);
    dgbgl_geometry_shader(&dgb, varyings, 2, text[1], sizeof text[1]);
    dgbgl_shader_prefix(&dgb, DGBGL_FRAGMENT, varyings, 2, text[2], sizeof text[2]);
    program = link_program(prefix, material_text);
    dgbgl_attach_program(&dgb, program);
    return program;
}

static void draw_scene(void* user, const dgb_draw* draw) { /* dgb: called once a frame, or once a layer */
    const char*  names[]    = {"view", "projection", "previous_view", "previous_projection"};
    const float* matrices[] = {draw->view, draw->projection, draw->previous_view, draw->previous_projection};
    const GLuint program    = *(const GLuint*)user;
    glUseProgram(program);
    for (int i = 0; i < 4; ++i) glUniformMatrix4fv(glGetUniformLocation(program, names[i]), 1, GL_FALSE, matrices[i]);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, BOXES * draw->instances);
}

static dgb_view camera(int frame) { /* slides sideways, looks down -Z */
    dgb_view v = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, -6, 1}, {0}, {0, 0}, false};
    v.view[12] = -2.0f * sinf(0.02f * (float)frame);
    v.projection[0] = 1.6f * (float)HEIGHT / (float)WIDTH, v.projection[5] = 1.6f;
    v.projection[10] = -60.1f / 59.9f, v.projection[14] = -12.0f / 59.9f, v.projection[11] = -1.0f; /* 0.1 m to 60 m */
    return v;
}

static void composite(GLuint program) {
    static const char* const names[] = {"albedo", "radiance", "ao", "irradiance"};
    static const dgb_slot    slots[] = {DGB_ALBEDO, DGB_RADIANCE, DGB_AO, DGB_IRRADIANCE};
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "guard"), GUARD);
    for (int i = 0; i < 4; ++i) {
        glActiveTexture((GLenum)(GL_TEXTURE0 + i));
        glBindTexture(i < 2 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(&dgb, slots[i])));
        glUniform1i(glGetUniformLocation(program, names[i]), i);
    }
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void save(const char* path) {
    static unsigned char pixels[HEIGHT][WIDTH][3];
    FILE*                file = fopen(path, "wb");
    glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    if (!file || fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT) < 0) fail("the picture cannot be written");
    for (int y = HEIGHT; y--;) fwrite(pixels[y], 3, WIDTH, file);
    if (ferror(file) | fclose(file)) fail("the picture cannot be written");
}

int main(int argc, char** argv) {
    static const char* const screen_prefix[3] = {"#version 330 core\n", "", "#version 330 core\n"};
    const int                frames = argc == 3 ? atoi(argv[1]) : 0;
    const dgb_params         params = dgb_preset(DGB_PRESET_BALANCED); /* dgb */
    dgbgl_desc               gl_desc = {0};                            /* dgb */
    dgb_desc                 desc    = {0};                            /* dgb */
    GLFWwindow*              window;
    GLuint                   material, screen, vertex_array;
    glfwInit();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3), glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE), glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    window = glfwCreateWindow(WIDTH, HEIGHT, "deepgbuffer", NULL, NULL);
    if (!window) fail("no window with OpenGL 3.3");
    glfwMakeContextCurrent(window);

    gl_desc.get_proc = get_proc; /* dgb: from here */
    if (dgbgl_init(&gl, &gl_desc) != DGB_OK) fail("this OpenGL will not do");
    desc.width = WIDTH, desc.height = HEIGHT, desc.guard_band = GUARD;
    desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    desc.backend = &gl.backend, desc.log = on_log;
    dgb_init(&dgb, &desc);
    material = material_program(); /* dgb: to here */

    screen = link_program(screen_prefix, composite_text);
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    for (int frame = 0; !glfwWindowShouldClose(window) && (!frames || frame < frames); ++frame) {
        const dgb_view view = camera(frame);
        dgb_build(&dgb, &view, &params, draw_scene, &material); /* dgb: all layers, one pass over the geometry */
        dgb_shade(&dgb, &params);                               /* dgb: occlusion and bounced light */
        composite(screen);
        if (frame + 1 == frames) save(argv[2]);
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    dgb_shutdown(&dgb); /* dgb */
    dgbgl_shutdown(&gl);
    glfwTerminate();
    return 0;
}
