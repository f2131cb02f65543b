/* A translation unit that uses both libraries. */
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
#include <stdio.h>

int main(void) {
    printf("%d %s\n", dgb_spiral_turns(9), dgb_result_name(DGB_OK));
    printf("%u\n", dgbgl_texture_name(dgbgl_texture(7)));
    return 0;
}
