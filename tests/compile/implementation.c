/* The translation unit that holds both implementations. */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
