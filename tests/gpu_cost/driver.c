#define _POSIX_C_SOURCE 200112L /* setenv */
#include "driver.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DEVICES = 16, MAX_BINDINGS = 64, MAX_TARGETS = 8, MAX_STATISTICS = 64, MAX_TEXTS = 8 };

/* >> device */

static const char kFamily[] = "NAVI21";

static bool create_instance(driver* d) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    app.apiVersion = VK_API_VERSION_1_3;
    info.pApplicationInfo = &app;
    return vkCreateInstance(&info, NULL, &d->instance) == VK_SUCCESS;
}

/* The one that the family's name is part of the name of. */
static VkPhysicalDevice find_device(driver* d) {
    VkPhysicalDevice devices[MAX_DEVICES];
    uint32_t count = MAX_DEVICES, i;
    const VkResult result = vkEnumeratePhysicalDevices(d->instance, &count, devices);
    for (i = 0; (result == VK_SUCCESS || result == VK_INCOMPLETE) && i < count; ++i) {
        VkPhysicalDeviceDriverProperties driver_is = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
        VkPhysicalDeviceProperties2 is = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
        is.pNext = &driver_is;
        vkGetPhysicalDeviceProperties2(devices[i], &is);
        if (!strstr(is.properties.deviceName, kFamily) || is.properties.apiVersion < VK_API_VERSION_1_3) continue;
        snprintf(d->name, sizeof d->name, "%s", is.properties.deviceName);
        snprintf(d->version, sizeof d->version, "%s", driver_is.driverInfo);
        return devices[i];
    }
    return VK_NULL_HANDLE;
}

static bool create_device(driver* d, VkPhysicalDevice physical) {
    static const char* const extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR};
    VkPhysicalDeviceVulkan13Features features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    statistics.pipelineExecutableInfo = VK_TRUE;
    features.dynamicRendering = VK_TRUE;
    features.pNext = &statistics;
    info.pNext = &features;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
    return vkCreateDevice(physical, &info, NULL, &d->device) == VK_SUCCESS;
}

const char* driver_open(driver* d) {
    VkPhysicalDevice physical;
    memset(d, 0, sizeof *d);
    setenv("RADV_FORCE_FAMILY", kFamily, 1);
    if (!create_instance(d)) return "there is no Vulkan driver";
    physical = find_device(d);
    if (physical && create_device(d, physical)) return NULL;
    driver_close(d);
    return "Mesa's RADV is missing or cannot compile for NAVI21 (Debian, Ubuntu: mesa-vulkan-drivers)";
}

void driver_close(driver* d) {
    if (d->device) vkDestroyDevice(d->device, NULL);
    if (d->instance) vkDestroyInstance(d->instance, NULL);
    memset(d, 0, sizeof *d);
}

/* >> pipeline */

typedef struct pipeline_parts {
    VkShaderModule modules[2];
    VkDescriptorSetLayout set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
} pipeline_parts;

static VkShaderModule create_module(const driver* d, spirv_shader shader) {
    VkShaderModuleCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    VkShaderModule module = VK_NULL_HANDLE;
    info.codeSize = shader.count * sizeof *shader.words;
    info.pCode = shader.words;
    return vkCreateShaderModule(d->device, &info, NULL, &module) == VK_SUCCESS ? module : VK_NULL_HANDLE;
}

static VkDescriptorSetLayoutBinding binding_of(spirv_resource resource) {
    VkDescriptorSetLayoutBinding binding = {0};
    binding.binding = resource.binding;
    binding.descriptorType =
        resource.is_texture ? VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    binding.descriptorCount = 1;
    binding.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT;
    return binding;
}

