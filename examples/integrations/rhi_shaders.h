/* Shader text of the library's passes, as an engine's shader compiler would have made it when the engine was built. */
#ifndef RHI_SHADERS_H
#define RHI_SHADERS_H

#include "deepgbuffer.h"

typedef enum rhi_shader_stage { RHI_VERTEX_SHADER, RHI_FRAGMENT_SHADER } rhi_shader_stage;

/* Valid until the next call for the same stage. */
const char* rhi_shader_text(const dgb_program_desc* program, rhi_shader_stage stage);

#endif
