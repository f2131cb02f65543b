/* An OpenGL or OpenGL ES context without a window, through EGL. Draw into framebuffer objects only. */
#ifndef HEADLESS_H
#define HEADLESS_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct headless {
    void* display; /* EGLDisplay */
    void* context; /* EGLContext */
} headless;

/* Creates a context of at least the given version (core profile on desktop) and makes it current.
   On failure returns false, writes one sentence to error, and leaves nothing to destroy. */
bool headless_create(headless* h, int major, int minor, bool gles, bool debug, char* error, size_t error_size);

bool headless_make_current(const headless* h);

/* Safe to call twice and on a zeroed struct. */
void headless_destroy(headless* h);

/* The address of an OpenGL function, or NULL. */
void* headless_get_proc(const char* name);

#ifdef __cplusplus
}
#endif

#endif