static bool create_layout(const driver* d, spirv_shader fragment, pipeline_parts* p) {
    spirv_resource resources[MAX_BINDINGS];
    VkDescriptorSetLayoutBinding bindings[MAX_BINDINGS];
    VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    const int count = spirv_resources(fragment, resources, MAX_BINDINGS);
    int i;
    for (i = 0; i < count; ++i) bindings[i] = binding_of(resources[i]);
    set.bindingCount = (uint32_t)count;
    set.pBindings = bindings;
    if (vkCreateDescriptorSetLayout(d->device, &set, NULL, &p->set) != VK_SUCCESS) return false;
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &p->set;
    return vkCreatePipelineLayout(d->device, &layout, NULL, &p->layout) == VK_SUCCESS;
}

static VkPipelineShaderStageCreateInfo stage_of(VkShaderStageFlagBits stage, VkShaderModule module) {
    VkPipelineShaderStageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = stage;
    info.module = module;
    info.pName = "main";
    return info;
}

static bool create_pipeline(const driver* d, const VkFormat* formats, int format_count, pipeline_parts* p) {
    const VkViewport viewport = {0.0f, 0.0f, 1920.0f, 1080.0f, 0.0f, 1.0f};
    const VkRect2D scissor = {{0, 0}, {1920, 1080}};
    VkPipelineShaderStageCreateInfo stages[2];
    VkPipelineColorBlendAttachmentState attachments[MAX_TARGETS];
    VkPipelineRenderingCreateInfo targets = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    VkPipelineVertexInputStateCreateInfo input = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly = {.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    VkPipelineViewportStateCreateInfo viewports = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    VkPipelineRasterizationStateCreateInfo raster = {.sType =
                                                         VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    VkPipelineMultisampleStateCreateInfo samples = {.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    int i;
    stages[0] = stage_of(VK_SHADER_STAGE_VERTEX_BIT, p->modules[0]);
    stages[1] = stage_of(VK_SHADER_STAGE_FRAGMENT_BIT, p->modules[1]);
    memset(attachments, 0, sizeof attachments);
    for (i = 0; i < format_count; ++i) attachments[i].colorWriteMask = 0xf;
    targets.colorAttachmentCount = blend.attachmentCount = (uint32_t)format_count;
    targets.pColorAttachmentFormats = formats;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    viewports.viewportCount = viewports.scissorCount = 1;
    viewports.pViewports = &viewport;
    viewports.pScissors = &scissor;
    raster.lineWidth = 1.0f;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    blend.pAttachments = attachments;
    info.pNext = &targets;
    info.flags =
        VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR | VK_PIPELINE_CREATE_CAPTURE_INTERNAL_REPRESENTATIONS_BIT_KHR;
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewports;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pColorBlendState = &blend;
    info.layout = p->layout;
    return vkCreateGraphicsPipelines(d->device, VK_NULL_HANDLE, 1, &info, NULL, &p->pipeline) == VK_SUCCESS;
}

static void destroy_parts(const driver* d, pipeline_parts* p) {
    vkDestroyPipeline(d->device, p->pipeline, NULL); /* nothing happens to null handles */
    vkDestroyPipelineLayout(d->device, p->layout, NULL);
    vkDestroyDescriptorSetLayout(d->device, p->set, NULL);
    vkDestroyShaderModule(d->device, p->modules[0], NULL);
    vkDestroyShaderModule(d->device, p->modules[1], NULL);
}

/* >> what came out */

#define LOAD(d, name) ((PFN_##name)vkGetDeviceProcAddr((d)->device, #name))

/* Index of the fragment shader among a pipeline's executables, or -1. */
static int find_fragment(const driver* d, VkPipeline pipeline) {
    VkPipelineInfoKHR of = {.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR};
    VkPipelineExecutablePropertiesKHR executables[4];
    uint32_t count = 4, i;
    memset(executables, 0, sizeof executables);
    for (i = 0; i < count; ++i) executables[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
    of.pipeline = pipeline;
    if (LOAD(d, vkGetPipelineExecutablePropertiesKHR)(d->device, &of, &count, executables) != VK_SUCCESS) return -1;
    for (i = 0; i < count; ++i)
        if (executables[i].stages & VK_SHADER_STAGE_FRAGMENT_BIT) return (int)i;
    return -1;
}

static bool read_statistics(const driver* d, const VkPipelineExecutableInfoKHR* of, driver_code* code) {
    const struct {
        const char* name;
        unsigned* value;
    } wanted[] = {{"Instructions", &code->instructions},
                  {"VGPRs", &code->vector_registers},
                  {"Pre-Sched SGPRs", &code->scalar_registers}, /* "SGPRs" is a constant on RDNA */
                  {"Spilled VGPRs", &code->vector_spills},
                  {"Spilled SGPRs", &code->scalar_spills},
                  {"Latency", &code->latency},
                  {"Inverse Throughput", &code->inverse_throughput}};
    const size_t wanted_count = sizeof wanted / sizeof wanted[0];
    VkPipelineExecutableStatisticKHR statistics[MAX_STATISTICS];
    uint32_t count = MAX_STATISTICS, i;
    size_t found = 0, k;
    memset(statistics, 0, sizeof statistics);
    for (i = 0; i < count; ++i) statistics[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
    if (LOAD(d, vkGetPipelineExecutableStatisticsKHR)(d->device, of, &count, statistics) != VK_SUCCESS) return false;
    for (i = 0; i < count; ++i)
        for (k = 0; k < wanted_count; ++k) {
            if (strcmp(statistics[i].name, wanted[k].name) != 0) continue;
            *wanted[k].value = (unsigned)statistics[i].value.u64;
            ++found;
        }
    return found == wanted_count;
}

static bool read_assembly(const driver* d, const VkPipelineExecutableInfoKHR* of, driver_code* code) {
    const PFN_vkGetPipelineExecutableInternalRepresentationsKHR get =
        LOAD(d, vkGetPipelineExecutableInternalRepresentationsKHR);
    VkPipelineExecutableInternalRepresentationKHR texts[MAX_TEXTS];
    uint32_t count = MAX_TEXTS, i;
    memset(texts, 0, sizeof texts);
    for (i = 0; i < count; ++i) texts[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INTERNAL_REPRESENTATION_KHR;
    if (get(d->device, of, &count, texts) != VK_SUCCESS) return false; /* sizes */
    for (i = 0; i < count; ++i) texts[i].pData = malloc(texts[i].dataSize + 1);
    if (get(d->device, of, &count, texts) != VK_SUCCESS) count = 0;
    for (i = 0; i < count; ++i) {
        ((char*)texts[i].pData)[texts[i].dataSize] = 0;
        if (strcmp(texts[i].name, "Assembly") == 0)
            code->assembly = (char*)texts[i].pData;
        else
            free(texts[i].pData);
    }
    return code->assembly != NULL;
}

static const char* read_code(const driver* d, VkPipeline pipeline, driver_code* code) {
    VkPipelineExecutableInfoKHR of = {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR};
    const int fragment = find_fragment(d, pipeline);
    of.pipeline = pipeline;
    of.executableIndex = (uint32_t)fragment;
    if (fragment < 0 || !read_statistics(d, &of, code)) return "the driver reports no statistics";
    return read_assembly(d, &of, code) ? NULL : "the driver shows no assembly";
}

const char* driver_compile(const driver* d, spirv_shader vertex, spirv_shader fragment, const VkFormat* formats,
                           int format_count, driver_code* code) {
    const char* complaint = "the driver cannot compile the shader";
    pipeline_parts p;
    memset(&p, 0, sizeof p);
    memset(code, 0, sizeof *code);
    p.modules[0] = create_module(d, vertex);
    p.modules[1] = create_module(d, fragment);
    if (p.modules[0] && p.modules[1] && create_layout(d, fragment, &p) && create_pipeline(d, formats, format_count, &p))
        complaint = read_code(d, p.pipeline, code);
    destroy_parts(d, &p);
    return complaint;
}
