// Broken and hostile glTF files: each is refused with one sentence that names the file and what is wrong. Around them a good
// file with all that the loader reads. A case is the good file with one piece of its text replaced.
#include "scene.hpp"

#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

extern "C" {
#include <cmocka.h>
}

namespace {

namespace fs = std::filesystem;

// ---- The good file --------------------------------------------------------------------------------------

const char* const kGood = R"({"asset": {"version": "2.0"},
"extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
"extensions": {"KHR_lights_punctual": {"lights": [
    {"type": "spot", "color": [1, 1, 1], "intensity": 5, "range": 9,
     "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}},
"scene": 0, "scenes": [{"nodes": [0, 1, 3, 4]}],
"nodes": [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 1, 0]},
          {"camera": 0, "rotation": [0, 0, 0, 1]}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "JOINTS_0": 3, "WEIGHTS_0": 4},
                            "indices": 5, "material": 0, "mode": 4}]}],
"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": {"index": 0},
                                        "metallicFactor": 0.5, "roughnessFactor": 0.25},
               "normalTexture": {"index": 0, "scale": 1}, "emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK",
               "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}}],
"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071}],
"images": [{"uri": "data:image/png;base64,@IMAGE"}],
"skins": [{"joints": [1, 2], "inverseBindMatrices": 6}],
"animations": [{"samplers": [{"input": 7, "output": 8, "interpolation": "LINEAR"}],
                "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}]}],
"accessors": [
    {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 6, "type": "VEC3",
     "sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 492, "componentType": 5121},
                "values": {"bufferView": 0, "byteOffset": 496}}},
    {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 6, "type": "VEC3"},
    {"bufferView": 0, "byteOffset": 144, "componentType": 5126, "count": 6, "type": "VEC2"},
    {"bufferView": 0, "byteOffset": 192, "componentType": 5121, "count": 6, "type": "VEC4"},
    {"bufferView": 0, "byteOffset": 216, "componentType": 5126, "count": 6, "type": "VEC4"},
    {"bufferView": 0, "byteOffset": 312, "componentType": 5121, "count": 12, "type": "SCALAR"},
    {"bufferView": 0, "byteOffset": 324, "componentType": 5126, "count": 2, "type": "MAT4"},
    {"bufferView": 0, "byteOffset": 452, "componentType": 5126, "count": 2, "type": "SCALAR"},
    {"bufferView": 0, "byteOffset": 460, "componentType": 5126, "count": 2, "type": "VEC4"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 572}],
"buffers": [{"byteLength": 572, "uri": "data:application/octet-stream;base64,@BUFFER"}]})";

// 1 x 1 pixels.
const char* const kImage =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP43+AAAARBAcAM0e2RAAAAAElFTkSuQmCC";

template <typename T>
void append(std::string* bytes, std::initializer_list<T> values) {
    for (const T value : values) { bytes->append(reinterpret_cast<const char*>(&value), sizeof value); }
}

// A strip of four triangles that two joints bend; what the accessors of the good file describe, in their order.
std::string buffer_bytes() {
    std::string bytes;
    append<float>(&bytes, {-1, 0, 0, 1, 0, 0, -1, 1, 0, 1, 1, 0, -1, 2, 0, 9, 9, 9}); // the last is replaced
    for (int i = 0; i < 6; ++i) { append<float>(&bytes, {0, 0, 1}); }
    append<float>(&bytes, {0, 0, 1, 0, 0, 1, 1, 1, 0, 2, 1, 2});
    for (int i = 0; i < 6; ++i) { append<uint8_t>(&bytes, {0, 1, 0, 0}); }
    for (int i = 0; i < 6; ++i) { append<float>(&bytes, {i < 3 ? 1.0f : 0.0f, i < 3 ? 0.0f : 1.0f, 0, 0}); }
    append<uint8_t>(&bytes, {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5});
    append<float>(&bytes, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    append<float>(&bytes, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1});
    append<float>(&bytes, {0, 1});
    append<float>(&bytes, {0, 0, 0, 1, 0, 0, 0.6f, 0.8f});
    append<uint8_t>(&bytes, {5, 0, 0, 0});
    append<float>(&bytes, {1, 2, 0});
    return bytes.append(64, '\xff'); // as floats NaN, as indices beyond everything; from byte 508
}

std::string base64(const std::string& bytes) {
    static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) { group = group << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u); }
        for (size_t k = 0; k < 4; ++k) { text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63]; }
    }
    return text;
}

// Replaces what must be there once.
void replace(std::string* text, const std::string& from, const std::string& to) {
    const size_t at = text->find(from);
    if (at == std::string::npos || text->find(from, at + 1) != std::string::npos) {
        fail_msg("\"%s\" is not in the file, or more than once", from.c_str());
    }
    text->replace(at, from.size(), to);
}

std::string with_data(std::string json) {
    if (json.find("@IMAGE") != std::string::npos) { replace(&json, "@IMAGE", kImage); }
    if (json.find("@BUFFER") != std::string::npos) { replace(&json, "@BUFFER", base64(buffer_bytes())); }
    return json;
}

std::string good_with(const std::string& from, const std::string& to) {
    std::string json = kGood;
    replace(&json, from, to);
    return with_data(json);
}

