/* An engine with other shader languages runs this text through its compilers when it is built: dgbgl_pass_source is a pure
   function and needs no OpenGL. */
#define DGB_API static /* the functions of the core are those of custom_rhi.c; this file keeps its own to itself */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
#include "rhi_shaders.h"

const char* rhi_shader_text(const dgb_program_desc* program, rhi_shader_stage stage) {
    static char texts[2][1 << 16];
    dgbgl_pass_source(program, stage == RHI_VERTEX_SHADER ? DGBGL_VERTEX : DGBGL_FRAGMENT, 330, false, texts[stage],
                      sizeof texts[stage]);
    return texts[stage];
}
