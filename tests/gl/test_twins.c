/* Every public function of mathematics against its GLSL twin: a shader made of the library's own text
   evaluates it for 65,536 cases whose inputs come from a texture, so that nothing is folded at compile
   time. */
#include "gl_fixture.h"
#include "numbers.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 256, CASES = SIDE * SIDE, MAX_TEXELS = 5 };

static fixture f;

/* >> evaluation on the device */

/* The library's text up to the part that belongs to one pass: its last #line. */
static const char* library_text(void) {
    static char text[1 << 16];
    const dgb_program_desc ao = {DGB_PASS_AO,
                                 4,
                                 {{"DGB_LAYERS", 2},
                                  {"DGB_DIVISOR", 1},
                                  {"DGB_NORMAL_TEST", 0},
                                  {"DGB_BITMASK_LIGHT", 0}}}; /* with all that is shared */
    const size_t size = dgbgl_pass_source(&ao, DGBGL_FRAGMENT, f.gl.version, false, text, sizeof text);
    char *line = text, *last = NULL;
    assert_true(size > 0 && size < sizeof text);
    while ((line = strstr(line, "#line")) != NULL) last = line++;
    assert_non_null(last);
    if (last) *last = 0;
    assert_non_null(strstr(text, "dgb_oct16_encode"));
    assert_non_null(strstr(text, "dgb_tap_at"));
    assert_non_null(strstr(text, "dgb_sectors"));
    return text;
}

static const char vertex_text[] =
    "#version 330 core\n"
    "void main() {\n"
    "    vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1));\n"
    "    gl_Position = vec4(corner - 1.0, 0.0, 1.0);\n"
    "}\n";

static const char input_text[] = "uniform sampler2D twin_inputs;\n"
                                 "uniform int twin_texels;\n"
                                 "vec4 given(int k) {\n"
                                 "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
                                 "    return texelFetch(twin_inputs, ivec2(p.x * twin_texels + k, p.y), 0);\n"
                                 "}\n";

static const char helper_text[] =
    "dgb_camera given_camera() { return dgb_camera(given(1), given(2), given(3), given(4)); }\n"
    "uvec4 bits(float x) { return uvec4(floatBitsToUint(x), 0u, 0u, 0u); }\n"
    "uvec4 bits(vec3 v) { return uvec4(floatBitsToUint(v), 0u); }\n"
    "uvec4 twin_tap(dgb_tap t) { return uvec4(t.texel.x | t.texel.y << 16, t.level + 16 * int(t.inside), t.pixel); }\n";

static GLuint compile(GLenum stage, const char* const* texts, int count) {
    GLuint shader = glCreateShader(stage);
    GLint ok = 0;
    char log[2048];
    glShaderSource(shader, count, texts, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        glGetShaderInfoLog(shader, (GLsizei)sizeof log, NULL, log);
        printf("# %s\n", log);
    }
    assert_true(ok);
    return shader;
}

static GLuint link_fragment(const char* const* fragment_texts, int count) {
    const char* const vertex = vertex_text;
    const GLuint shaders[] = {compile(GL_VERTEX_SHADER, &vertex, 1),
                              compile(GL_FRAGMENT_SHADER, fragment_texts, count)};
    GLuint program = glCreateProgram();
    GLint ok = 0;
    int i;
    for (i = 0; i < 2; ++i) {
        glAttachShader(program, shaders[i]);
        glDeleteShader(shaders[i]);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    assert_true(ok);
    return program;
}

static GLuint texture_of(GLint internal, int width, int height, GLenum format, GLenum type, const void* texels) {
    GLuint name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    return name;
}

static GLuint rotation_texture(void) {
    float table[DGB_ROTATION_COUNT][2];
    int i;
    for (i = 0; i < DGB_ROTATION_COUNT; ++i) dgb_rotation(i, table[i]);
    return texture_of(GL_RG32F, DGB_ROTATION_COUNT, 1, GL_RG, GL_FLOAT, table);
}

/* Draws a full screen of cases into `target` with the inputs in unit 0 and the rotations in unit 1. */
static void draw_cases(GLuint program, GLuint inputs, int texels, GLuint target) {
    const GLuint rotations = rotation_texture();
    GLuint framebuffer, vertex_array;
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    assert_int_equal(glCheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    glViewport(0, 0, SIDE, SIDE);
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "twin_texels"), texels);
    glUniform1i(glGetUniformLocation(program, "dgb_rotations"), 1);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, rotations);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, inputs);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteVertexArrays(1, &vertex_array);
    glDeleteTextures(1, &rotations);
    glUseProgram(0);
}

static float in[CASES][MAX_TEXELS][4]; /* what the cases are given */
static uint32_t out[CASES][4];         /* what the device made of it */

static GLuint upload_inputs(int texels) {
    float* packed = (float*)malloc(sizeof(float) * (size_t)(CASES * texels * 4));
    GLuint name;
    int i;
    for (i = 0; i < CASES; ++i) memcpy(packed + (size_t)(i * texels * 4), in[i], (size_t)texels * 4 * sizeof(float));
    name = texture_of(GL_RGBA32F, SIDE * texels, SIDE, GL_RGBA, GL_FLOAT, packed);
    free(packed);
    return name;
}

static GLuint program_of(const char* declaration, const char* statement) {
    const char* texts[] = {library_text(), input_text, helper_text, declaration, "void main() {\n", statement, "}\n"};
    return link_fragment(texts, 7);
}

/* Fills out[] with what a program makes of the inputs, and deletes it. */
static void run(GLuint program, int texels) {
    const GLuint inputs = upload_inputs(texels),
                 target = texture_of(GL_RGBA32UI, SIDE, SIDE, GL_RGBA_INTEGER, GL_UNSIGNED_INT, NULL);
    draw_cases(program, inputs, texels, target);
    glBindTexture(GL_TEXTURE_2D, target);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, out);
    glDeleteTextures(1, &inputs);
    glDeleteTextures(1, &target);
    glDeleteProgram(program);
}

/* Fills out[] with `expression`, a uvec4 of given(0)...given(texels - 1). */
static void evaluate(const char* expression, int texels) {
    char statement[1024];
    assert_true(strlen(expression) + 32 < sizeof statement);
    sprintf(statement, "    twin_out = %s;\n", expression);
    run(program_of("layout(location = 0) out uvec4 twin_out;\n", statement), texels);
}

/* >> inputs */

static uint64_t random_state;

/* Before each test: its cases are the same whichever tests ran before. */
static int seed(void** state) {
    (void)state;
    random_state = 1u;
    return 0;
}

