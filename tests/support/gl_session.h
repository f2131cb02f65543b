/* The whole life of the library in a context: start, frames, another size, frames, end. For tests that let something fail in
   it: a call that fails must say so, once, and is then tried again. */
#ifndef GL_SESSION_H
#define GL_SESSION_H

#include "deepgbuffer_gl.h"

typedef struct gl_session {
    dgbgl_desc gl;            /* message is the session's */
    dgb_desc desc;            /* backend and log are the session's */
    const dgb_layers* layers; /* DGB_SOURCE_ENGINE */
    bool is_lost; /* the context is lost on the way: failures are of any number, and nothing is tried again */
    /* the engine's: a material program for the context, 0 when that fails; how it goes; its draw callback */
    unsigned int (*make_program)(void* user, const dgb_context* context);
    void (*delete_program)(void* user, unsigned int program);
    dgb_draw_fn draw;
    void (*after)(void* user, const char* call);                   /* after each call of the library; may be null */
    void (*end_of_frames)(void* user, const dgb_context* context); /* before the end; may be null */
    void* user;

    /* what became of it */
    int failures;
    const char* failed; /* the call that did, last; "" */
    dgb_result result;
    int logs, messages;
    dgb_log_item logged; /* last */
} gl_session;

/* Checks with cmocka that each failure is one that a device may have, and that it was logged once. */
void gl_session_run(gl_session* s);

#endif
