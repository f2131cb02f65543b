/* An OpenGL without a GPU: it keeps books and draws nothing.

   It knows the entry points that deepgbuffer_gl.h loads, and of each from which version or by which extension a context
   offers it. Like a driver it hands out the addresses of all of them. A call that GL would refuse, or leave undefined, is
   refused with GL's error and written down in words: outside of what the context offers, an enum or a number out of range, a
   name that is dead, a framebuffer that is incomplete, a sampler without a texture of its kind, a texture that is sampled and
   drawn to at once. Shaders are preprocessed, and their samplers, images and blocks are known; no other GLSL is. */
#ifndef GL_STUB_H
#define GL_STUB_H

#include <stdbool.h>
#include <stddef.h>

typedef struct gl_stub_desc {
    int version; /* 330 for OpenGL 3.3 */
    bool es;
    const char* extensions; /* words, separated by spaces; null: none */
    const char* renderer;   /* null: "stub" */
} gl_stub_desc;

/* A fresh context, the only one of the process and current. */
void gl_stub_start(const gl_stub_desc* desc);
/* Frees what the context holds. */
void gl_stub_stop(void);

/* As a driver's: the address of every function that is known, offered or not; null for others. */
void* gl_stub_get_proc(const char* name);

int gl_stub_alive(void);           /* objects */
int gl_stub_calls(void);           /* so far, since the start */
int gl_stub_gets(void);            /* those of them that ask: glGet..., glIs... */
void gl_stub_lose_at(int call);    /* the context is lost at this call, from 1, and stays lost; 0: never */
int gl_stub_refusals(void);        /* calls that were refused */
const char* gl_stub_refusal(void); /* the first of them, in words; "" when there is none */

/* Everything that a caller can set, but for objects and their contents: to be compared byte by byte. */
const void* gl_stub_state(size_t* size);
/* Sets all of it to something odd, as far as the context offers it, with objects of the caller's bound everywhere. */
void gl_stub_scramble(void);

#endif
