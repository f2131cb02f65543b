/* The one translation unit of a test program that holds the implementation. */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