#define TWIN(test) cmocka_unit_test_setup(test, seed)

static float random_in(float low, float high) {
    return low + (high - low) * (float)((double)random_bits(&random_state) / 4294967296.0);
}

/* log-uniform, of either sign */
static float random_size(float low, float high) {
    const float x = expf(random_in(logf(low), logf(high)));
    return random_bits(&random_state) & 1u ? -x : x;
}

static const uint32_t special_bits[] = {0x00000000u, 0x80000000u, 0x00000001u, 0x80000001u, 0x007fffffu, 0x00800000u,
                                        0x7f7fffffu, 0xff7fffffu, 0x7f800000u, 0xff800000u, 0x7fc00000u, 0xffc00000u,
                                        0x7f800001u, 0x3f800000u, 0xbf800000u, 0x3f000000u, 0x477c0000u, 0x477c0001u,
                                        0x5f000000u, 0xdf000000u, 0x7e967699u, 0x0da24260u};

/* A number that makes trouble, or any bit pattern. */
static float random_pattern(void) {
    const uint32_t kind = random_bits(&random_state) % 4u;
    if (kind == 0u) return from_bits(random_bits(&random_state));
    return from_bits(special_bits[random_bits(&random_state) % (sizeof special_bits / sizeof special_bits[0])]);
}

/* One case in eight holds trouble somewhere. */
static bool is_hostile(int i) { return i % 8 == 7; }

static void make_hostile(float* values, int count) {
    int k;
    for (k = 0; k < count; ++k)
        if (random_bits(&random_state) % 3u == 0u) values[k] = random_pattern();
}

static void random_vector(float length, float v[3]) {
    int k;
    for (k = 0; k < 3; ++k) v[k] = random_in(-length, length);
}

static void random_normal(float n[3]) { dgb_oct16_decode((uint16_t)random_bits(&random_state), n); }

static bool is_subnormal(float x) { return (bits_of(x) & 0x7fffffffu) - 1u < 0x7fffffu; }

static bool has_subnormal(const float* values, int count) {
    int k;
    for (k = 0; k < count; ++k)
        if (is_subnormal(values[k])) return true;
    return false;
}

/* Of a vector that is not zero v.v is subnormal or zero, or may be where each square is flushed: then a device finds no
   length, or one that is too short, and what is divided by it is anything. No surfaces are 1e-19 m apart. */
static bool square_underflows(const float v[3]) {
    const float d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return d2 < 4.0f * FLT_MIN && (v[0] != 0.0f || v[1] != 0.0f || v[2] != 0.0f);
}

/* >> comparison: the device may flush subnormals, nothing else is forgiven */

typedef struct tally {
    const char* name;
    double worst, sum;
    int count, other; /* other: one is 0 or not finite and the other is not */
} tally;

static bool is_zero(float x) { return fabsf(x) < FLT_MIN; }

/* scale: what the difference is measured in. */
static void compare(tally* t, float device, float host, double scale) {
    double error;
    ++t->count;
    if (!is_finite(device) || !is_finite(host)) {
        t->other += bits_of(device) != bits_of(host);
        return;
    }
    error = fabs((double)device - (double)host) / (scale > 0.0 ? scale : 1.0);
    if (is_zero(device) && is_zero(host)) error = 0.0;
    t->sum += error;
    t->worst = error > t->worst ? error : t->worst;
}

static void check(const tally* t, double bound) {
    printf("# %-22s %6d cases: %.3g at most, %.3g on average (bound %.3g), %d of another kind\n", t->name, t->count,
           t->worst, t->count ? t->sum / t->count : 0.0, bound, t->other);
    assert_true(t->count >= CASES / 2);
    assert_int_equal(t->other, 0);
    assert_true(t->worst <= bound);
}

static tally tally_of(const char* name) {
    tally t = {NULL, 0.0, 0.0, 0, 0};
    t.name = name;
    return t;
}

static float device_float(int i, int channel) { return from_bits(out[i][channel]); }

static void check_equal(const char* name, int mismatches, int allowed) {
    printf("# %-22s %6d cases: %d mismatches\n", name, CASES, mismatches);
    assert_true(mismatches <= allowed);
}

/* >> packing */

/* Codes on the border of the map come in pairs of one direction: a flushed subnormal may pick the other. */
static bool same_direction(uint32_t a, uint32_t b) {
    float n[3], m[3];
    dgb_oct16_decode((uint16_t)a, n);
    dgb_oct16_decode((uint16_t)b, m);
    return fabsf(n[0] - m[0]) + fabsf(n[1] - m[1]) + fabsf(n[2] - m[2]) < 1e-6f;
}

static void test_oct16_encode(void** state) {
    enum { AXES = 450 };
    int i, k, random = 0, hostile = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const float size = random_size(1e-18f, 1e18f);
        random_vector(1.0f, in[i][0]);
        for (k = 0; k < 3; ++k) in[i][0][k] *= size;
        if (is_hostile(i)) make_hostile(in[i][0], 3);
    }
    for (i = 0; i < AXES; ++i) /* both directions of each axis, from tiny to huge */
        for (k = 0; k < 3; ++k) in[i][0][k] = k == i % 3 ? ldexpf(i / 3 % 2 ? -1.0f : 1.0f, i / 2 - 120) : 0.0f;
    evaluate("uvec4(uvec2(dgb_oct16_encode(given(0).xyz) * 255.0 + 0.5), 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i) {
        const uint32_t code = dgb_oct16_encode(in[i][0]), device = out[i][0] | out[i][1] << 8;
        if (is_hostile(i) || i < AXES)
            hostile += device != code && !same_direction(device, code);
        else
            random += device != code;
    }
    check_equal("oct16 encode", random, CASES / 100000);
    check_equal("oct16 encode, hostile", hostile, 0);
}

static void test_oct16_decode(void** state) {
    tally t = tally_of("oct16 decode");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        in[i][0][0] = (float)(i & 255) / 255.0f;
        in[i][0][1] = (float)(i >> 8) / 255.0f;
    }
    evaluate("bits(dgb_oct16_decode(given(0).xy))", 1);
    for (i = 0; i < CASES; ++i) {
        float n[3];
        dgb_oct16_decode((uint16_t)i, n);
        for (k = 0; k < 3; ++k) compare(&t, device_float(i, k), n[k], 1.0);
    }
    check(&t, 4.8e-7);
}

