#ifndef SPIRV_H
#define SPIRV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct spirv_shader {
    const uint32_t* words;
    size_t count;
} spirv_shader;

/* What a shader reads: a texture or a uniform block. Variables that nothing reads are none. */
typedef struct spirv_resource {
    uint32_t id, binding;
    bool is_texture;
    const char* name; /* within the shader's words; "" for a block without */
} spirv_resource;

/* Returns how many, at most capacity. */
int spirv_resources(spirv_shader shader, spirv_resource* resources, int capacity);

#endif