// The good file as .glb: its buffer is the binary chunk.
std::string binary_gltf() {
    std::string json = good_with(", \"uri\": \"data:application/octet-stream;base64,@BUFFER\"", ""), bytes = "glTF";
    json.append((4 - json.size() % 4) % 4, ' ');
    const auto json_size = uint32_t(json.size()), size = uint32_t(buffer_bytes().size());
    append<uint32_t>(&bytes, {2, 12 + 8 + json_size + 8 + size, json_size, 0x4e4f534a});
    bytes += json;
    append<uint32_t>(&bytes, {size, 0x004e4942});
    return bytes + buffer_bytes();
}

// ---- Loading --------------------------------------------------------------------------------------------

fs::path directory; // of the test; scenes are in a directory below

void write(const fs::path& path, const std::string& bytes) {
    std::ofstream stream(path, std::ios::binary);
    if (!stream.write(bytes.data(), std::streamsize(bytes.size())).flush()) {
        fail_msg("cannot write %s", path.c_str());
    }
}

std::string scene_path() { return (directory / "scenes" / "scene.gltf").string(); }

void check_refused(const std::string& file, const std::string& words) {
    Scene scene;
    std::string error;
    scene.name = "untouched";
    write(scene_path(), file);
    if (load_gltf(scene_path(), &scene, &error)) { fail_msg("it is not refused"); }
    const std::string start = "cannot load \"" + scene_path() + "\": ";
    if (error.substr(0, start.size()) != start || error.find(words) == std::string::npos) {
        fail_msg("%s", error.c_str());
    }
    if (error.find_first_of("\n\r\033") != std::string::npos || error.size() > start.size() + 300) {
        fail_msg("no sentence: %s", error.c_str());
    }
    assert_string_equal(scene.name.c_str(), "untouched");
}

Scene load(const std::string& file) {
    Scene scene;
    std::string error;
    write(scene_path(), file);
    if (!load_gltf(scene_path(), &scene, &error)) { fail_msg("%s", error.c_str()); }
    return scene;
}

// ---- What is refused --------------------------------------------------------------------------------------

struct Case {
    const char* name;
    const char *from, *to; // no from: to is the whole file
    const char* words;     // of the sentence; none: the file loads
};

#define BUFFER_URI "data:application/octet-stream;base64,@BUFFER"
#define IMAGE_URI "data:image/png;base64,@IMAGE"

