#include "gl_fixture.h"
#include "gl_faults.h"
#include "numbers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

/* >> context */

static void GLAPIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                  const GLchar* text, const void* user) {
    fixture* f = (fixture*)(uintptr_t)user;
    (void)source, (void)type, (void)id, (void)length;
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION) return;
    ++f->messages;
    printf("# GL message: %s\n", text);
}

/* Every fresh texture is full of numbers of its own, as on a driver that hands out memory as it finds it: the library leaves
   undefined what is not shaded, and a test that looks there fails. test_guest.c shows with NaN that the library does not. */
static void poison(GLenum target, GLsizei levels, GLenum format) {
    static unsigned count;
    gl_filling filling;
    GLint width;
    glGetTexLevelParameteriv(target, 0, GL_TEXTURE_WIDTH, &width);
    if (width == 0) return; /* there was no memory */
    ++count;
    filling.number = count % 2 ? (float)count : -(float)count;
    filling.share = (float)(count % 255) / 255.0f;
    filling.integer = count;
    gl_faults_fill(headless_get_proc, target, levels, format, filling);
}

static void GLAPIENTRY poisoned_storage_2d(GLenum target, GLsizei levels, GLenum format, GLsizei width,
                                           GLsizei height) {
    glTexStorage2D(target, levels, format, width, height);
    poison(target, levels, format);
}

static void GLAPIENTRY poisoned_storage_3d(GLenum target, GLsizei levels, GLenum format, GLsizei width, GLsizei height,
                                           GLsizei layers) {
    glTexStorage3D(target, levels, format, width, height, layers);
    poison(target, levels, format);
}

void* fixture_get_proc(const char* name) {
    const bool flat = strcmp(name, "glTexStorage2D") == 0, layered = strcmp(name, "glTexStorage3D") == 0;
    PFNGLTEXSTORAGE2DPROC storage_2d = poisoned_storage_2d;
    PFNGLTEXSTORAGE3DPROC storage_3d = poisoned_storage_3d;
    void* address = headless_get_proc(name);
    if (epoxy_gl_version() < 44 || !epoxy_is_desktop_gl()) return address; /* no glClearTexImage */
    if (flat) memcpy(&address, &storage_2d, sizeof address);
    if (layered) memcpy(&address, &storage_3d, sizeof address);
    return address;
}

static void on_backend_message(void* user, const char* text) {
    (void)user;
    printf("# %s\n", text);
}

void fixture_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    (void)user;
    printf("# %s %s: %s\n", dgb_result_name(result), dgb_log_item_name(item), sentence);
}

/* >> scene: triangles of position, normal, colour */

#define MAX_VERTICES 20000

typedef struct vertex {
    float position[3], normal[3], color[3];
} vertex;

static uint32_t random_state;

static float random_between(float low, float high) { return low + (high - low) * (float)lcg_unit(&random_state); }

