#ifndef DRIVER_H
#define DRIVER_H

#include "spirv.h"

#include <vulkan/vulkan.h>

/* Mesa's Vulkan driver for AMD GPUs as a compiler: told a family of GPUs, it makes a device that runs nothing, but
   compiles pipelines to that family's machine code and says what came out. */

typedef struct driver {
    VkInstance instance;
    VkDevice device;
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
    char version[VK_MAX_DRIVER_INFO_SIZE];
} driver;

typedef struct driver_code { /* of the fragment shader; figures as the driver reports them */
    unsigned instructions;
    unsigned vector_registers, scalar_registers;
    unsigned vector_spills, scalar_spills;
    unsigned latency, inverse_throughput;
    char* assembly; /* free it */
} driver_code;

/* Null, or why not, a sentence. */
const char* driver_open(driver* d);
void driver_close(driver* d);

/* A pipeline of a vertex shader without inputs and a fragment shader with one descriptor set, that writes to attachments
   of the formats. Null, or why not. */
const char* driver_compile(const driver* d, spirv_shader vertex, spirv_shader fragment, const VkFormat* formats,
                           int format_count, driver_code* code);

#endif
