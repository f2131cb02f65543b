/* deepgbuffer.h alone, included twice. */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer.h" /* NOLINT: a second time on purpose */
#include <stdio.h>

int main(void) {
    printf("%d %s\n", dgb_spiral_turns(9), dgb_result_name(DGB_OK));
    return 0;
}