static void fill_patterns(int channels) {
    int i, k;
    for (i = 0; i < CASES; ++i)
        for (k = 0; k < channels; ++k) in[i][0][k] = i % 2 ? random_pattern() : random_size(1e-10f, 1e7f);
}

static void test_storable(void** state) {
    int i, mismatches = 0;
    (void)state;
    fill_patterns(1);
    evaluate("bits(dgb_storable(given(0).x))", 1);
    for (i = 0; i < CASES; ++i) {
        const float host = dgb_storable(in[i][0][0]), device = device_float(i, 0);
        mismatches += bits_of(host) != bits_of(device) && !(is_subnormal(host) && device == 0.0f);
    }
    check_equal("storable", mismatches, 0);
}

/* What reaches a texture of 10-bit, 11-bit or half floats: never NaN or infinity; what C packs, or the code
   below. */
static void check_store(GLint internal, GLenum format, GLenum type, const char* statement, void* codes) {
    const GLuint inputs = upload_inputs(1), target = texture_of(internal, SIDE, SIDE, GL_RGBA, GL_FLOAT, NULL);
    const GLuint program = program_of("layout(location = 0) out vec4 twin_out;\n", statement);
    draw_cases(program, inputs, 1, target);
    glBindTexture(GL_TEXTURE_2D, target);
    glGetTexImage(GL_TEXTURE_2D, 0, format, type, codes);
    glDeleteTextures(1, &inputs);
    glDeleteTextures(1, &target);
    glDeleteProgram(program);
}

static bool equal_or_below(uint32_t device, uint32_t host) { return device == host || device + 1u == host; }

static void test_r11g11b10f_store(void** state) {
    static uint32_t codes[CASES];
    int i, mismatches = 0;
    (void)state;
    fill_patterns(3);
    check_store(GL_R11F_G11F_B10F, GL_RGB, GL_UNSIGNED_INT_10F_11F_11F_REV,
                "    twin_out = vec4(dgb_storable(given(0).rgb), 1.0);\n", codes);
    for (i = 0; i < CASES; ++i) {
        const uint32_t host = dgb_r11g11b10f_pack(in[i][0]), device = codes[i];
        float rgb[3];
        int k;
        dgb_r11g11b10f_unpack(device, rgb);
        for (k = 0; k < 3; ++k) assert_true(rgb[k] >= 0.0f && rgb[k] <= 65024.0f); /* no NaN, no infinity */
        mismatches +=
            !(equal_or_below(device & 2047u, host & 2047u) &&
              equal_or_below(device >> 11 & 2047u, host >> 11 & 2047u) && equal_or_below(device >> 22, host >> 22));
    }
    check_equal("R11G11B10F store", mismatches, 0);
}

static void test_half_store(void** state) {
    static uint16_t codes[CASES][4];
    int i, k, mismatches = 0;
    (void)state;
    fill_patterns(3);
    check_store(GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, "    twin_out = vec4(dgb_storable(given(0).rgb), 1.0);\n", codes);
    for (i = 0; i < CASES; ++i)
        for (k = 0; k < 3; ++k) {
            const float value = dgb_half_to_float(codes[i][k]);
            assert_true(value >= 0.0f && value <= DGB_MAX_RADIANCE);
            mismatches += !equal_or_below(codes[i][k], dgb_half_from_float(dgb_storable(in[i][0][k])));
        }
    check_equal("RGBA16F store", mismatches, 0);
}

static void test_dithered(void** state) {
    int i, k, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        for (k = 0; k < 4; ++k) in[i][0][k] = random_size(1e-9f, 65504.0f), in[i][1][k] = random_in(0.0f, 1.0f);
        if (is_hostile(i)) make_hostile(in[i][0], 4);
    }
    evaluate("floatBitsToUint(dgb_dithered(given(0), given(1)))", 2);
    for (i = 0; i < CASES; ++i)
        for (k = 0; k < 4; ++k) {
            const float host = dgb_dithered(in[i][0][k], in[i][1][k]), device = device_float(i, k);
            mismatches += device != host && bits_of(device) != bits_of(host) && !(isnan(device) && isnan(host));
        }
    check_equal("dithered", mismatches, 0);
}

/* >> integers: hash, MIP level and source */

static void test_pixel_hash(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) { /* a corner of the image densely, then anywhere, then any frame */
        in[i][0][0] = (float)(i < 16384 ? i % 128 : (int)(random_bits(&random_state) % 16385u));
        in[i][0][1] = (float)(i < 16384 ? i / 128 : (int)(random_bits(&random_state) % 16385u));
        in[i][0][2] = (float)(i < 32768 ? 0 : (int)(random_bits(&random_state) % 16777216u) - 8388608);
    }
    evaluate("uvec4(dgb_pixel_hash(ivec2(given(0).xy), int(given(0).z)), 0u, 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i)
        mismatches += (int)out[i][0] != dgb_pixel_hash((int)in[i][0][0], (int)in[i][0][1], (int)in[i][0][2]);
    check_equal("pixel hash", mismatches, 0);
}

static void test_pixel_pair(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        in[i][0][0] = (float)(i < 16384 ? i % 128 : (int)(random_bits(&random_state) % 16385u));
        in[i][0][1] = (float)(i < 16384 ? i / 128 : (int)(random_bits(&random_state) % 16385u));
        in[i][0][2] = (float)(i < 32768 ? i % 3 : (int)(random_bits(&random_state) % 16777216u) - 8388608);
    }
    evaluate("bits(vec3(dgb_pixel_pair(ivec2(given(0).xy), int(given(0).z)), 0.0))", 1);
    for (i = 0; i < CASES; ++i) {
        float u[2];
        dgb_pixel_pair((int)in[i][0][0], (int)in[i][0][1], (int)in[i][0][2], u);
        mismatches += out[i][0] != bits_of(u[0]) || out[i][1] != bits_of(u[1]);
    }
    check_equal("pixel pair", mismatches, 0);
}