const Case kCases[] = {
    // files and URIs
    {"buffer in the directory above", BUFFER_URI, "../outside.bin", "leaves the directory"},
    {"buffer by a detour", BUFFER_URI, "a/../../outside.bin", "leaves the directory"},
    {"buffer by an escaped detour", BUFFER_URI, "%2e%2e/outside.bin", "leaves the directory"},
    {"buffer by an absolute path", BUFFER_URI, "/etc/passwd", "leaves the directory"},
    {"buffer by a file URI", BUFFER_URI, "file:///etc/passwd", "only relative paths"},
    {"buffer by a drive", BUFFER_URI, "C:outside.bin", "only relative paths"},
    {"buffer by backslashes", BUFFER_URI, "..\\\\outside.bin", "only relative paths"},
    {"buffer from the net", BUFFER_URI, "http://example.com/buffer.bin", "only relative paths"},
    {"buffer that is a directory", BUFFER_URI, ".", "does not exist"},
    {"buffer that is a device", BUFFER_URI, "null", "does not exist"},
    {"buffer that is not there", BUFFER_URI, "missing.bin", "missing.bin\" does not exist"},
    {"buffer with a name of control characters", BUFFER_URI, "a\\u001b[31m\\nb", "does not exist"},
    {"buffer shorter than it says", BUFFER_URI, "short.bin", "File size mismatch : short.bin"},
    {"buffer larger than 512 MiB", BUFFER_URI, "large.bin", "larger than 512 MiB"},
    {"buffer without a URI", ", \"uri\": \"" BUFFER_URI "\"", "", "'uri' is missing"},
    {"buffer of bad base64", BUFFER_URI, "data:application/octet-stream;base64,!!!!", "Failed to decode 'uri'"},
    {"buffer of too little base64", BUFFER_URI, "data:application/octet-stream;base64,AAAA", "Failed to decode 'uri'"},
    {"buffer of negative length", "{\"byteLength\": 572", "{\"byteLength\": -1", "byteLength"},
    {"buffer of endless length", "{\"byteLength\": 572", "{\"byteLength\": 18446744073709551615", "not valid glTF"},
    {"image in the directory above", IMAGE_URI, "../outside.png", "leaves the directory"},
    {"image that is not there", IMAGE_URI, "missing.png", "missing.png\" does not exist"},

    // JSON
    {"empty file", nullptr, "", "too short"},
    {"no JSON", nullptr, "no scene at all", "not valid glTF"},
    {"truncated JSON", "\"bufferViews\": [{", "\"bufferViews\": [", "not valid glTF"},
    {"JSON that is a list", nullptr, "[{}, {}]", "not a JSON object"},
    {"bad UTF-8", "\"version\": \"2.0\"", "\"version\": \"2.0\", \"generator\": \"\xff\xfe\"", "not valid glTF"},
    {"number beyond double", "\"yfov\": 1,", "\"yfov\": 1e999,", "not valid glTF"},
    {"no asset", "\"asset\": {\"version\": \"2.0\"},", "", "asset"},
    {"version 1", "\"version\": \"2.0\"", "\"version\": \"1.0\"", "only glTF 2"},
    {"required extension", "\"extensionsUsed\": [",
     "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"extensionsUsed\": [",
     "KHR_draco_mesh_compression, which is not supported"},
    {"lists of other things", "\"nodes\": [{\"mesh\": 0, \"skin\": 0}", "\"nodes\": [7, {\"mesh\": 0, \"skin\": 0}",
     "not valid glTF"},
    {"no scene", "\"scenes\": [{\"nodes\": [0, 1, 3, 4]}],", "\"scenes\": [],", "scene 0 does not exist"},
    {"scene out of range", "\"scene\": 0", "\"scene\": 7", "scene 7 does not exist"},
    {"nothing in the scene", "\"scenes\": [{\"nodes\": [0, 1, 3, 4]}]", "\"scenes\": [{\"nodes\": []}]",
     "no triangles"},

    // buffer views and accessors
    {"buffer out of range", "{\"buffer\": 0,", "{\"buffer\": 1,", "buffer 1 does not exist"},
    {"buffer below range", "{\"buffer\": 0,", "{\"buffer\": -1,", "buffer -1 does not exist"},
    {"buffer view longer than its buffer", "\"byteOffset\": 0, \"byteLength\": 572",
     "\"byteOffset\": 1, \"byteLength\": 572", "buffer view 0 reaches beyond"},
    {"buffer view whose end overflows", "\"byteOffset\": 0, \"byteLength\": 572",
     "\"byteOffset\": 18446744073709551615, \"byteLength\": 572", "buffer view 0 reaches beyond"},
    {"buffer view of odd stride", "\"byteLength\": 572}", "\"byteLength\": 572, \"byteStride\": 13}", "byteStride"},
    {"buffer view of huge stride", "\"byteLength\": 572}", "\"byteLength\": 572, \"byteStride\": 4000000000}",
     "byteStride"},
    {"stride shorter than an element", "\"byteLength\": 572}", "\"byteLength\": 572, \"byteStride\": 4}",
     "stride shorter"},
    {"stride beyond the buffer view", "\"byteLength\": 572}", "\"byteLength\": 572, \"byteStride\": 252}",
     "reaches beyond buffer view 0"},
    {"buffer view out of range", "\"byteOffset\": 72,", "\"bufferView\": 9, \"byteOffset\": 72,",
     "buffer view 9 does not exist"},
    {"buffer view below range", "\"byteOffset\": 72,", "\"bufferView\": -9, \"byteOffset\": 72,",
     "buffer view -9 does not exist"},
    {"accessor beyond its buffer view", "\"byteOffset\": 72,", "\"byteOffset\": 501,", "reaches beyond buffer view 0"},
    {"accessor whose end overflows", "\"byteOffset\": 72,", "\"byteOffset\": 18446744073709551612,",
     "reaches beyond buffer view 0"},
    {"accessor of negative count", "\"byteOffset\": 72, \"componentType\": 5126, \"count\": 6",
     "\"byteOffset\": 72, \"componentType\": 5126, \"count\": -6", "count"},
    {"accessor of huge count", "\"byteOffset\": 72, \"componentType\": 5126, \"count\": 6",
     "\"byteOffset\": 72, \"componentType\": 5126, \"count\": 99999999999", "more than 16777216 elements"},
    {"accessor of a million zeros", "{\"bufferView\": 0, \"byteOffset\": 72, \"componentType\": 5126, \"count\": 6",
     "{\"componentType\": 5126, \"count\": 1048577", "without a buffer view"},
    {"accessor of an unknown type", "\"count\": 2, \"type\": \"MAT4\"", "\"count\": 2, \"type\": \"MAT5\"", "type"},
    {"accessor of an unknown component type", "\"byteOffset\": 72, \"componentType\": 5126",
     "\"byteOffset\": 72, \"componentType\": 9", "componentType"},
    {"accessor of doubles", "\"byteOffset\": 72, \"componentType\": 5126",
     "\"byteOffset\": 72, \"componentType\": 5130", "component type that glTF does not allow"},
    {"sparse index beyond the accessor", "\"byteOffset\": 492", "\"byteOffset\": 508",
     "replaces an element that does not exist"},
    {"sparse indices beyond the buffer view", "\"byteOffset\": 492", "\"byteOffset\": 572",
     "reaches beyond buffer view 0"},
    {"sparse indices before the buffer view", "\"byteOffset\": 492", "\"byteOffset\": -1", "negative count or offset"},
    {"sparse indices of floats", "\"byteOffset\": 492, \"componentType\": 5121",
     "\"byteOffset\": 492, \"componentType\": 5126", "not of an unsigned integer type"},
    {"sparse indices of an unknown type", "\"byteOffset\": 492, \"componentType\": 5121",
     "\"byteOffset\": 492, \"componentType\": 9", "unknown component type"},
    {"sparse values before the buffer view", "\"byteOffset\": 496", "\"byteOffset\": -1", "negative count or offset"},
    {"sparse values beyond the buffer view", "\"byteOffset\": 496", "\"byteOffset\": 561",
     "reaches beyond buffer view 0"},
    {"sparse values that are not finite", "\"byteOffset\": 496", "\"byteOffset\": 508", "not finite"},
    {"sparse of negative count", "\"sparse\": {\"count\": 1", "\"sparse\": {\"count\": -1", "negative count or offset"},
    {"sparse of huge count", "\"sparse\": {\"count\": 1", "\"sparse\": {\"count\": 2000000000",
     "reaches beyond buffer view 0"},
    {"sparse buffer view out of range", "\"values\": {\"bufferView\": 0", "\"values\": {\"bufferView\": 7",
     "buffer view 7 does not exist"},
    {"sparse without values", "\"values\": {", "\"valves\": {", "values"},

    // meshes
    {"no POSITION", "\"POSITION\": 0, ", "", "no POSITION"},
    {"positions out of range", "\"POSITION\": 0", "\"POSITION\": 77", "accessor 77 does not exist"},
    {"positions below range", "\"POSITION\": 0", "\"POSITION\": -5", "accessor -5 does not exist"},
    {"positions of two numbers", "\"POSITION\": 0", "\"POSITION\": 2", "wrong number of components"},
    {"normals of four numbers", "\"NORMAL\": 1", "\"NORMAL\": 4", "wrong number of components"},
    {"positions that are not finite", "\"count\": 6, \"type\": \"VEC3\",\n     \"sparse\"",
     "\"count\": 44, \"type\": \"VEC3\",\n     \"sparse\"", "not finite"},
    {"more normals than positions", "\"byteOffset\": 72, \"componentType\": 5126, \"count\": 6",
     "\"byteOffset\": 72, \"componentType\": 5126, \"count\": 7", "NORMAL has a different number"},
    {"texture coordinates that are not finite", "\"byteOffset\": 144", "\"byteOffset\": 508", "not finite"},
    {"indices out of range", "\"indices\": 5,", "\"indices\": 55,", "not valid glTF"},
    {"indices below range", "\"indices\": 5,", "\"indices\": -5,", "accessor -5 does not exist"},
    {"indices beyond the vertices", "\"byteOffset\": 312", "\"byteOffset\": 508",
     "uses vertex 255, but it only has 6 vertices"},
    {"indices of floats", "\"byteOffset\": 312, \"componentType\": 5121, \"count\": 12",
     "\"byteOffset\": 312, \"componentType\": 5126, \"count\": 3", "not of an unsigned integer type"},
    {"indices of vectors", "\"indices\": 5,", "\"indices\": 3,", "not of type SCALAR"},
    {"mode out of range", "\"mode\": 4", "\"mode\": 7", "mode 7"},
    {"mode below range", "\"mode\": 4", "\"mode\": -1", "mode -1"},
    {"points only", "\"mode\": 4", "\"mode\": 0", "no triangles"},
    {"no index", "\"byteOffset\": 312, \"componentType\": 5121, \"count\": 12",
     "\"byteOffset\": 312, \"componentType\": 5121, \"count\": 0", "no triangles"},
    {"material out of range", "\"material\": 0", "\"material\": 3", "material 3 does not exist"},
    {"material below range", "\"material\": 0", "\"material\": -3", "material -3 does not exist"},
    {"joints without weights", ", \"WEIGHTS_0\": 4", "", "joints without weights"},
    {"joints of floats", "\"byteOffset\": 192, \"componentType\": 5121", "\"byteOffset\": 192, \"componentType\": 5126",
     "not unsigned bytes or shorts"},
    {"joints from 0 to 1", "\"byteOffset\": 192, \"componentType\": 5121",
     "\"byteOffset\": 192, \"normalized\": true, \"componentType\": 5121", "not unsigned bytes or shorts"},
    {"negative weights", "\"byteOffset\": 216", "\"byteOffset\": 0", "negative joint weight"},

    // images, textures, materials
    {"image that is text", IMAGE_URI, "data:image/png;base64,bm8gaW1hZ2UgYXQgYWxs", "image 0 is not a PNG or JPEG"},
    {"image that is a GIF", IMAGE_URI,
     "data:image/gif;base64,R0lGODlhAQABAIAAAP///wAAACwAAAAAAQABAAACAkQBADs=", "image 0 is not a PNG or JPEG"},
    {"image of no bytes", IMAGE_URI, "data:image/png;base64,", "not valid glTF"},
    {"image that ends early", IMAGE_URI, "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1Pe",
     "image 0 cannot be decoded"},
    {"image of 65535 x 65535 pixels", IMAGE_URI, "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAA//8AAP//CAIAAACQd1Pe",
     "image 0 is"},
    {"image of 16385 x 1 pixels", IMAGE_URI, "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAQAEAAAABCAIAAACQd1Pe",
     "wider or higher than 16384"},
    {"image of 1 x 16385 pixels", IMAGE_URI, "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAEABCAIAAACQd1Pe",
     "wider or higher than 16384"},
    {"image of 0 x 0 pixels", IMAGE_URI, "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAAAAAAACAIAAACQd1Pe",
     "image 0 is not a PNG or JPEG"},
    {"image out of its buffer view", "{\"uri\": \"" IMAGE_URI "\"}", "{\"bufferView\": 3, \"mimeType\": \"image/png\"}",
     "not valid glTF"},
    {"image of a buffer view of floats", "{\"uri\": \"" IMAGE_URI "\"}",
     "{\"bufferView\": 0, \"mimeType\": \"image/png\"}", "image 0 is not a PNG or JPEG"},
    {"image from nowhere", "{\"uri\": \"" IMAGE_URI "\"}", "{}", "image[0]"},
    {"image out of range", "{\"source\": 0,", "{\"source\": 1,", "image 1 does not exist"},
    {"texture without image", "{\"source\": 0,", "{", "image -1 does not exist"},
    {"sampler out of range", "\"sampler\": 0}], \"samplers\"", "\"sampler\": 1}], \"samplers\"",
     "sampler 1 does not exist"},
    {"texture out of range", "\"baseColorTexture\": {\"index\": 0", "\"baseColorTexture\": {\"index\": 4",
     "texture 4 does not exist"},
    {"texture below range", "\"baseColorTexture\": {\"index\": 0", "\"baseColorTexture\": {\"index\": -4",
     "texture -4 does not exist"},
    {"second set of texture coordinates", "\"baseColorTexture\": {\"index\": 0",
     "\"baseColorTexture\": {\"texCoord\": 1, \"index\": 0", "TEXCOORD_1"},
    {"base color that is not finite", "\"baseColorFactor\": [1,", "\"baseColorFactor\": [1e39,", "not finite"},
    {"roughness that is not finite", "\"roughnessFactor\": 0.25", "\"roughnessFactor\": 1e200", "not finite"},
    {"normal scale that is not finite", "\"scale\": 1", "\"scale\": -1e200", "not finite"},
    {"emission that is not finite", "\"emissiveStrength\": 2", "\"emissiveStrength\": 1e60", "not finite"},
    {"radiance that is no list", "\"alphaMode\": \"MASK\"", "\"extras\": {\"radiance\": 1}", "radiance of a material"},
    {"radiance of four numbers", "\"alphaMode\": \"MASK\"", "\"extras\": {\"radiance\": [1, 2, 3, 4]}",
     "radiance of a material"},
    {"radiance of words", "\"alphaMode\": \"MASK\"", "\"extras\": {\"radiance\": [1, 2, \"3\"]}",
     "radiance of a material"},
    {"alpha mode out of range", "\"alphaMode\": \"MASK\"", "\"alphaMode\": \"SOME\"", "unknown alpha mode"},

    // nodes, cameras, lights
    {"root out of range", "\"nodes\": [0, 1, 3, 4]", "\"nodes\": [0, 1, 3, 9]", "node 9 does not exist"},
    {"root below range", "\"nodes\": [0, 1, 3, 4]", "\"nodes\": [0, 1, 3, -4]", "node -4 does not exist"},
    {"root twice", "\"nodes\": [0, 1, 3, 4]", "\"nodes\": [0, 1, 3, 3]",
     "node 3 has two parents or is its own ancestor"},
    {"child out of range", "\"children\": [2]", "\"children\": [5]", "node 5 does not exist"},
    {"child of itself", "\"children\": [2]", "\"children\": [1]", "node 1 has two parents or is its own ancestor"},
    {"child of its child", "{\"translation\": [0, 1, 0]}", "{\"children\": [1]}",
     "node 1 has two parents or is its own ancestor"},
    {"child of two", "{\"camera\": 0,", "{\"children\": [2], \"camera\": 0,",
     "node 2 has two parents or is its own ancestor"},
    {"mesh out of range", "{\"mesh\": 0,", "{\"mesh\": 1,", "mesh 1 does not exist"},
    {"mesh below range", "{\"mesh\": 0,", "{\"mesh\": -2,", "mesh -2 does not exist"},
    {"translation of two numbers", "\"translation\": [0, 1, 0]", "\"translation\": [0, 1]", "2 instead of 3 numbers"},
    {"translation that is not finite", "\"translation\": [0, 1, 0]", "\"translation\": [0, 1e39, 0]", "not finite"},
    {"matrix of 15 numbers", "\"translation\": [0, 1, 0]", "\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0]",
     "16 numbers"},
    {"matrix that is not finite", "\"translation\": [0, 1, 0]",
     "\"matrix\": [1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]", "not finite"},
    {"scales whose product overflows", "{\"children\": [2]}, {\"translation\": [0, 1, 0]}",
     "{\"children\": [2], \"scale\": [1e30, 1, 1]}, {\"scale\": [1e30, 1, 1]}",
     "multiply to a matrix that is not finite"},
    {"vertices at infinity", "{\"mesh\": 0, \"skin\": 0}", "{\"mesh\": 0, \"scale\": [3e38, 3e38, 1]}", "to infinity"},
    {"vertices too far apart", "{\"mesh\": 0, \"skin\": 0}", "{\"mesh\": 0, \"scale\": [1e30, 1, 1]}",
     "to infinity, or nearly"},
    {"camera out of range", "{\"camera\": 0", "{\"camera\": 1", "camera 1 does not exist"},
    {"camera below range", "{\"camera\": 0", "{\"camera\": -2", "camera -2 does not exist"},
    {"camera that sees nothing", "\"yfov\": 1,", "\"yfov\": 0,", "field of view"},
    {"camera that sees behind", "\"yfov\": 1,", "\"yfov\": 3.2,", "field of view"},
    {"parallel camera that sees nothing", "\"type\": \"perspective\", \"perspective\": {\"yfov\": 1,",
     "\"type\": \"orthographic\", \"orthographic\": {\"xmag\": 1, \"ymag\": 0, \"zfar\": 9,", "ymag of 0"},
    {"camera that is not finite", "\"yfov\": 1,", "\"yfov\": 1e40,", "not finite"},
    {"light out of range", "\"light\": 0", "\"light\": 1", "light 1 does not exist"},
    {"light below range", "\"light\": 0", "\"light\": -1", "light -1 does not exist"},
    {"light that is a word", "\"light\": 0", "\"light\": \"sun\"", "without a number"},
    {"light of an unknown kind", "\"type\": \"spot\"", "\"type\": \"tube\"", "neither directional nor point nor spot"},
    {"light that is not finite", "\"intensity\": 5", "\"intensity\": 1e40", "not finite"},
    {"light that darkens", "\"intensity\": 5", "\"intensity\": -5", "negative color, intensity or range"},
    {"light of negative range", "\"range\": 9", "\"range\": -9", "negative color, intensity or range"},
    {"light with a negative angle", "\"innerConeAngle\": 0.1", "\"innerConeAngle\": -0.1", "cone angles"},
    {"light without a cone", "\"innerConeAngle\": 0.1, \"outerConeAngle\": 0.5",
     "\"innerConeAngle\": 0, \"outerConeAngle\": 0", "cone angles"},
    {"light with more than half a space", "\"outerConeAngle\": 0.5", "\"outerConeAngle\": 1.6", "cone angles"},
    {"light with its cone inside out", "\"outerConeAngle\": 0.5", "\"outerConeAngle\": 0.05", "cone angles"},

    // skins and animations
    {"skin out of range", "\"skin\": 0", "\"skin\": 1", "skin 1 does not exist"},
    {"skin below range", "\"skin\": 0", "\"skin\": -2", "skin -2 does not exist"},
    {"skin without joints", "\"joints\": [1, 2]", "\"joints\": []", "no joints"},
    {"joint out of range", "\"joints\": [1, 2]", "\"joints\": [1, 9]", "node 9 does not exist"},
    {"joint of another scene", "\"nodes\": [0, 1, 3, 4]", "\"nodes\": [0, 3, 4]",
     "a joint of skin 0 is not in the scene"},
    {"joint that vertices lack", "\"joints\": [1, 2]", "\"joints\": [1]", "only has 1 joints"},
    {"skin of a mesh without joints", ", \"JOINTS_0\": 3, \"WEIGHTS_0\": 4", "", "has no joints and weights"},
    {"too few inverse bind matrices", "\"count\": 2, \"type\": \"MAT4\"", "\"count\": 1, \"type\": \"MAT4\"",
     "fewer inverse bind matrices"},
    {"inverse bind matrices that are not finite", "\"byteOffset\": 324", "\"byteOffset\": 444", "not finite"},
    {"inverse bind matrices of vectors", "\"inverseBindMatrices\": 6", "\"inverseBindMatrices\": 4",
     "not of type MAT4"},
    {"inverse bind matrices of bytes", "\"byteOffset\": 324, \"componentType\": 5126",
     "\"byteOffset\": 324, \"componentType\": 5121", "not of type MAT4 and float"},
    {"too many inverse bind matrices",
     "{\"bufferView\": 0, \"byteOffset\": 324, \"componentType\": 5126, \"count\": 2, \"type\": \"MAT4\"}",
     "{\"componentType\": 5126, \"count\": 16385, \"type\": \"MAT4\"}", "more than 16384 matrices"},
    {"inverse bind matrices out of range", "\"inverseBindMatrices\": 6", "\"inverseBindMatrices\": 66",
     "accessor 66 does not exist"},
    {"weights that are not finite", "\"byteOffset\": 216", "\"byteOffset\": 476", "not finite"},
    {"times that do not increase", "\"byteOffset\": 452, \"componentType\": 5126",
     "\"byteOffset\": 460, \"componentType\": 5126", "do not increase"},
    {"times before the start", "\"byteOffset\": 452", "\"byteOffset\": 0", "are negative"},
    {"times that are not finite", "\"byteOffset\": 452, \"componentType\": 5126",
     "\"byteOffset\": 508, \"componentType\": 5126", "not finite"},
    {"no times", "\"count\": 2, \"type\": \"SCALAR\"", "\"count\": 0, \"type\": \"SCALAR\"", "is empty"},
    {"times out of range", "\"input\": 7", "\"input\": 70", "accessor 70 does not exist"},
    {"more times than values", "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2",
     "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 1", "wrong number of values"},
    {"no values", "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2",
     "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 0", "wrong number of values"},
    {"more values than times", "\"byteOffset\": 452, \"componentType\": 5126, \"count\": 2",
     "\"byteOffset\": 452, \"componentType\": 5126, \"count\": 1", "more values than its times"},
    {"values that are not finite", "\"output\": 8", "\"output\": 9", "accessor 9 does not exist"},
    {"cubic without tangents", "\"LINEAR\"", "\"CUBICSPLINE\"", "wrong number of values"},
    {"unknown interpolation", "\"LINEAR\"", "\"SINE\"", "unknown interpolation"},
    {"animated sampler out of range", "\"sampler\": 0, \"target\"", "\"sampler\": 1, \"target\"",
     "sampler 1 does not exist"},
    {"animated node out of range", "\"target\": {\"node\": 2", "\"target\": {\"node\": 20", "node 20 does not exist"},
    {"animated node with a matrix", "{\"translation\": [0, 1, 0]}",
     "{\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]}", "node 2, which has a matrix"},
    {"scale of four numbers", "\"path\": \"rotation\"", "\"path\": \"scale\"", "by other than VEC3"},

    // what the standard allows, and what it tells readers to ignore
    {"the good file", "\"scene\": 0", "\"scene\": 0", nullptr},
    {"no scene number", "\"scene\": 0, ", "", nullptr},
    {"extensions that are not required", "\"extensionsUsed\": [",
     "\"extensionsUsed\": [\"EXT_not_known\", \"KHR_lights_punctual\", ", nullptr},
    {"extensions that are no objects", "{\"light\": 0}", "[0]", nullptr},
    {"extras of any kind", "\"alphaMode\": \"MASK\"", "\"extras\": [null, {\"radiance\": 1}]", nullptr},
    {"no indices", "\"indices\": 5, ", "", nullptr},
    {"strip", "\"mode\": 4", "\"mode\": 5", nullptr},
    {"fan", "\"mode\": 4", "\"mode\": 6", nullptr},
    {"points beside triangles", "\"mode\": 4}]", "\"mode\": 4}, {\"mode\": 0, \"attributes\": {}}]", nullptr},
    {"no normals", "\"NORMAL\": 1, ", "", nullptr},
    {"no texture coordinates", "\"TEXCOORD_0\": 2, ", "", nullptr},
    {"no material", ", \"material\": 0", "", nullptr},
    {"morph targets", "\"mode\": 4", "\"mode\": 4, \"targets\": [{\"POSITION\": 1}]", nullptr},
    {"zeros that are replaced", "{\"bufferView\": 0, \"byteOffset\": 0, \"componentType\": 5126",
     "{\"componentType\": 5126", nullptr},
    {"base color of three numbers", "\"baseColorFactor\": [1, 1, 1, 1]", "\"baseColorFactor\": [1, 1, 1]", nullptr},
    {"steps", "\"LINEAR\"", "\"STEP\"", nullptr},
    {"no inverse bind matrices", ", \"inverseBindMatrices\": 6", "", nullptr},
    {"orthographic camera", "\"type\": \"perspective\", \"perspective\": {\"yfov\": 1,",
     "\"type\": \"orthographic\", \"orthographic\": {\"xmag\": 1, \"ymag\": 2, \"zfar\": 9,", nullptr},
    {"rotation of length 0", "\"rotation\": [0, 0, 0, 1]", "\"rotation\": [0, 0, 0, 0]", nullptr},
    {"node by a matrix", "{\"camera\": 0, \"rotation\": [0, 0, 0, 1]}",
     "{\"camera\": 0, \"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]}", nullptr},
    {"buffer in a file", BUFFER_URI, "a%20buffer.bin", nullptr},
    {"buffer in a directory below", BUFFER_URI, "below/buffer.bin", nullptr},
};

