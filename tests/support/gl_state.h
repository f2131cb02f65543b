/* The state of the current OpenGL context, as a caller sees it: found by asking, not from a list. At the first snapshot in a
   context every value of an enum from 0 to 0xffff is tried with every query; what gives no error is state, and compared from
   then on. Needs OpenGL 4.5. */
#ifndef GL_STATE_H
#define GL_STATE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct gl_state gl_state;

/* Forgets what was found, and makes the objects that are bound by gl_state_scramble. Once in each context. */
void gl_state_open(void);
void gl_state_close(void);

/* Everything that can be queried: values, capabilities, indexed values, units, vertex attributes, attachments, parameters of what
   is bound. Generates no error and changes nothing. The caller frees. */
gl_state* gl_state_take(void);
void gl_state_free(gl_state* s);

int gl_state_count(const gl_state* s); /* values */
/* How many values differ; the first of them, and both values, in words. */
int gl_state_compare(const gl_state* a, const gl_state* b, char* text, size_t size);

/* Sets what can be set to something else, by chance from `seed`: every capability that was found, and what has setters of its
   own. Objects of the engine's are bound wherever one can be. */
void gl_state_scramble(unsigned seed);
/* What reads textures back needs to be as at the start. */
void gl_state_calm_reading(void);

#endif
