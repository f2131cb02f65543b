/* What the GL tests share: a headless context that counts messages, and a small engine with a little scene (a room of
   boxes and columns, one of them moving) that draws into the layers. */
#ifndef GL_FIXTURE_H
#define GL_FIXTURE_H

#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
#include "headless.h"

#include <epoxy/gl.h>

typedef struct fixture {
    headless window;
    dgbgl_backend gl;
    bool limited; /* the context is of a lower version than was asked for (DGB_GL_VERSION) */
    int messages; /* KHR_debug messages above notification so far */
    GLuint vertices, vertex_array;
    int static_count, moving_count; /* vertices of the room, then of the moving box */
    float offsets[4];     /* of the moving box, m: two frames before the view's, one before, at it, one after */
    bool counts_vertices; /* count vertex-shader invocations: slow, and needs GL_ARB_pipeline_statistics_query */
    long long vertices_shaded;
    int draws; /* draw callbacks so far */
} fixture;

typedef struct fixture_view { /* where the camera is; `fixture_default_view` stands in the room */
    float eye[3], yaw;
    float fov;                   /* vertical, degrees; 0: orthographic, 12 m high */
    float near_plane, far_plane; /* far 0: infinite (reversed only) */
    bool reversed;
    dgb_clip clip;
    float jitter[2];
    float scale; /* of the whole world, planes included */
} fixture_view;

/* 0 when it works: a GL core (or ES) context of the version, current; the scene uploaded. Prints why not. */
int fixture_open(fixture* f, int major, int minor, bool es, const dgbgl_desc* desc);
void fixture_close(fixture* f);

/* For the cases of a loop: whether this context can do what a desc asks for. Only a limited one may refuse anything; it prints
   `# left out ITEM`. */
bool fixture_offers(const fixture* f, const dgb_desc* desc);

/* headless_get_proc; fresh textures are full of numbers of their own, where there is OpenGL 4.4. */
void* fixture_get_proc(const char* name);

/* The frame of a test program with one context: open_context and close_context for its group, and test_no_messages,
   which stands last in its list. For files that include cmocka.h. */
#define FIXTURE_CONTEXT(f, major, minor, es)               \
    static void test_no_messages(void** state) {           \
        (void)state;                                       \
        assert_int_equal((f).messages, 0);                 \
        assert_int_equal(glGetError(), GL_NO_ERROR);       \
    }                                                      \
    static int open_context(void** state) {                \
        (void)state;                                       \
        return fixture_open(&(f), major, minor, es, NULL); \
    }                                                      \
    static int close_context(void** state) {               \
        (void)state;                                       \
        fixture_close(&(f));                               \
        return 0;                                          \
    }

fixture_view fixture_default_view(void);
dgb_view fixture_dgb_view(const fixture_view* v, int width, int height);
/* For images of that view: its size, clip space, the fixture's backend, and fixture_log. */
dgb_desc fixture_desc(const fixture* f, const fixture_view* v, int width, int height, int guard_band);

/* Links the fixture's material program for a context; 0 and a printed log when it fails. */
GLuint fixture_program(const dgb_context* context);

typedef struct fixture_draw_user {
    fixture* f;
    GLuint program;
    bool nothing; /* draw nothing */
} fixture_draw_user;

/* The draw callback; user is a fixture_draw_user. */
void fixture_draw(void* user, const dgb_draw* draw);

/* Texel data of a texture, as floats; `layer` of an array, `level` of the chain. Caller frees. */
float* fixture_read(dgb_texture texture, int level, int layer, int width, int height, int layers, GLenum format,
                    int channels);

/* A level of an image as large as the buffer, `channels` floats a texel. Caller frees. Null: no such texture. */
float* fixture_image(const dgb_context* c, dgb_slot slot, int level, int channels);
/* DGB_Z, of one layer or two, 0 where there is no surface. Caller frees. */
float* fixture_z(const dgb_context* c, int level);
/* Replaces level 0. */
void fixture_put_image(const dgb_context* c, dgb_slot slot, int channels, const float* texels);
/* The pixels that are shaded: x0, y0, x1, y1, inclusive. */
void fixture_shaded_rect(const dgb_context* c, const dgb_params* q, int rect[4]);

/* Zeros where an image of the context's size is not shaded: there it is undefined, and no test may look. Null: nothing. */
void fixture_blank_unshaded(const dgb_context* c, float* image, int channels);
/* fixture_image of level 0, zero where it is not shaded. */
float* fixture_shaded(const dgb_context* c, dgb_slot slot, int channels);

/* The light in a texture between the runs of the reconstruction (DGB_HALF, DGB_HALF1), RGBA; ao: its ambient
   visibility, unless null. Caller frees both. Null where there is no such texture. */
float* fixture_read_half(dgb_texture texture, int width, int height, float** ao);

/* Objects alive in the context, of names below 4096. */
int fixture_count_objects(void);
/* Bytes of the textures and buffers among them, as GL gives their sizes; and of the process's heap, 0 where nobody counts. */
size_t fixture_count_bytes(void);
size_t fixture_count_heap(void);

/* A dgb_log_fn that prints. */
void fixture_log(void* user, dgb_result result, dgb_log_item item, const char* sentence);

#endif
