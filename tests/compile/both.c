/* Both libraries in one translation unit; the second file includes the headers again. */
#include "implementation.c"
#include "user.c"