static void test_pixel_quad(void** state) {
    int i, k, mismatches = 0, misplaced = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) { /* two squares of the curve and more, then anywhere, on either side of 0 */
        in[i][0][0] = (float)(i < 16384 ? i % 128 : (int)(random_bits(&random_state) % 16777216u) - 8388608);
        in[i][0][1] = (float)(i < 16384 ? i / 128 : (int)(random_bits(&random_state) % 16777216u) - 8388608);
        in[i][0][2] = (float)(i < 32768 ? i % 3 : (int)(random_bits(&random_state) % 16777216u) - 8388608);
    }
    evaluate("floatBitsToUint(dgb_pixel_quad(ivec2(given(0).xy), int(given(0).z)))", 1);
    for (i = 0; i < CASES; ++i) {
        float u[4];
        dgb_pixel_quad((int)in[i][0][0], (int)in[i][0][1], (int)in[i][0][2], u);
        for (k = 0; k < 4; ++k) mismatches += out[i][k] != bits_of(u[k]);
    }
    check_equal("pixel quad", mismatches, 0);
    evaluate("uvec4(dgb_hilbert_index(ivec2(given(0).xy)), 0u, 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i) misplaced += (int)out[i][0] != dgb_hilbert_index((int)in[i][0][0], (int)in[i][0][1]);
    check_equal("Hilbert index", misplaced, 0);
}

static void test_mip_level(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) { /* every power of two, the float before it and the float after */
        in[i][0][0] =
            i < 16 * 765 ? from_bits(((uint32_t)(i / 3 % 255) << 23) + (uint32_t)(i % 3) - 1u) : random_pattern();
        in[i][0][1] = (float)(i / 765 % 5);
        in[i][0][2] = (float)(random_bits(&random_state) % 3u);
        in[i][0][3] = in[i][0][2] + (float)(random_bits(&random_state) % 4u);
    }
    evaluate("uvec4(dgb_mip_level(given(0).x, int(given(0).y), int(given(0).z), int(given(0).w)), 0u, 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i)
        mismatches +=
            (int)out[i][0] != dgb_mip_level(in[i][0][0], (int)in[i][0][1], (int)in[i][0][2], (int)in[i][0][3]);
    check_equal("mip level", mismatches, 0);
}

static void test_mip_source(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const int level = i % DGB_MAX_LEVELS;
        in[i][0][0] = (float)(random_bits(&random_state) % (unsigned)(DGB_MAX_SIZE >> level));
        in[i][0][1] = (float)(random_bits(&random_state) % (unsigned)(DGB_MAX_SIZE >> level));
        in[i][0][2] = (float)level;
    }
    evaluate("uvec4(dgb_mip_source(ivec2(given(0).xy), int(given(0).z)), 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i) {
        const int p[2] = {(int)in[i][0][0], (int)in[i][0][1]};
        int source[2];
        dgb_mip_source(p, (int)in[i][0][2], source);
        mismatches += (int)out[i][0] != source[0] || (int)out[i][1] != source[1];
    }
    check_equal("mip source", mismatches, 0);
}

/* >> camera */

/* Cameras of every kind: i picks one. */
static dgb_camera camera_of(int i) {
    fixture_view v = fixture_default_view();
    dgb_view view;
    dgb_camera camera;
    const float jitter[2] = {0.3f, -0.45f};
    float widened[16];
    v.fov = i % 5 == 4 ? 0.0f : 20.0f + 30.0f * (float)(i % 4);
    v.reversed = i / 2 % 2 != 0;
    v.clip = i % 2 ? DGB_CLIP_ZERO_TO_ONE : DGB_CLIP_NEGATIVE_ONE_TO_ONE;
    v.far_plane = v.reversed && v.fov > 0.0f && i / 4 % 2 ? 0.0f : 1000.0f;
    view = fixture_dgb_view(&v, 1280, 720);
    view.projection[v.fov > 0.0f ? 8 : 12] += 0.2f * (float)(i % 3 - 1);
    view.projection[v.fov > 0.0f ? 9 : 13] -= 0.1f * (float)(i % 7 - 3);
    dgb_widen_projection(view.projection, 1280, 720, 64, jitter, widened);
    assert_int_equal(dgb_camera_from_matrix(widened, 1408, 848, v.clip, v.reversed, &camera), DGB_OK);
    return camera;
}

static void give_camera(int i, dgb_camera* camera) {
    *camera = camera_of(i % 840);
    memcpy(in[i][1], camera->linearise, sizeof in[i][1]);
    memcpy(in[i][2], camera->position_z, sizeof in[i][2]);
    memcpy(in[i][3], camera->position_1, sizeof in[i][3]);
    memcpy(in[i][4], camera->footprint, sizeof in[i][4]);
}

static void test_depth_code(void** state) {
    static const float codes[] = {65535.0f, 16777215.0f, 0.0f, -1.0f};
    tally t = tally_of("depth code, ulps");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        in[i][0][0] = is_hostile(i) ? random_pattern() : random_in(0.0f, 1.0f);
        if (i % 8 == 6)
            in[i][0][0] = ((float)(random_bits(&random_state) % 65535u) + 0.5f) / 65535.0f; /* half-way between codes */
        in[i][0][1] = codes[i % 4];
    }
    evaluate("bits(dgb_depth_code(given(0).x, given(0).y))", 1);
    for (i = 0; i < CASES; ++i) {
        const float host = dgb_depth_code(in[i][0][0], in[i][0][1]);
        compare(&t, device_float(i, 0), host, FLT_EPSILON * fabs((double)host));
    }
    check(&t, 0.0);
}

static void test_linear_z(void** state) {
    tally t = tally_of("linear z, ulps");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera;
        give_camera(i, &camera);
        in[i][0][0] = random_in(0.0f, 1.0f);
        if (i % 3 == 0) in[i][0][0] = fabsf(camera.footprint[3] - expf(random_in(-20.0f, 0.0f))); /* far away */
        if (is_hostile(i)) in[i][0][0] = random_pattern();
    }
    evaluate("bits(dgb_linear_z(given(0).x, given_camera()))", 5);
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera = camera_of(i % 840);
        const float host = dgb_linear_z(in[i][0][0], &camera);
        if (is_subnormal(in[i][0][0]) || is_subnormal(host)) continue; /* flushed */
        t.other += (host == 0.0f) != (device_float(i, 0) == 0.0f);
        compare(&t, device_float(i, 0), host, FLT_EPSILON * fabs((double)host));
    }
    check(&t, 1.0);
}

static void test_position(void** state) {
    tally t = tally_of("position, epsilons");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera;
        give_camera(i, &camera);
        in[i][0][0] = (float)(random_bits(&random_state) % 1408u) + 0.5f;
        in[i][0][1] = (float)(random_bits(&random_state) % 848u) + 0.5f;
        in[i][0][2] = -fabsf(random_size(0.01f, 1e6f));
    }
    evaluate("bits(dgb_position(given(0).xy, given(0).z, given_camera()))", 5);
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera = camera_of(i % 840);
        float point[3];
        dgb_position(in[i][0][0], in[i][0][1], in[i][0][2], &camera, point);
        for (k = 0; k < 3; ++k) { /* x and y in units of the largest number that their sums hold */
            const double scale = k == 2 ? 1.0 : fabs((double)in[i][0][2]) + 1e3 * fabs((double)camera.position_1[k]);
            compare(&t, device_float(i, k), point[k], FLT_EPSILON * scale);
        }
    }
    check(&t, 4.0);
}

