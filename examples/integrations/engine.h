/* What the integrations take for granted: a small engine that has a context, a scene, its depth buffer and a picture to save.
   It knows nothing of deepgbuffer. */
#ifndef ENGINE_H
#define ENGINE_H

#include "engine_camera.h"

#include <epoxy/gl.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_BOXES = 13 };
extern const float engine_boxes[ENGINE_BOXES][6]; /* low corner, high corner, metres; y is up */

/* Prints the sentence and ends the program with status 2. */
void engine_fail(const char* sentence);
void engine_on_message(void* user, const char* sentence); /* the same, to be called back */

/* A context without a window, and a framebuffer of the picture's size, bound. */
void engine_start(bool es);
void engine_stop(void);
void* engine_get_proc(const char* name);

/* A linked program. What stands before the text of a shader is given, or, where it is null, the dialect's #version. geometry:
   null or empty where there is none. */
GLuint engine_program(const char* vertex_head, const char* vertex, const char* fragment_head, const char* fragment,
                      const char* geometry);

/* The scene's depth in a new GL_TEXTURE_2D. */
GLuint engine_draw_depth(void);

/* Draws the red channel of a GL_TEXTURE_2D into the bound framebuffer, as grey. */
void engine_show(GLuint texture);

/* Writes what the bound framebuffer holds to a PPM file and prints its least and its mean value. */
void engine_save(const char* path);

#ifdef __cplusplus
}
#endif

#endif