static int add_quad(vertex* out, int count, const float corner[3], const float u[3], const float v[3],
                    const float color[3]) {
    static const float uv[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    int i, c;
    for (i = 0; i < 6; ++i)
        for (c = 0; c < 3; ++c) {
            out[count + i].position[c] = corner[c] + u[c] * uv[i][0] + v[c] * uv[i][1];
            out[count + i].normal[c] = n[c] / length;
            out[count + i].color[c] = color[c];
        }
    return count + 6;
}

/* Axis-aligned box, outward faces counter-clockwise. */
static int add_box(vertex* out, int count, const float low[3], const float high[3], const float color[3]) {
    int axis, side;
    for (axis = 0; axis < 3; ++axis)
        for (side = 0; side < 2; ++side) {
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            float corner[3], u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
            memcpy(corner, low, sizeof corner);
            if (side) corner[axis] = high[axis];
            u[side ? a : b] = high[side ? a : b] - low[side ? a : b];
            v[side ? b : a] = high[side ? b : a] - low[side ? b : a];
            count = add_quad(out, count, corner, u, v, color);
        }
    return count;
}

static int add_box_at(vertex* out, int count, float x, float z, float half, float height, const float color[3]) {
    const float low[3] = {x - half, 0.0f, z - half}, high[3] = {x + half, height, z + half};
    return add_box(out, count, low, high, color);
}

static int build_room(vertex* out) {
    static const float grey[3] = {0.6f, 0.6f, 0.6f}, red[3] = {0.8f, 0.1f, 0.1f}, green[3] = {0.1f, 0.7f, 0.2f};
    const float floor_corner[3] = {-10, 0, 8}, floor_u[3] = {20, 0, 0}, floor_v[3] = {0, 0, -22};
    const float back_corner[3] = {-10, 0, -14}, back_u[3] = {20, 0, 0}, back_v[3] = {0, 8, 0};
    const float left_corner[3] = {-10, 0, 8}, left_u[3] = {0, 0, -22}, left_v[3] = {0, 8, 0};
    int count = 0, i;
    random_state = 7u;
    count = add_quad(out, count, floor_corner, floor_u, floor_v, grey);
    count = add_quad(out, count, back_corner, back_u, back_v, green);
    count = add_quad(out, count, left_corner, left_u, left_v, red);
    for (i = 0; i < 14; ++i) {
        const float color[3] = {0.7f, 0.65f, 0.5f};
        count = add_box_at(out, count, -8.0f + 2.6f * (float)(i % 7), i < 7 ? -3.0f : -6.5f, 0.25f, 5.0f, color);
    }
    for (i = 0; i < 60; ++i) {
        const float color[3] = {random_between(0, 1), random_between(0, 1), random_between(0, 1)};
        count = add_box_at(out, count, random_between(-9, 9), random_between(-13, 3), random_between(0.1f, 0.7f),
                           random_between(0.1f, 2.5f), color);
    }
    return count;
}

static void upload_scene(fixture* f) {
    static vertex vertices[MAX_VERTICES];
    static const float blue[3] = {0.1f, 0.2f, 0.9f};
    GLuint attribute;
    f->static_count = build_room(vertices);
    f->moving_count = add_box_at(vertices, f->static_count, 0.0f, -1.5f, 0.4f, 2.0f, blue) - f->static_count;
    glGenVertexArrays(1, &f->vertex_array);
    glBindVertexArray(f->vertex_array);
    glGenBuffers(1, &f->vertices);
    glBindBuffer(GL_ARRAY_BUFFER, f->vertices);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(sizeof(vertex) * (size_t)(f->static_count + f->moving_count)), vertices,
                 GL_STATIC_DRAW);
    for (attribute = 0; attribute < 3; ++attribute) {
        glEnableVertexAttribArray(attribute);
        glVertexAttribPointer(attribute, 3, GL_FLOAT, GL_FALSE, (GLsizei)sizeof(vertex),
                              (const void*)(uintptr_t)(12u * attribute));
    }
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
}

/* A desktop context is of the version asked for, or of DGB_GL_VERSION=MAJOR.MINOR where that is lower
   (tests/gl/opinions.sh). */
static bool limit_version(int* major, int* minor) {
    const char* text = getenv("DGB_GL_VERSION");
    int limit[2];
    if (!text || sscanf(text, "%d.%d", &limit[0], &limit[1]) != 2) return false;
    if (limit[0] * 10 + limit[1] >= *major * 10 + *minor) return false;
    *major = limit[0];
    *minor = limit[1];
    return true;
}

static void print_left_out(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    (void)user, (void)result, (void)sentence;
    printf("# left out %s\n", dgb_log_item_name(item));
}

bool fixture_offers(const fixture* f, const dgb_desc* desc) {
    dgb_desc d = *desc;
    dgb_plan plan;
    d.log = print_left_out;
    return !f->limited || dgb_make_plan(&d, &plan) != DGB_UNSUPPORTED;
}