/* The origin is what the pixel of the case shows. Against the difference of two positions, in double. */
static void test_offset(void** state) {
    tally t = tally_of("offset, epsilons");
    int i, k, nonzero = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const int column = i % SIDE, row = i / SIDE;
        const float origin[2] = {(float)column + 0.5f, (float)row + 0.5f};
        const float away = i % 3 ? 9.0f : 1408.0f;
        dgb_camera camera;
        give_camera(i, &camera);
        for (k = 0; k < 2; ++k) in[i][0][k] = origin[k] + floorf(random_in(-away, away));
        in[i][0][2] = in[i][0][3] = -fabsf(random_size(0.01f, 1e6f));
        if (i % 4) in[i][0][3] *= i % 4 > 1 ? 1.001f : random_in(0.1f, 10.0f);
        if (i % 20 == 0) memcpy(in[i][0], origin, sizeof origin); /* the origin itself */
    }
    evaluate("bits(dgb_offset(given(0).xy, given(0).z, dgb_origin_at(gl_FragCoord.xy, given(0).w, given_camera()),"
             " given_camera()))",
             5);
    for (i = 0; i < CASES; ++i) {
        const dgb_camera camera = camera_of(i % 840);
        const float* a = camera.position_z;
        const float* b = camera.position_1;
        const double z = (double)in[i][0][2], from = (double)in[i][0][3];
        for (k = 0; k < 2; ++k) {
            const double p = (double)in[i][0][k], o = (k ? i / SIDE : i % SIDE) + 0.5;
            const double ak = (double)a[k], a_1 = (double)a[k + 2], bk = (double)b[k];
            const double host = (p * ak + a_1) * z + p * bk - ((o * ak + a_1) * from + o * bk);
            /* 5 roundings of what goes with the difference in depth, 4 of what goes with that in pixels, each half an
               epsilon of the largest number that its sums hold; and one of ours */
            const double scale =
                (fabs(p * ak) + fabs(a_1)) * fabs(z - from) + fabs(p - o) * (fabs(ak * from) + fabs(bk));
            compare(&t, device_float(i, k), (float)host, FLT_EPSILON * (scale + (double)FLT_MIN));
            nonzero += i % 20 == 0 && device_float(i, k) != 0.0f;
        }
        compare(&t, device_float(i, 2), in[i][0][2] - in[i][0][3], FLT_EPSILON);
    }
    check(&t, 3.0);
    check_equal("offset of the origin", nonzero, 0);
}

static void test_pixels_per_metre(void** state) {
    tally t = tally_of("pixels a metre, ulps");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera;
        give_camera(i, &camera);
        in[i][0][0] = is_hostile(i) ? random_pattern() : random_size(0.01f, 1e6f);
    }
    evaluate("bits(dgb_pixels_per_metre(given(0).x, given_camera()))", 5);
    for (i = 0; i < CASES; ++i) {
        dgb_camera camera = camera_of(i % 840);
        const float host = dgb_pixels_per_metre(in[i][0][0], &camera);
        if (is_subnormal(in[i][0][0])) continue;
        compare(&t, device_float(i, 0), host, FLT_EPSILON * fabs((double)host));
    }
    check(&t, 1.0);
}

/* >> terms */

static void test_keep_test(void** state) {
    int i, mismatches = 0, kept = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        in[i][0][0] = random_in(-20.0f, 0.0f);
        in[i][0][1] = i % 4 == 1 ? in[i][0][0] : random_in(-20.0f, 0.0f);
        in[i][0][2] = i % 3 ? 0.5f : 0.0f;
        if (i % 16 == 5) in[i][0][1] = in[i][0][0] + in[i][0][2]; /* on the edge */
        if (is_hostile(i)) make_hostile(in[i][0], 3);
    }
    evaluate("uvec4(dgb_keep_test(given(0).x, given(0).y, given(0).z) ? 1u : 0u, 0u, 0u, 0u)", 1);
    for (i = 0; i < CASES; ++i) {
        const bool host = dgb_keep_test(in[i][0][0], in[i][0][1], in[i][0][2]);
        if (has_subnormal(in[i][0], 3)) continue;
        mismatches += host != (out[i][0] == 1u);
        kept += host;
    }
    assert_true(kept > CASES / 8 && kept < CASES * 7 / 8);
    check_equal("keep test", mismatches, 0);
}

/* Offset in texel 0, normal in texel 1. */
static void give_offset_and_normal(int i, float radius) {
    random_vector(radius * 1.2f, in[i][0]);
    if (i % 4 == 0) random_vector(radius * 0.01f, in[i][0]);
    random_normal(in[i][1]);
    if (is_hostile(i)) make_hostile(in[i][0], 3);
}

static void test_ao_term(void** state) {
    tally t = tally_of("ao term");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const float r = fabsf(random_size(0.01f, 100.0f));
        give_offset_and_normal(i, r);
        in[i][2][0] = 1.0f / (r * r);
        in[i][2][1] = 0.02f * r;
        in[i][2][2] = i % 5 ? 0.001f * r * r : 0.0f;
        if (i % 100 == 0) memset(in[i][0], 0, sizeof in[i][0]);
    }
    evaluate("bits(dgb_ao_term(given(0).xyz, given(1).xyz, given(2).x, given(2).y, given(2).z))", 3);
    for (i = 0; i < CASES; ++i)
        compare(&t, device_float(i, 0), dgb_ao_term(in[i][0], in[i][1], in[i][2][0], in[i][2][1], in[i][2][2]), 1.0);
    check(&t, 1e-6);
}

static void test_ambient_visibility(void** state) {
    tally t = tally_of("ambient visibility");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const int count = 1 + (int)(random_bits(&random_state) % 256u);
        in[i][0][0] = is_hostile(i) ? random_pattern() : random_in(0.0f, (float)count * 0.4f);
        if (i % 8 == 6) in[i][0][0] = fabsf(random_size(1e-12f, 1.0f));
        in[i][0][1] = (float)(3.14159265358979323846 / count);
        in[i][0][2] = (float)count;
    }
    evaluate("bits(dgb_ambient_visibility(given(0).x, given(0).y))", 1);
    for (i = 0; i < CASES; ++i)
        compare(&t, device_float(i, 0), dgb_ambient_visibility(in[i][0][0], (int)in[i][0][2]), 1.0);
    check(&t, 3e-7);
}

