#include "spirv.h"

/* From the specification: five words of header, then instructions whose first word holds their length above and their opcode
   below. */
enum { HEADER_WORDS = 5, OP_NAME = 5, OP_VARIABLE = 59, OP_LOAD = 61, OP_ACCESS_CHAIN = 65, OP_DECORATE = 71 };
enum { DECORATION_BINDING = 33, STORAGE_TEXTURE = 0, STORAGE_BLOCK = 2 };

/* Position of the next instruction of that opcode from `at` on; shader.count: there is none. */
static size_t find(spirv_shader shader, size_t at, uint32_t opcode) {
    while (at < shader.count && (shader.words[at] & 0xffffu) != opcode) {
        const uint32_t length = shader.words[at] >> 16;
        at = length ? at + length : shader.count;
    }
    return at < shader.count ? at : shader.count;
}

static size_t after(spirv_shader shader, size_t at) { return at + (shader.words[at] >> 16); }

static uint32_t binding_of(spirv_shader s, uint32_t id) {
    size_t at;
    for (at = find(s, HEADER_WORDS, OP_DECORATE); at < s.count; at = find(s, after(s, at), OP_DECORATE))
        if (s.words[at + 1] == id && s.words[at + 2] == DECORATION_BINDING) return s.words[at + 3];
    return 0;
}

static const char* name_of(spirv_shader s, uint32_t id) {
    size_t at;
    for (at = find(s, HEADER_WORDS, OP_NAME); at < s.count; at = find(s, after(s, at), OP_NAME))
        if (s.words[at + 1] == id) return (const char*)&s.words[at + 2];
    return "";
}

/* Whether anything reads a variable. Those that nothing reads stand in the text all the same, without a binding of their own. */
static bool is_read(spirv_shader s, uint32_t id) {
    static const uint32_t readers[] = {OP_LOAD, OP_ACCESS_CHAIN};
    size_t at, i;
    for (i = 0; i < 2; ++i)
        for (at = find(s, HEADER_WORDS, readers[i]); at < s.count; at = find(s, after(s, at), readers[i]))
            if (s.words[at + 3] == id) return true;
    return false;
}

int spirv_resources(spirv_shader s, spirv_resource* resources, int capacity) {
    int count = 0;
    size_t at;
    for (at = find(s, HEADER_WORDS, OP_VARIABLE); at < s.count; at = find(s, after(s, at), OP_VARIABLE)) {
        const uint32_t id = s.words[at + 2], storage = s.words[at + 3];
        if (count == capacity || (storage != STORAGE_TEXTURE && storage != STORAGE_BLOCK) || !is_read(s, id)) continue;
        resources[count].id = id;
        resources[count].binding = binding_of(s, id);
        resources[count].is_texture = storage == STORAGE_TEXTURE;
        resources[count++].name = name_of(s, id);
    }
    return count;
}