void test_case(void** state) {
    const Case& c = *static_cast<const Case*>(*state);
    const std::string file = c.from != nullptr ? good_with(c.from, c.to) : c.to;
    if (c.words != nullptr) {
        check_refused(file, c.words);
    } else {
        load(file);
    }
}

// ---- What no replaced text makes --------------------------------------------------------------------------

void test_contents(void**) {
    const Scene scene = load(with_data(kGood));
    assert_int_equal(scene.meshes.size(), 1);
    assert_int_equal(scene.meshes[0].vertices.size(), 6);
    assert_int_equal(scene.meshes[0].indices.size(), 12);
    assert_true(scene.meshes[0].vertices[5].position == glm::vec3(1, 2, 0)); // the sparse one
    assert_int_equal(scene.nodes.size(), 5);
    assert_int_equal(scene.skins[0].nodes.size(), 2);
    assert_int_equal(scene.skins[0].inverse_bind.size(), 2);
    assert_int_equal(scene.animations[0].channels.size(), 1);
    assert_int_equal(scene.cameras.size(), 1);
    assert_int_equal(scene.lights.size(), 1);
    assert_int_equal(scene.images[0].rgba.size(), 4);
    assert_true(scene.materials[0].emissive == glm::vec3(2, 1, 0));
    assert_int_equal(scene.materials[0].alpha_mode, AlphaMode::mask);
}