/* Who gives this opinion, once a program and kind of context. */
static void print_context(bool es) {
    static bool printed[2];
    if (!printed[es])
        printf("# context: %s, %s\n", (const char*)glGetString(GL_VERSION), (const char*)glGetString(GL_RENDERER));
    printed[es] = true;
}

int fixture_open(fixture* f, int major, int minor, bool es, const dgbgl_desc* desc) {
    dgbgl_desc d;
    char error[256] = "";
    memset(f, 0, sizeof *f);
    if (!es) f->limited = limit_version(&major, &minor);
    if (desc)
        d = *desc;
    else
        memset(&d, 0, sizeof d);
    if (!d.get_proc) d.get_proc = fixture_get_proc;
    if (!d.message) d.message = on_backend_message;
    if (!headless_create(&f->window, major, minor, es, true, error, sizeof error)) {
        printf("# no context: %s\n", error);
        return 1;
    }
    print_context(es);
    if (epoxy_has_gl_extension("GL_KHR_debug")) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(on_message, f);
        glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, NULL, GL_TRUE);
    }
    upload_scene(f);
    if (dgbgl_init(&f->gl, &d) == DGB_OK) return 0;
    fixture_close(f);
    return 1;
}

void fixture_close(fixture* f) {
    dgbgl_shutdown(&f->gl);
    glDeleteBuffers(1, &f->vertices);
    glDeleteVertexArrays(1, &f->vertex_array);
    headless_destroy(&f->window);
}

/* >> camera */

fixture_view fixture_default_view(void) {
    fixture_view v;
    memset(&v, 0, sizeof v);
    v.eye[0] = 0.5f;
    v.eye[1] = 1.7f;
    v.eye[2] = 5.0f;
    v.fov = 60.0f;
    v.near_plane = 0.1f;
    v.far_plane = 60.0f;
    v.scale = 1.0f;
    return v;
}

static void view_matrix(const fixture_view* v, float m[16]) {
    const float c = cosf(v->yaw), s = sinf(v->yaw);
    memset(m, 0, sizeof(float) * 16);
    m[0] = c;
    m[8] = s;
    m[5] = 1.0f;
    m[2] = -s;
    m[10] = c;
    m[12] = -(c * v->eye[0] + s * v->eye[2]);
    m[13] = -v->eye[1];
    m[14] = -(-s * v->eye[0] + c * v->eye[2]);
    m[15] = 1.0f;
}

/* Rows 2 and 3 from depth(distance near) = d_near, depth(distance far) = d_far in ndc. */
static void projection_matrix(const fixture_view* v, float aspect, float m[16]) {
    const double low = v->clip == DGB_CLIP_ZERO_TO_ONE ? 0.0 : -1.0;
    const double at_near = v->reversed ? 1.0 : low, at_far = v->reversed ? low : 1.0;
    const double n = (double)(v->near_plane * v->scale), f = (double)(v->far_plane * v->scale);
    memset(m, 0, sizeof(float) * 16);
    if (v->fov > 0.0f) {
        const double scale = 1.0 / tan(v->fov * 3.14159265358979 / 360.0);
        m[0] = (float)(scale / aspect);
        m[5] = (float)scale;
        m[10] = (float)(f > 0.0 ? (n * at_near - f * at_far) / (f - n) : -at_far);
        m[14] = (float)(f > 0.0 ? n * f * (at_near - at_far) / (f - n) : n * (at_near - at_far));
        m[11] = -1.0f;
    } else {
        m[0] = 1.0f / (6.0f * aspect);
        m[5] = 1.0f / 6.0f;
        m[10] = (float)((at_near - at_far) / (f - n));
        m[14] = (float)((at_near * f - at_far * n) / (f - n));
        m[15] = 1.0f;
    }
}

dgb_view fixture_dgb_view(const fixture_view* v, int width, int height) {
    dgb_view view;
    int i;
    memset(&view, 0, sizeof view);
    view_matrix(v, view.view);
    for (i = 0; i < 15; ++i) view.view[i] *= v->scale;
    projection_matrix(v, (float)width / (float)height, view.projection);
    memcpy(view.jitter, v->jitter, sizeof view.jitter);
    return view;
}