static void test_gather_term(void** state) {
    static const float none[3] = {0.0f, 0.0f, 0.0f};
    tally t = tally_of("gather term");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        const float r = fabsf(random_size(0.01f, 100.0f));
        give_offset_and_normal(i, r);
        in[i][2][0] = r * r;
        if (i % 100 == 0) memset(in[i][0], 0, sizeof in[i][0]);
    }
    evaluate("bits(dgb_gather_term(given(0).xyz, given(1).xyz, given(2).x))", 3);
    for (i = 0; i < CASES; ++i)
        if (!square_underflows(in[i][0]))
            compare(&t, device_float(i, 0), dgb_gather_term(in[i][0], in[i][1], none, in[i][2][0], false), 1.0);
    check(&t, 1e-6);
}

static void test_gather_scale(void** state) {
    tally t = tally_of("gather scale, ulps");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        in[i][0][1] = (float)(random_bits(&random_state) % 513u);
        in[i][0][0] = random_in(0.0f, 1.0f) * in[i][0][1];
        in[i][0][2] = i % 2 ? 1.0f : 0.0f;
    }
    evaluate("bits(dgb_gather_scale(given(0).x, given(0).y, given(0).z))", 1);
    for (i = 0; i < CASES; ++i) {
        const float host = dgb_gather_scale(in[i][0][0], (int)in[i][0][1], in[i][0][2]);
        compare(&t, device_float(i, 0), host, FLT_EPSILON * (double)host);
    }
    check(&t, 1.0);
}

static void test_boost(void** state) {
    tally t = tally_of("boost");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        for (k = 0; k < 3; ++k) in[i][0][k] = random_in(-0.2f, 1.0f);
        if (i % 9 == 0) in[i][0][1] = in[i][0][2] = in[i][0][0];
        if (i % 100 == 0) memset(in[i][0], 0, sizeof in[i][0]);
        if (is_hostile(i)) make_hostile(in[i][0], 3);
        in[i][1][0] = i % 2 ? 0.0f : random_in(0.0f, 1.0f);
        in[i][1][1] = 1.0f;
    }
    evaluate("bits(dgb_boost(given(0).rgb, given(1).x, given(1).y))", 2);
    for (i = 0; i < CASES; ++i) {
        if (has_subnormal(in[i][0], 3)) continue; /* black, or a colour of its own */
        compare(&t, device_float(i, 0), dgb_boost(in[i][0], in[i][1][0], in[i][1][1]), 1.0);
    }
    check(&t, 3e-7);
}

static void test_bilateral_weight(void** state) {
    tally t = tally_of("bilateral weight");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        give_offset_and_normal(i, fabsf(random_size(0.001f, 10.0f))); /* offset, first normal */
        random_normal(in[i][2]);
        if (i % 2) memcpy(in[i][2], in[i][1], sizeof in[i][2]);
        in[i][3][0] = random_in(0.0f, 6.0f);
        in[i][3][1] = i % 3 ? random_in(0.0f, 2.0f) : 0.0f;
        if (i % 100 == 0) memset(in[i][0], 0, sizeof in[i][0]);
    }
    evaluate("bits(dgb_bilateral_weight(given(1).xyz, given(2).xyz, given(0).xyz, given(3).x, given(3).y))", 4);
    for (i = 0; i < CASES; ++i)
        if (!square_underflows(in[i][0]))
            compare(&t, device_float(i, 0),
                    dgb_bilateral_weight(in[i][1], in[i][2], in[i][0], in[i][3][0], in[i][3][1]), 1.0);
    check(&t, 3e-6);
}

/* >> the lobe */

static void test_ggx_alpha(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) in[i][0][0] = is_hostile(i) ? random_pattern() : random_in(-0.1f, 1.1f);
    evaluate("bits(dgb_ggx_alpha(given(0).x))", 1);
    for (i = 0; i < CASES; ++i) mismatches += device_float(i, 0) != dgb_ggx_alpha(in[i][0][0]);
    check_equal("ggx alpha", mismatches, 0);
}

/* v, n, alpha and u; one alpha in nine is 0. Nothing grazes so much that the root of what is left decides. */
static void give_lobe(int i) {
    float d;
    int k;
    do {
        random_normal(in[i][0]), random_normal(in[i][1]);
        for (d = 0.0f, k = 0; k < 3; ++k) d += in[i][0][k] * in[i][1][k];
    } while (d < 0.02f);
    in[i][2][0] = i % 9 ? dgb_ggx_alpha(random_in(0.0f, 1.0f)) : 0.0f;
    in[i][2][1] = random_in(0.001f, 0.999f);
    in[i][2][2] = random_in(0.001f, 0.999f);
}

static void test_ggx_normal(void** state) {
    tally t = tally_of("ggx normal");
    int i, k, mirrors = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) give_lobe(i);
    evaluate("bits(dgb_ggx_normal(given(0).xyz, given(1).xyz, given(2).x, given(2).yz))", 3);
    for (i = 0; i < CASES; ++i) {
        float h[3];
        dgb_ggx_normal(in[i][0], in[i][1], in[i][2][0], in[i][2] + 1, h);
        for (k = 0; k < 3; ++k) compare(&t, device_float(i, k), h[k], 1.0);
        for (k = 0; k < 3; ++k) mirrors += in[i][2][0] == 0.0f && device_float(i, k) != in[i][1][k];
    }
    check_equal("ggx normal, mirrors", mirrors, 0);
    check(&t,
          5e-5); /* near the rim of the cap the root of 1 - z^2 amplifies the last bits by 20, and halfway by 20 more */
}

static void test_ggx_density(void** state) {
    tally t = tally_of("ggx density");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) {
        float h[3], d = 0.0f;
        give_lobe(i);
        dgb_ggx_normal(in[i][0], in[i][1], in[i][2][0], in[i][2] + 1, h);
        for (k = 0; k < 3; ++k) d += in[i][0][k] * h[k];
        for (k = 0; k < 3; ++k) in[i][3][k] = 2.0f * d * h[k] - in[i][0][k]; /* l: where the lobe is */
        if (i % 5 == 0) random_normal(in[i][3]);
    }
    evaluate("bits(dgb_ggx_density(given(0).xyz, given(1).xyz, given(3).xyz, given(2).x))", 4);
    for (i = 0; i < CASES; ++i) {
        const float alpha = in[i][2][0], host = dgb_ggx_density(in[i][0], in[i][1], in[i][3], alpha);
        /* the last bits of h against the width of the lobe, as tests/unit/test_ggx.c has it */
        compare(&t, device_float(i, 0), host, (double)host * (1.0 + 0.2 / ((double)alpha + 1e-6)));
    }
    check(&t, 1e-5);
}

