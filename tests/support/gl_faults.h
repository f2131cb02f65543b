/* Stands between the library and an OpenGL, as its get_proc. It counts what may fail on a good day, the look-up of an
   entry point, the making of an object, storage, a shader, a framebuffer, and lets one of these fail; and it can fill
   fresh textures with NaN. Everything else goes through. */
#ifndef GL_FAULTS_H
#define GL_FAULTS_H

#include "deepgbuffer_gl.h"

/* Starts counting. The call `fail_at`, from 1, fails; 0: none. */
void gl_faults_start(dgbgl_get_proc_fn gl, int fail_at);
void* gl_faults_get_proc(const char* name);

int gl_faults_count(void);          /* calls that could have failed, so far */
const char* gl_faults_failed(void); /* the function that failed, or could not be found; "" as long as none has */
bool gl_faults_was_lookup(void);    /* it could not be found */

/* Called before each draw of the library; null: nothing is. */
void gl_faults_watch(void (*draw)(void));

/* Whether textures are filled as they get storage: floats with NaN, all else with what stands out. Needs OpenGL 4.4. */
void gl_faults_poison(bool on);
int gl_faults_poisoned(void); /* textures so far */

typedef struct gl_filling {
    float number, share; /* in textures of floats; of depth and of shares 0..1 */
    unsigned integer;
} gl_filling;

/* Fills the levels of the bound texture. */
void gl_faults_fill(dgbgl_get_proc_fn gl, unsigned target, int levels, unsigned internal, gl_filling filling);

#endif