dgb_desc fixture_desc(const fixture* f, const fixture_view* v, int width, int height, int guard_band) {
    dgb_desc d;
    memset(&d, 0, sizeof d);
    d.width = width;
    d.height = height;
    d.guard_band = guard_band;
    d.clip = v->clip;
    d.reversed = v->reversed;
    d.backend = &f->gl.backend;
    d.log = fixture_log;
    return d;
}

/* >> drawing */

static GLuint compile(GLenum stage, const char* prefix, const char* body) {
    const char* text[2];
    GLuint shader = glCreateShader(stage);
    GLint ok = 0;
    char log[2048];
    text[0] = prefix;
    text[1] = body;
    glShaderSource(shader, 2, text, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok) return shader;
    glGetShaderInfoLog(shader, (GLsizei)sizeof log, NULL, log);
    printf("# %s\n", log);
    glDeleteShader(shader);
    return 0;
}

static const char vertex_body[] =
    "layout(location = 0) in vec3 position; layout(location = 1) in vec3 normal; layout(location = 2) in vec3 color;\n"
    "uniform mat4 view, projection, previous_view, previous_projection;\n"
    "uniform vec3 offset, previous_offset;\n"
    "out vec3 v_normal; out vec3 v_color;\n"
    "void main() {\n"
    "    v_normal = mat3(view) * normal;\n"
    "    v_color = color;\n"
    "    dgb_vertex(projection * (view * vec4(position + offset, 1.0)),\n"
    "               previous_projection * (previous_view * vec4(position + previous_offset, 1.0)));\n"
    "}\n";

static const char fragment_body[] =
    "in vec3 v_normal; in vec3 v_color;\n"
    "void main() {\n"
    "    if (!dgb_keep()) discard;\n"
    "    dgb_store(vec4(v_color, 1.0), v_normal, vec2(0.5, 0.0), v_color * (1.5 + v_normal.y));\n"
    "}\n";

GLuint fixture_program(const dgb_context* context) {
    static const dgbgl_varying varyings[] = {{NULL, "vec3", "v_normal"}, {NULL, "vec3", "v_color"}};
    static char prefix[1 << 16];
    GLuint program = glCreateProgram();
    GLuint shaders[3];
    GLint ok = 0;
    int count = 0, i;
    if (!dgbgl_shader_prefix(context, DGBGL_VERTEX, varyings, 2, prefix, sizeof prefix)) return 0;
    shaders[count++] = compile(GL_VERTEX_SHADER, prefix, vertex_body);
    if (dgbgl_geometry_shader(context, varyings, 2, prefix, sizeof prefix))
        shaders[count++] = compile(GL_GEOMETRY_SHADER, prefix, "");
    dgbgl_shader_prefix(context, DGBGL_FRAGMENT, varyings, 2, prefix, sizeof prefix);
    shaders[count++] = compile(GL_FRAGMENT_SHADER, prefix, fragment_body);
    for (i = 0; i < count; ++i) {
        if (!shaders[i]) return 0;
        glAttachShader(program, shaders[i]);
        glDeleteShader(shaders[i]);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (!ok) {
        char log[2048];
        glGetProgramInfoLog(program, (GLsizei)sizeof log, NULL, log);
        printf("# %s\n", log);
        return 0;
    }
    if (dgbgl_attach_program(context, program) == DGB_OK) return program;
    glDeleteProgram(program);
    return 0;
}

static void set_matrix(GLuint program, const char* name, const float m[16]) {
    glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, m);
}

static void set_offset(GLuint program, const char* name, float x) {
    glUniform3f(glGetUniformLocation(program, name), x, 0.0f, 0.0f);
}