/* >> taps */

typedef struct tap_place {
    int texel[2], level, pixel[2], inside;
} tap_place;

static float clamped(float x, float high) { return x < 0.0f ? 0.0f : x > high ? high : x; }

static tap_place host_tap(int x, int y, int i, int count, float reach, const int size[2], const int levels[3]) {
    float tap[3], turn[2], h, direction[2];
    int axis;
    tap_place p;
    dgb_spiral_tap(i, count, tap);
    dgb_rotation(dgb_pixel_hash(x, y, 0), turn);
    direction[0] = tap[0] * turn[0] - tap[1] * turn[1];
    direction[1] = tap[0] * turn[1] + tap[1] * turn[0];
    h = reach * tap[2] > 0.75f ? reach * tap[2] : 0.75f;
    p.level = dgb_mip_level(h, levels[0], levels[1], levels[2]);
    p.inside = 1;
    for (axis = 0; axis < 2; ++axis) {
        const float at = (float)(axis ? y : x) + 0.5f + h * direction[axis];
        const int end = (size[axis] >> p.level) - 1;
        p.inside = p.inside && at >= 0.0f && at < (float)size[axis];
        p.texel[axis] = (int)clamped(at, (float)(size[axis] - 1)) >> p.level;
        p.texel[axis] = p.texel[axis] < end ? p.texel[axis] : end;
    }
    dgb_mip_source(p.texel, p.level, p.pixel);
    return p;
}

/* One reach, one tap a pixel of an image of SIDE x SIDE seen as a window of a buffer of the given size. */
static int tap_mismatches(float reach, int count, const int size[2], const int levels[3]) {
    int i, mismatches = 0;
    for (i = 0; i < CASES; ++i) {
        dgb_spiral_tap(i % count, count, in[i][0]);
        in[i][0][3] = reach;
        in[i][1][0] = (float)size[0];
        in[i][1][1] = (float)size[1];
        in[i][1][3] = 0.0f; /* frame */
        in[i][2][0] = (float)levels[0];
        in[i][2][1] = (float)levels[1];
        in[i][2][2] = (float)levels[2];
    }
    evaluate("twin_tap(dgb_tap_at(vec4(given(0).xyz, 0.0),"
             " dgb_spiral_at(gl_FragCoord.xy, given(0).w, ivec4(given(1))), ivec4(given(2))))",
             3);
    for (i = 0; i < CASES; ++i) {
        const tap_place p = host_tap(i % SIDE, i / SIDE, i % count, count, reach, size, levels);
        mismatches += out[i][0] != ((uint32_t)p.texel[0] | (uint32_t)p.texel[1] << 16) ||
                      (int)out[i][1] != p.level + 16 * p.inside || (int)out[i][2] != p.pixel[0] ||
                      (int)out[i][3] != p.pixel[1];
    }
    return mismatches;
}

static void test_tap_placement(void** state) {
    static const float reaches[] = {1.0f, 50.0f, 500.0f, 4000.0f};
    static const int counts[] = {14, 16, 99, 256}, sizes[][2] = {{256, 256}, {301, 277}, {4096, 2161}};
    const int levels[2][3] = {{DGB_AO_LOG2_Q, 0, 5}, {DGB_GATHER_LOG2_Q, 2, 5}};
    int reach, size, kind, total = 0;
    (void)state;
    for (reach = 0; reach < 4; ++reach)
        for (size = 0; size < 3; ++size)
            for (kind = 0; kind < 2; ++kind)
                total += tap_mismatches(reaches[reach], counts[(reach + size) % 4], sizes[size], levels[kind]);
    check_equal("tap placement, 24 times", total, 0);
}

/* >> visibility bitmask */

static void test_arc_sine(void** state) {
    tally t = tally_of("arc sine");
    int i;
    (void)state;
    for (i = 0; i < CASES; ++i) in[i][0][0] = random_in(-1.1f, 1.1f);
    evaluate("bits(dgb_arc_sine(given(0).x))", 1);
    for (i = 0; i < CASES; ++i) compare(&t, device_float(i, 0), dgb_arc_sine(in[i][0][0]), 1.0);
    check(&t, 3e-7); /* a few ulps of pi/2 */
}

/* n, v and s, none of whose parts that a root is taken of is nearly nothing. */
static void give_slice(int i) {
    float along[3], n_v, n_a;
    int k;
    do {
        for (k = 0; k < 3; ++k) random_normal(in[i][k]);
        dgb_slice_along(in[i][0], in[i][1], in[i][2], along);
        for (n_v = n_a = 0.0f, k = 0; k < 3; ++k) n_v += in[i][0][k] * in[i][1][k], n_a += in[i][0][k] * along[k];
        for (k = 0; k < 3; ++k) in[i][3][k] = along[k];
    } while (n_v * n_v + n_a * n_a < 0.01f || fabsf(n_v) < 0.02f || (in[i][0][0] + in[i][2][0]) * n_v == 0.0f);
    in[i][3][3] = random_in(0.0f, 1.0f); /* what to round sectors with */
    in[i][4][0] = random_in(-1.0f, 1.0f);
    in[i][4][1] = random_in(-1.0f, 1.0f);
    in[i][4][2] = random_in(0.0f, 1.0f);
    in[i][4][3] = random_in(0.0f, 1.0f);
}