void test_binary(void**) { assert_int_equal(load(binary_gltf()).meshes[0].vertices.size(), 6); }

// At each word of the header and of the chunks: none, too much, and all of it.
void test_binary_words(void**) {
    const std::string good = binary_gltf();
    uint32_t json_size = 0;
    std::memcpy(&json_size, &good[12], sizeof json_size);
    const size_t chunk = 20 + json_size;
    for (const size_t at : {size_t(8), size_t(12), size_t(16), chunk, chunk + 4}) {
        // The last ends within the 8 bytes of the chunk's own header beyond the file.
        for (const uint32_t value : {0u, 3u, uint32_t(good.size()) + 4u, 0x7ffffffcu, 0xfffffffcu, 0xffffffffu,
                                     uint32_t(buffer_bytes().size()) + 4u}) {
            std::string file = good;
            std::memcpy(&file[at], &value, sizeof value);
            check_refused(file, "");
        }
    }
}

// Every length: nothing is read beyond the end, and only the whole file loads.
void test_binary_lengths(void**) {
    const std::string good = binary_gltf();
    for (size_t size = 0; size < good.size(); size += size < 32 ? 1 : 61) { check_refused(good.substr(0, size), ""); }
}

void test_deep_json(void**) {
    const std::string extras = "\"extras\": " + std::string(300, '[') + std::string(300, ']') + ", \"scene\": 0";
    check_refused(good_with("\"scene\": 0", extras), "more than 256 levels deep");
    check_refused(std::string(1 << 20, '['), "more than 256 levels deep");
}