static void draw_room(const fixture_draw_user* u, const dgb_draw* draw) {
    const fixture* f = u->f;
    if (draw->back_faces) glEnable(GL_CULL_FACE), glCullFace(GL_FRONT); /* the library disables it again */
    glUseProgram(u->program);
    glBindVertexArray(f->vertex_array);
    set_matrix(u->program, "view", draw->view);
    set_matrix(u->program, "projection", draw->projection);
    set_matrix(u->program, "previous_view", draw->previous_view);
    set_matrix(u->program, "previous_projection", draw->previous_projection);
    set_offset(u->program, "offset", 0.0f);
    set_offset(u->program, "previous_offset", 0.0f);
    glDrawArraysInstanced(GL_TRIANGLES, 0, f->static_count, draw->instances);
    set_offset(u->program, "offset", f->offsets[2 + draw->pose]);
    set_offset(u->program, "previous_offset", f->offsets[1 + draw->pose]);
    glDrawArraysInstanced(GL_TRIANGLES, f->static_count, f->moving_count, draw->instances);
}

static void draw_and_count(const fixture_draw_user* u, const dgb_draw* draw) {
    GLuint query;
    GLuint64 count = 0;
    glGenQueries(1, &query);
    glBeginQuery(GL_VERTEX_SHADER_INVOCATIONS_ARB, query);
    draw_room(u, draw);
    glEndQuery(GL_VERTEX_SHADER_INVOCATIONS_ARB);
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &count);
    glDeleteQueries(1, &query);
    u->f->vertices_shaded += (long long)count;
}

void fixture_draw(void* user, const dgb_draw* draw) {
    const fixture_draw_user* u = (const fixture_draw_user*)user;
    ++u->f->draws;
    if (u->nothing) return;
    if (u->f->counts_vertices)
        draw_and_count(u, draw);
    else
        draw_room(u, draw);
}

int fixture_count_objects(void) {
    GLuint name;
    int count = 0;
    for (name = 1; name < 4096; ++name)
        count += glIsTexture(name) + glIsBuffer(name) + glIsFramebuffer(name) + glIsProgram(name) + glIsShader(name) +
                 glIsSampler(name) + glIsVertexArray(name) + glIsQuery(name);
    return count;
}

static size_t texture_bytes(GLuint name) {
    static const GLenum sizes[] = {GL_TEXTURE_RED_SIZE,   GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE,
                                   GL_TEXTURE_ALPHA_SIZE, GL_TEXTURE_DEPTH_SIZE, GL_TEXTURE_STENCIL_SIZE};
    GLint width = 1, height, depth, size, level;
    size_t bits, bytes = 0, i;
    for (level = 0; level < 15; ++level) {
        glGetTextureLevelParameteriv(name, level, GL_TEXTURE_WIDTH, &width);
        if (width == 0) break;
        glGetTextureLevelParameteriv(name, level, GL_TEXTURE_HEIGHT, &height);
        glGetTextureLevelParameteriv(name, level, GL_TEXTURE_DEPTH, &depth);
        for (bits = i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
            glGetTextureLevelParameteriv(name, level, sizes[i], &size);
            bits += (size_t)size;
        }
        bytes += (size_t)width * (size_t)height * (size_t)depth * bits / 8;
    }
    return bytes;
}

size_t fixture_count_bytes(void) {
    GLint64 size;
    GLuint name;
    size_t bytes = 0;
    for (name = 1; name < 4096; ++name) {
        if (glIsTexture(name)) bytes += texture_bytes(name);
        if (!glIsBuffer(name)) continue;
        glGetNamedBufferParameteri64v(name, GL_BUFFER_SIZE, &size);
        bytes += (size_t)size;
    }
    return bytes;
}

size_t fixture_count_heap(void) {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
#else
    return 0;
#endif
}

/* >> reading */

float* fixture_read(dgb_texture texture, int level, int layer, int width, int height, int layers, GLenum format,
                    int channels) {
    const GLenum target = layers ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    const size_t image = (size_t)width * (size_t)height * (size_t)channels;
    float* all = (float*)malloc(image * (size_t)(layers ? layers : 1) * sizeof(float));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glBindTexture(target, dgbgl_texture_name(texture));
    glGetTexImage(target, level, format, GL_FLOAT, all);
    glBindTexture(target, 0);
    if (layers) memmove(all, all + image * (size_t)layer, image * sizeof(float));
    return all;
}