static void test_slice(void** state) {
    tally slices = tally_of("slice"), angles = tally_of("slice, angle"), shares = tally_of("slice share"),
          along = tally_of("slice along");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) give_slice(i);
    evaluate("bits(dgb_slice_along(given(0).xyz, given(1).xyz, given(2).xyz))", 5);
    for (i = 0; i < CASES; ++i) {
        float w[3], across = 0.0f;
        for (k = 0; k < 3; ++k) w[k] = in[i][0][k] + in[i][2][k], across += w[k] * in[i][3][k];
        for (k = 0; k < 3; ++k) /* rounding of n + s, whose part across v may be short */
            compare(&along, device_float(i, k) * across, in[i][3][k] * across, 1.0);
    }
    check(&along, 1e-6);
    evaluate("floatBitsToUint(dgb_slice(given(0).xyz, given(1).xyz, given(3).xyz))", 5);
    for (i = 0; i < CASES; ++i) {
        float slice[4];
        dgb_slice(in[i][0], in[i][1], in[i][3], slice);
        for (k = 0; k < 2; ++k) compare(&slices, device_float(i, k), slice[k], 1.0);
        compare(&angles, device_float(i, 2), slice[2], 1.0);
        compare(&angles, 1.0f / device_float(i, 3), 1.0f / slice[3], 1.0);
    }
    check(&slices, 1e-6);
    check(&angles,
          5e-4); /* near a right angle two ulps of the sine, 1.2e-7, are this much of the root that they are under */
    evaluate("bits(dgb_slice_share(dgb_slice(given(0).xyz, given(1).xyz, given(3).xyz), given(4).xy))", 5);
    for (i = 0; i < CASES; ++i) {
        float slice[4], share;
        dgb_slice(in[i][0], in[i][1], in[i][3], slice);
        share = dgb_slice_share(slice, in[i][4]);
        if (slice[3] < 100.0f) compare(&shares, device_float(i, 0), share, 1.0); /* else next to no light */
    }
    check(&shares, 5e-6); /* some ulps of 1 + sin g, 0.01 at least, and of what follows from it */
}

static void test_sectors(void** state) {
    int i, mismatches = 0;
    (void)state;
    for (i = 0; i < CASES; ++i) give_slice(i);
    evaluate("uvec4(dgb_sectors(given(4).z, given(4).w, given(3).w), dgb_sectors(given(4).z, 1.0, given(3).w), "
             "uint(dgb_sector_count(floatBitsToUint(given(4).x))), 0u)",
             5);
    for (i = 0; i < CASES; ++i)
        mismatches += out[i][0] != dgb_sectors(in[i][4][2], in[i][4][3], in[i][3][3]) ||
                      out[i][1] != dgb_sectors(in[i][4][2], 1.0f, in[i][3][3]) ||
                      (int)out[i][2] != dgb_sector_count(bits_of(in[i][4][0]));
    check_equal("sectors", mismatches, 0);
}

/* Newton's steps end within what sines of the device differ, over how fast the share grows there: at its ends, not at
   all. */
static void test_directions(void** state) {
    tally angles = tally_of("slice, share's angle"), sums = tally_of("slice sum"), means = tally_of("sectors mean");
    int i, k;
    (void)state;
    for (i = 0; i < CASES; ++i) give_slice(i);
    evaluate("uvec4(floatBitsToUint(dgb_slice_angle(dgb_slice(given(0).xyz, given(1).xyz, given(3).xyz), 0.05 + 0.9 * "
             "given(4).z)), 0u, "
             "floatBitsToUint(dgb_slice_sum(dgb_slice(given(0).xyz, given(1).xyz, given(3).xyz), 3.0 * given(4).w)))",
             5);
    for (i = 0; i < CASES; ++i) {
        float slice[4], sum[2];
        dgb_slice(in[i][0], in[i][1], in[i][3], slice);
        dgb_slice_sum(slice, 3.0f * in[i][4][3], sum);
        if (slice[3] > 20.0f) continue; /* a slice that holds next to nothing */
        compare(&angles, device_float(i, 0), dgb_slice_angle(slice, 0.05f + 0.9f * in[i][4][2]), 1.0);
        for (k = 0; k < 2; ++k) compare(&sums, device_float(i, 2 + k), sum[k], 1.0);
    }
    check(&angles, 5e-3);
    check(&sums, 1e-3);
    evaluate("uvec4(floatBitsToUint(dgb_sectors_mean(dgb_slice(given(0).xyz, given(1).xyz, given(3).xyz), "
             "floatBitsToUint(given(4).x))), 0u, 0u)",
             5);
    for (i = 0; i < CASES; ++i) {
        float slice[4], mean[2];
        dgb_slice(in[i][0], in[i][1], in[i][3], slice);
        dgb_sectors_mean(slice, bits_of(in[i][4][0]), mean);
        for (k = 0; k < 2 && slice[3] <= 20.0f; ++k) compare(&means, device_float(i, k), mean[k], 1.0);
    }
    check(&means, 1e-3);
}

/* The snippet's, which no pass has. */
static void test_bent_cosine(void** state) {
    static char snippet[1 << 14];
    const char* texts[] = {"#version 330 core\n", snippet, input_text, "layout(location = 0) out uvec4 twin_out;\n",
                           "void main() { twin_out = uvec4(floatBitsToUint(dgb_bent_cosine(given(0)))); }\n"};
    tally t = tally_of("bent cosine");
    int i, k;
    (void)state;
    assert_true(dgbgl_composite_snippet(snippet, sizeof snippet) < sizeof snippet);
    for (i = 0; i < CASES; ++i) {
        const float length = random_in(0.67f, 0.99f), share = random_in(0.01f, 1.0f);
        random_normal(in[i][0]);
        for (k = 0; k < 3; ++k) in[i][0][k] *= length * share;
        in[i][0][3] = share;
    }
    run(link_fragment(texts, 5), 1);
    for (i = 0; i < CASES; ++i) compare(&t, device_float(i, 0), dgb_bent_cosine(in[i][0]), 1.0);
    check(&t, 1e-5); /* a few ulps, under a root whose argument is 0.005 at least */
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        TWIN(test_oct16_encode),
        TWIN(test_oct16_decode),
        TWIN(test_storable),
        TWIN(test_r11g11b10f_store),
        TWIN(test_half_store),
        TWIN(test_dithered),
        TWIN(test_pixel_hash),
        TWIN(test_mip_level),
        TWIN(test_mip_source),
        TWIN(test_depth_code),
        TWIN(test_linear_z),
        TWIN(test_position),
        TWIN(test_pixels_per_metre),
        TWIN(test_keep_test),
        TWIN(test_ao_term),
        TWIN(test_ambient_visibility),
        TWIN(test_gather_term),
        TWIN(test_gather_scale),
        TWIN(test_boost),
        TWIN(test_bilateral_weight),
        TWIN(test_tap_placement),
        TWIN(test_pixel_pair),
        TWIN(test_pixel_quad),
        TWIN(test_ggx_alpha),
        TWIN(test_ggx_normal),
        TWIN(test_ggx_density),
        TWIN(test_offset),
        TWIN(test_arc_sine),
        TWIN(test_slice),
        TWIN(test_sectors),
        TWIN(test_directions),
        TWIN(test_bent_cosine),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