void test_many_values(void**) {
    std::string list = "[0";
    for (int i = 0; i < (1 << 22); ++i) { list += ",0"; }
    check_refused(good_with("\"scene\": 0", "\"extras\": " + list + "], \"scene\": 0"), "more than 4194304 values");
}

// Each the only child of the one before.
void test_deep_nodes(void**) {
    std::string nodes = "\"nodes\": [";
    for (int i = 1; i <= 300; ++i) { nodes += "{\"children\": [" + std::to_string(i) + "]}, "; }
    std::string json = good_with("\"nodes\": [{\"mesh\": 0, \"skin\": 0}", nodes + "{\"mesh\": 0}");
    check_refused(json, "nested more than 256 levels deep");
}

// A small file that would draw 65 times a million vertices.
void test_many_drawn_vertices(void**) {
    std::string nodes = "\"nodes\": [0", more;
    for (int i = 5; i < 70; ++i) { nodes += ", " + std::to_string(i), more += "{\"mesh\": 1}, "; }
    std::string json = good_with("\"scenes\": [{\"nodes\": [0, 1, 3, 4]}]", "\"scenes\": [{" + nodes + ", 1, 3, 4]}]");
    more.resize(more.size() - 2);
    replace(&json, "{\"light\": 0}}}]", "{\"light\": 0}}}, " + more + "]");
    replace(&json, "\"mode\": 4}]}]",
            "\"mode\": 4}]}, {\"primitives\": [{\"attributes\": {\"POSITION\": 9, \"NORMAL\": 9}}]}]");
    replace(&json, "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2, \"type\": \"VEC4\"}",
            "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2, \"type\": \"VEC4\"}, "
            "{\"componentType\": 5126, \"count\": 1048576, \"type\": \"VEC3\"}");
    check_refused(json, "draw more than 67108864 vertices");
}