static const GLenum formats[] = {0, GL_RED, GL_RG, GL_RGB, GL_RGBA}; /* by channels */

float* fixture_image(const dgb_context* c, dgb_slot slot, int level, int channels) {
    const dgb_texture texture = dgb_get_texture(c, slot);
    if (!texture.id) return NULL;
    return fixture_read(texture, level, 0, c->plan.width >> level, c->plan.height >> level, 0, formats[channels],
                        channels);
}

float* fixture_z(const dgb_context* c, int level) {
    const int layers = c->plan.layers < DGB_MAX_SHADED_LAYERS ? c->plan.layers : DGB_MAX_SHADED_LAYERS;
    const int count = layers * (c->plan.width >> level) * (c->plan.height >> level);
    float* z = fixture_image(c, DGB_Z, level, layers);
    int i;
    for (i = 0; i < count; ++i) z[i] = z[i] == DGB_EMPTY_Z ? 0.0f : z[i];
    return z;
}

void fixture_put_image(const dgb_context* c, dgb_slot slot, int channels, const float* texels) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glBindTexture(GL_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(c, slot)));
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, c->plan.width, c->plan.height, formats[channels], GL_FLOAT, texels);
    glBindTexture(GL_TEXTURE_2D, 0);
}

void fixture_shaded_rect(const dgb_context* c, const dgb_params* q, int rect[4]) {
    const int inset = c->desc.guard_band - (int)floor((double)q->guard_fraction * c->desc.guard_band + 0.5);
    rect[0] = rect[1] = inset;
    rect[2] = c->plan.width - inset - 1;
    rect[3] = c->plan.height - inset - 1;
}

void fixture_blank_unshaded(const dgb_context* c, float* image, int channels) {
    int rect[4], x, y, k;
    if (!image) return;
    fixture_shaded_rect(c, &c->shaded_params, rect);
    for (y = 0; y < c->plan.height; ++y)
        for (x = 0; x < c->plan.width; ++x) {
            if (x >= rect[0] && y >= rect[1] && x <= rect[2] && y <= rect[3]) continue;
            for (k = 0; k < channels; ++k) image[(y * c->plan.width + x) * channels + k] = 0.0f;
        }
}

float* fixture_shaded(const dgb_context* c, dgb_slot slot, int channels) {
    float* image = fixture_image(c, slot, 0, channels);
    fixture_blank_unshaded(c, image, channels);
    return image;
}

/* A number of 6 bits of exponent and 10 of mantissa. */
static float unpack(uint32_t code) {
    const int exponent = (int)(code >> 10);
    return exponent ? (float)ldexp(1024.0 + (code & 1023u), exponent - 57) : 0.0f;
}

float* fixture_read_half(dgb_texture texture, int width, int height, float** ao) {
    const size_t count = (size_t)width * (size_t)height;
    uint32_t* texels;
    float* light;
    size_t i, k;
    if (!texture.id) return NULL;
    texels = (uint32_t*)malloc(4 * count * sizeof *texels);
    light = (float*)malloc(4 * count * sizeof *light);
    if (ao) *ao = (float*)malloc(count * sizeof **ao);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glBindTexture(GL_TEXTURE_2D, dgbgl_texture_name(texture));
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, texels);
    glBindTexture(GL_TEXTURE_2D, 0);
    for (i = 0; i < count; ++i) {
        for (k = 0; k < 4; ++k) light[4 * i + k] = unpack(texels[4 * i + 2 + k / 2] >> (16 * (k % 2)) & 0xffffu);
        if (ao) (*ao)[i] = (float)(texels[4 * i + 1] >> 16) / 65535.0f;
    }
    free(texels);
    return light;
}