// Three indices a triangle are three times what the file holds.
void test_long_strip(void**) {
    const int count = (1 << 24) / 3 + 3;
    write(directory / "scenes" / "zeros.bin", std::string(size_t(count), '\0'));
    std::string json =
        good_with("\"mode\": 4}]", "\"mode\": 4}, {\"mode\": 5, \"attributes\": {\"POSITION\": 0}, \"indices\": 9}]");
    replace(&json, "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2, \"type\": \"VEC4\"}",
            "\"byteOffset\": 460, \"componentType\": 5126, \"count\": 2, \"type\": \"VEC4\"}, {\"bufferView\": 1, "
            "\"componentType\": 5121, \"count\": " +
                std::to_string(count) + ", \"type\": \"SCALAR\"}");
    replace(&json, "\"byteLength\": 572}],",
            "\"byteLength\": 572}, {\"buffer\": 1, \"byteLength\": " + std::to_string(count) + "}],");
    replace(&json, "\"}]}", "\"}, {\"byteLength\": " + std::to_string(count) + ", \"uri\": \"zeros.bin\"}]}");
    check_refused(json, "more than 16777216 vertices or indices");
}

void test_many_joints(void**) {
    std::string joints = "\"joints\": [1, 2";
    for (int i = 0; i < 16384; ++i) { joints += ", 2"; }
    std::string json = good_with("\"joints\": [1, 2", joints);
    replace(&json, ", \"inverseBindMatrices\": 6", "");
    check_refused(json, "more than 16384 joints");
}

void test_long_names(void**) {
    const std::string name(100000, 'x');
    check_refused(
        good_with("\"extensionsUsed\": [", "\"extensionsRequired\": [\"" + name + "\\n\"], \"extensionsUsed\": ["),
        "xxx");
}

void test_large_file(void**) {
    write(scene_path(), "");
    fs::resize_file(scene_path(), (uintmax_t(512) << 20) + 1); // takes no room
    Scene scene;
    std::string error;
    assert_false(load_gltf(scene_path(), &scene, &error));
    if (error.find("larger than 512 MiB") == std::string::npos) { fail_msg("%s", error.c_str()); }
}

// ---- All of it --------------------------------------------------------------------------------------------

int make_directory(void**) {
    directory = fs::temp_directory_path() / ("test_gltf." + std::to_string(getpid()));
    fs::create_directories(directory / "scenes" / "below");
    write(directory / "outside.bin", buffer_bytes());
    write(directory / "scenes" / "a buffer.bin", buffer_bytes());
    write(directory / "scenes" / "below" / "buffer.bin", buffer_bytes());
    write(directory / "scenes" / "short.bin", "short");
    write(directory / "scenes" / "large.bin", "");
    fs::resize_file(directory / "scenes" / "large.bin", (uintmax_t(512) << 20) + 1);
    fs::create_symlink("/dev/null", directory / "scenes" / "null");
    return 0;
}

int remove_directory(void**) {
    fs::remove_all(directory);
    return 0;
}

} // namespace

int main() {
    std::vector<CMUnitTest> tests = {
        cmocka_unit_test(test_contents),     cmocka_unit_test(test_binary),
        cmocka_unit_test(test_binary_words), cmocka_unit_test(test_binary_lengths),
        cmocka_unit_test(test_deep_json),    cmocka_unit_test(test_many_values),
        cmocka_unit_test(test_deep_nodes),   cmocka_unit_test(test_many_drawn_vertices),
        cmocka_unit_test(test_long_strip),   cmocka_unit_test(test_many_joints),
        cmocka_unit_test(test_long_names),   cmocka_unit_test(test_large_file),
    };
    for (const Case& c : kCases) { tests.push_back({c.name, test_case, nullptr, nullptr, const_cast<Case*>(&c)}); }
    return _cmocka_run_group_tests("gltf", tests.data(), tests.size(), make_directory, remove_directory);
}
