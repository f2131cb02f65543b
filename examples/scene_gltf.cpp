// Reads glTF 2.0 through tinygltf. tinygltf parses but hardly validates, so everything that its model
// refers to (files, buffer ranges, indices, node graph) is checked here before use.
#include "scene.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <stb_image.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

// Limits, so that no file makes the loader take all memory or all day. Each is checked before what it limits is allocated.
constexpr uintmax_t kMaxFileBytes = uintmax_t(512) << 20;   // of a file
constexpr uintmax_t kMaxSceneBytes = uintmax_t(1024) << 20; // of all files of a scene
constexpr int kMaxJsonDepth = 256;                          // tinygltf recurses once per level of "extras"
constexpr size_t kMaxJsonValues = size_t(1) << 22;          // tinygltf takes up to 1 KiB for one
constexpr size_t kMaxElements = size_t(1) << 24;            // vertices or indices of a scene: about 1.5 GiB of vertices
constexpr size_t kMaxZeros = size_t(1) << 20;               // elements of an accessor for which the file holds no data
constexpr size_t kMaxDrawn = size_t(1) << 26;               // vertices of all nodes, each as often as it is drawn
constexpr size_t kMaxImageBytes = size_t(1) << 31;          // decoded pixels of all images of a scene
constexpr int kMaxImageSize = 16384;                        // pixels, width and height
constexpr int kMaxNodeDepth = 256;
constexpr size_t kMaxJoints = 16384; // of all skins: what fits into the smallest buffer texture, 4 texels a matrix
constexpr size_t kMaxReason = 300;   // characters of an error sentence, which quotes from the file

// Ends the loading: load_gltf turns it into its error sentence.
[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }

std::string label(const char* kind, size_t index) { return std::string(kind) + " " + std::to_string(index); }

template <typename T>
const T& at(const std::vector<T>& list, int index, const char* kind) {
    if (index < 0 || size_t(index) >= list.size()) {
        fail(std::string(kind) + " " + std::to_string(index) + " does not exist");
    }
    return list[size_t(index)];
}

// tinygltf has -1 for a reference that is not there.
bool is_given(int index, const char* kind) {
    if (index < -1) { fail(std::string(kind) + " " + std::to_string(index) + " does not exist"); }
    return index >= 0;
}

// ---- Files --------------------------------------------------------------------------------------------

Bytes read_file(const fs::path& path) {
    if (!fs::is_regular_file(path)) { fail("the file \"" + path.string() + "\" does not exist"); }
    const uintmax_t size = fs::file_size(path);
    if (size > kMaxFileBytes) { fail("the file \"" + path.string() + "\" is larger than 512 MiB"); }
    Bytes bytes(static_cast<size_t>(size));
    std::ifstream stream(path, std::ios::binary);
    if (!stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size))) {
        fail("the file \"" + path.string() + "\" cannot be read");
    }
    return bytes;
}

// A scene may only name files below its own directory.
void check_uri(const std::string& uri) {
    const std::string shown = "the URI \"" + uri.substr(0, 100) + "\"";
    if (uri.find_first_of(":\\") != std::string::npos) {
        fail(shown + " has a scheme, a drive or a backslash, but only relative paths are allowed");
    }
    const fs::path path(uri);
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end()) {
        fail(shown + " leaves the directory of the scene");
    }
}

// tinygltf must not see exceptions while it reads files, and it only warns about a missing image.
struct SceneDirectory {
    fs::path path;
    uintmax_t bytes;   // read so far
    std::string error; // of the first read that failed
};

bool read_scene_file(Bytes* out, std::string* error, const std::string& uri, void* user_data) {
    auto* directory = static_cast<SceneDirectory*>(user_data);
    try {
        check_uri(uri);
        *out = read_file(directory->path / uri);
        directory->bytes += out->size();
        if (directory->bytes > kMaxSceneBytes) { fail("its files are larger than 1024 MiB together"); }
        return true;
    } catch (const std::exception& exception) {
        *error = exception.what();
        if (directory->error.empty()) { directory->error = exception.what(); }
        return false;
    }
}

tinygltf::FsCallbacks file_callbacks(SceneDirectory* directory) {
    tinygltf::FsCallbacks callbacks = {};
    // Always "found", so that read_scene_file decides and can say what is wrong.
    callbacks.FileExists = [](const std::string&, void*) { return true; };
    callbacks.ExpandFilePath = [](const std::string& uri, void*) { return uri; };
    callbacks.ReadWholeFile = read_scene_file;
    callbacks.user_data = directory;
    return callbacks;
}

// Decoding waits until the buffer views are validated: here, "bytes" of a buffer view may lie anywhere.
bool keep_encoded_image(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                        const unsigned char* bytes, int size, void*) {
    if (image->bufferView < 0) { image->image.assign(bytes, bytes + size); }
    return true;
}

bool is_binary_gltf(const Bytes& file) { return file.size() >= 20 && std::memcmp(file.data(), "glTF", 4) == 0; }

uint32_t load_u32(const Bytes& file, size_t offset) {
    uint32_t value = 0;
    std::memcpy(&value, file.data() + offset, sizeof value);
    return value;
}

// The JSON chunk of a .glb starts at byte 20, its length stands at byte 12.
std::string_view json_text(const Bytes& file) {
    const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
    return is_binary_gltf(file) ? text.substr(20, load_u32(file, 12)) : text;
}

// tinygltf forgets the 8 bytes of the chunk's own header and would read beyond the end of the file.
void check_binary_chunk(const Bytes& file) {
    const size_t header = size_t(20) + load_u32(file, 12);
    if (header + 8 <= file.size() && header + 8 + load_u32(file, header) > file.size()) {
        fail("its binary chunk is truncated");
    }
}

// Counts what opens and what separates values, and so every value but at most one.
void check_json(std::string_view json) {
    int depth = 0;
    size_t values = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string && c == '\\') {
            ++i;
        } else if (c == '"') {
            in_string = !in_string;
        } else if (!in_string) {
            const bool opens = c == '{' || c == '[', closes = c == '}' || c == ']';
            depth += int(opens) - int(closes);
            values += size_t(opens || c == ',');
            if (depth > kMaxJsonDepth) {
                fail("its JSON is nested more than " + std::to_string(kMaxJsonDepth) + " levels deep");
            }
            if (values > kMaxJsonValues) {
                fail("its JSON holds more than " + std::to_string(kMaxJsonValues) + " values");
            }
        }
    }
}

// What was quoted from a file may hold anything.
std::string one_line(std::string text) {
    text.resize(std::min(text.find_last_not_of(" :.\n") + 1, kMaxReason));
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
    return text;
}

// tinygltf reports most of what is wrong, and throws the rest.
bool parse(const Bytes& file, bool is_binary, SceneDirectory* directory, tinygltf::Model* model, std::string* error) {
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks(file_callbacks(directory));
    parser.SetImageLoader(keep_encoded_image, nullptr);
    std::string warning;
    const auto size = static_cast<unsigned int>(file.size());
    try {
        if (is_binary) { return parser.LoadBinaryFromMemory(model, error, &warning, file.data(), size); }
        // An empty base directory makes tinygltf hand the bare URIs to read_scene_file.
        const char* text = reinterpret_cast<const char*>(file.data());
        return parser.LoadASCIIFromString(model, error, &warning, text, size, "");
    } catch (const std::exception& exception) {
        *error = exception.what();
        return false;
    }
}

tinygltf::Model parse_file(const fs::path& path) {
    const Bytes file = read_file(path);
    const bool is_binary = is_binary_gltf(file);
    check_json(json_text(file));
    if (is_binary) { check_binary_chunk(file); }

    SceneDirectory directory{path.parent_path(), file.size(), ""};
    tinygltf::Model model;
    std::string error;
    const bool parsed = parse(file, is_binary, &directory, &model, &error);
    if (!directory.error.empty()) { fail(directory.error); }
    if (!parsed) { fail("it is not valid glTF: " + error); }
    return model;
}

void check_version(const tinygltf::Model& model) {
    const std::string& version = model.asset.version;
    if (version.substr(0, 2) != "2.") { fail("it is of version \"" + version + "\", but only glTF 2 is supported"); }
}

void check_required_extensions(const tinygltf::Model& model) {
    static const std::array<std::string, 4> supported = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                                         "KHR_materials_unlit", "KHR_mesh_quantization"};
    for (const std::string& name : model.extensionsRequired) {
        if (std::find(supported.begin(), supported.end(), name) == supported.end()) {
            fail("it requires the extension " + name + ", which is not supported");
        }
    }
}

// ---- Accessors ----------------------------------------------------------------------------------------

// Written so that no sum can overflow.
bool range_fits(uint64_t offset, uint64_t size, uint64_t total) { return offset <= total && size <= total - offset; }

struct Span {
    const unsigned char* data;
    uint64_t size; // bytes
};

Span buffer_view_bytes(const tinygltf::Model& model, int index) {
    const tinygltf::BufferView& view = at(model.bufferViews, index, "buffer view");
    const tinygltf::Buffer& buffer = at(model.buffers, view.buffer, "buffer");
    if (!range_fits(view.byteOffset, view.byteLength, buffer.data.size())) {
        fail(label("buffer view", size_t(index)) + " reaches beyond its buffer");
    }
    return {buffer.data.data() + view.byteOffset, view.byteLength};
}

// Equally spaced elements inside a buffer view.
struct Elements {
    const unsigned char* data;
    uint64_t stride; // bytes

    const unsigned char* operator[](size_t index) const { return data + index * stride; }
};

Elements view_elements(const tinygltf::Model& model, int view_index, uint64_t offset, uint64_t count,
                       uint64_t element_size) {
    const Span view = buffer_view_bytes(model, view_index);
    const uint64_t view_stride = model.bufferViews[size_t(view_index)].byteStride;
    const uint64_t stride = view_stride != 0 ? view_stride : element_size;
    if (stride < element_size) {
        fail(label("buffer view", size_t(view_index)) + " has a stride shorter than the elements of an accessor");
    }
    const uint64_t size = count == 0 ? 0 : stride * (count - 1) + element_size;
    if (!range_fits(offset, size, view.size)) {
        fail("an accessor reaches beyond " + label("buffer view", size_t(view_index)));
    }
    return {view.data + offset, stride};
}

size_t component_size(int component_type) {
    const int size = tinygltf::GetComponentSizeInBytes(uint32_t(component_type));
    if (size <= 0) { fail("an accessor has an unknown component type"); }
    return size_t(size);
}

template <typename T>
T load_as(const unsigned char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

uint32_t load_index(const unsigned char* bytes, int component_type) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return *bytes;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return load_as<uint16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return load_as<uint32_t>(bytes);
    default: fail("an index accessor is not of an unsigned integer type");
    }
}

float load_float(const unsigned char* bytes, int component_type, bool normalized) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return load_as<float>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return float(*bytes) / (normalized ? 255.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return float(load_as<uint16_t>(bytes)) / (normalized ? 65535.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const float value = load_as<int8_t>(bytes);
        return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const float value = load_as<int16_t>(bytes);
        return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    default: fail("a vertex accessor is of a component type that glTF does not allow");
    }
}

// The elements of an accessor as packed raw bytes, sparse substitution done.
Bytes packed_elements(const tinygltf::Model& model, const tinygltf::Accessor& accessor, size_t element_size) {
    if (accessor.count > kMaxElements) {
        fail("an accessor has more than " + std::to_string(kMaxElements) + " elements");
    }
    const bool has_data = is_given(accessor.bufferView, "buffer view");
    if (!has_data && accessor.count > kMaxZeros) {
        fail("an accessor without a buffer view has more than " + std::to_string(kMaxZeros) + " elements");
    }
    Bytes packed;
    if (has_data) {
        const Elements source =
            view_elements(model, accessor.bufferView, accessor.byteOffset, accessor.count, element_size);
        packed.resize(accessor.count * element_size);
        for (size_t i = 0; i < accessor.count; ++i) { std::memcpy(&packed[i * element_size], source[i], element_size); }
    }
    packed.resize(accessor.count * element_size);
    if (!accessor.sparse.isSparse) { return packed; }
    const auto& sparse = accessor.sparse;
    if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) {
        fail("a sparse accessor has a negative count or offset");
    }
    const auto count = size_t(sparse.count);
    const Elements indices = view_elements(model, sparse.indices.bufferView, uint64_t(sparse.indices.byteOffset), count,
                                           component_size(sparse.indices.componentType));
    const Elements values =
        view_elements(model, sparse.values.bufferView, uint64_t(sparse.values.byteOffset), count, element_size);
    for (size_t i = 0; i < count; ++i) {
        const size_t target = load_index(indices[i], sparse.indices.componentType);
        if (target >= accessor.count) { fail("a sparse accessor replaces an element that does not exist"); }
        std::memcpy(&packed[target * element_size], values[i], element_size);
    }
    return packed;
}

std::vector<uint32_t> read_indices(const tinygltf::Model& model, int accessor_index) {
    const tinygltf::Accessor& accessor = at(model.accessors, accessor_index, "accessor");
    if (accessor.type != TINYGLTF_TYPE_SCALAR) {
        fail(label("accessor", size_t(accessor_index)) + " holds indices but is not of type SCALAR");
    }
    const size_t size = component_size(accessor.componentType);
    const Bytes packed = packed_elements(model, accessor, size);
    std::vector<uint32_t> indices(accessor.count);
    for (size_t i = 0; i < indices.size(); ++i) { indices[i] = load_index(&packed[i * size], accessor.componentType); }
    return indices;
}

// Components that the accessor lacks keep the value of "missing".
std::vector<glm::vec4> read_vectors(const tinygltf::Model& model, int accessor_index, int min_components,
                                    int max_components, glm::vec4 missing) {
    const tinygltf::Accessor& accessor = at(model.accessors, accessor_index, "accessor");
    const int components = tinygltf::GetNumComponentsInType(uint32_t(accessor.type));
    if (components < min_components || components > max_components) {
        fail(label("accessor", size_t(accessor_index)) + " has the wrong number of components");
    }
    const size_t size = component_size(accessor.componentType);
    const size_t element_size = size * size_t(components);
    const Bytes packed = packed_elements(model, accessor, element_size);
    std::vector<glm::vec4> vectors(accessor.count, missing);
    for (size_t i = 0; i < vectors.size(); ++i) {
        for (int c = 0; c < components; ++c) {
            const unsigned char* bytes = &packed[i * element_size + size_t(c) * size];
            vectors[i][c] = load_float(bytes, accessor.componentType, accessor.normalized);
            if (!std::isfinite(vectors[i][c])) {
                fail(label("accessor", size_t(accessor_index)) + " contains a value that is not finite");
            }
        }
    }
    return vectors;
}

bool all_finite(const glm::mat4& matrix) {
    const float* numbers = glm::value_ptr(matrix);
    return std::all_of(numbers, numbers + 16, [](float x) { return std::isfinite(x); });
}

// Inverse bind matrices; the fourth row is implied.
std::vector<glm::mat4> read_matrices(const tinygltf::Model& model, int accessor_index) {
    const tinygltf::Accessor& accessor = at(model.accessors, accessor_index, "accessor");
    const std::string name = label("accessor", size_t(accessor_index));
    if (accessor.type != TINYGLTF_TYPE_MAT4 || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) {
        fail(name + " holds inverse bind matrices but is not of type MAT4 and float");
    }
    if (accessor.count > kMaxJoints) { fail(name + " has more than " + std::to_string(kMaxJoints) + " matrices"); }
    const Bytes packed = packed_elements(model, accessor, sizeof(glm::mat4));
    std::vector<glm::mat4> matrices(accessor.count);
    for (size_t i = 0; i < matrices.size(); ++i) {
        matrices[i] = load_as<glm::mat4>(&packed[i * sizeof(glm::mat4)]);
        if (!all_finite(matrices[i])) { fail(name + " contains a value that is not finite"); }
    }
    return matrices;
}

// ---- Meshes -------------------------------------------------------------------------------------------

glm::vec3 normalized_or(glm::vec3 vector, glm::vec3 fallback) {
    const float length = glm::length(vector);
    return length > 0.0f && std::isfinite(length) ? vector / length : fallback;
}

void append_triangle(std::vector<uint32_t>* list, uint32_t a, uint32_t b, uint32_t c) {
    list->insert(list->end(), {a, b, c});
}

void check_elements(size_t vertices, size_t indices) {
    if (std::max(vertices, indices) > kMaxElements) {
        fail("its meshes have more than " + std::to_string(kMaxElements) + " vertices or indices");
    }
}

std::vector<uint32_t> triangle_list(std::vector<uint32_t> source, int mode) {
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        source.resize(source.size() / 3 * 3);
        return source;
    }
    check_elements(0, source.size() * 3);
    std::vector<uint32_t> list;
    for (size_t i = 2; i < source.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
            append_triangle(&list, source[0], source[i - 1], source[i]);
        } else if (i % 2 == 0) {
            append_triangle(&list, source[i - 2], source[i - 1], source[i]);
        } else { // every second triangle of a strip runs the other way round
            append_triangle(&list, source[i - 1], source[i - 2], source[i]);
        }
    }
    return list;
}

// Flat normals differ between the triangles at a vertex, so each corner gets a vertex of its own.
void generate_flat_normals(Mesh* mesh) {
    std::vector<Vertex> corners;
    corners.reserve(mesh->indices.size());
    for (uint32_t index : mesh->indices) { corners.push_back(mesh->vertices[index]); }
    for (size_t i = 0; i < corners.size(); i += 3) {
        const glm::vec3 edge1 = corners[i + 1].position - corners[i].position;
        const glm::vec3 edge2 = corners[i + 2].position - corners[i].position;
        const glm::vec3 normal = normalized_or(glm::cross(edge1, edge2), glm::vec3(0.0f, 1.0f, 0.0f));
        for (size_t corner = i; corner < i + 3; ++corner) {
            corners[corner].normal = normal;
            mesh->indices[corner] = uint32_t(corner);
        }
    }
    mesh->vertices = std::move(corners);
}

glm::vec3 any_perpendicular(glm::vec3 normal) {
    const glm::vec3 axis = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return normalized_or(glm::cross(axis, normal), axis);
}

// Averages the directions in which u and v grow over the triangles at each vertex.
void generate_tangents(Mesh* mesh) {
    std::vector<glm::vec3> u_directions(mesh->vertices.size(), glm::vec3(0.0f));
    std::vector<glm::vec3> v_directions(mesh->vertices.size(), glm::vec3(0.0f));
    for (size_t i = 0; i < mesh->indices.size(); i += 3) {
        const Vertex& a = mesh->vertices[mesh->indices[i]];
        const Vertex& b = mesh->vertices[mesh->indices[i + 1]];
        const Vertex& c = mesh->vertices[mesh->indices[i + 2]];
        const glm::vec3 edge1 = b.position - a.position;
        const glm::vec3 edge2 = c.position - a.position;
        const glm::vec2 uv1 = b.uv - a.uv;
        const glm::vec2 uv2 = c.uv - a.uv;
        const float mirrored = uv1.x * uv2.y - uv2.x * uv1.y < 0.0f ? -1.0f : 1.0f;
        for (size_t corner = i; corner < i + 3; ++corner) {
            u_directions[mesh->indices[corner]] += (edge1 * uv2.y - edge2 * uv1.y) * mirrored;
            v_directions[mesh->indices[corner]] += (edge2 * uv1.x - edge1 * uv2.x) * mirrored;
        }
    }
    for (size_t i = 0; i < mesh->vertices.size(); ++i) {
        Vertex& vertex = mesh->vertices[i];
        const glm::vec3 in_plane = u_directions[i] - vertex.normal * glm::dot(vertex.normal, u_directions[i]);
        const glm::vec3 tangent = normalized_or(in_plane, any_perpendicular(vertex.normal));
        const float side = glm::dot(glm::cross(vertex.normal, tangent), v_directions[i]);
        vertex.tangent = glm::vec4(tangent, side < 0.0f ? -1.0f : 1.0f);
    }
}

// Calls set(vertex, value) for every vertex; returns false when the primitive lacks the attribute.
template <typename Set>
bool read_attribute(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const char* name,
                    int min_components, int max_components, Mesh* mesh, Set set) {
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end()) { return false; }
    const std::vector<glm::vec4> values =
        read_vectors(model, found->second, min_components, max_components, glm::vec4(1.0f));
    if (values.size() != mesh->vertices.size()) {
        fail(std::string(name) + " has a different number of elements than POSITION");
    }
    for (size_t i = 0; i < values.size(); ++i) { set(&mesh->vertices[i], values[i]); }
    return true;
}

// A weight of 0 may come with any joint: then joint 0 does as well. Without any weight the first joint has it all.
void set_weights(Vertex* vertex, glm::vec4 weights) {
    if (glm::any(glm::lessThan(weights, glm::vec4(0.0f)))) { fail("a vertex has a negative joint weight"); }
    const float sum = weights.x + weights.y + weights.z + weights.w;
    vertex->weights = sum > 0.0f ? weights / sum : glm::vec4(1.0f, 0.0f, 0.0f, 0.0f);
    for (int i = 0; i < 4; ++i) {
        if (vertex->weights[i] == 0.0f) { vertex->joints[i] = 0; }
    }
}

void check_joint_type(const tinygltf::Accessor& accessor) {
    const bool is_unsigned = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                             accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    if (!is_unsigned || accessor.normalized) { fail("the joints of a primitive are not unsigned bytes or shorts"); }
}

// Four joints a vertex; a second set of attributes is left out, and its share is the others'.
void read_influences(const tinygltf::Model& model, const tinygltf::Primitive& primitive, Mesh* mesh) {
    const auto joints = primitive.attributes.find("JOINTS_0");
    const bool has_joints = joints != primitive.attributes.end();
    if (has_joints != (primitive.attributes.count("WEIGHTS_0") > 0)) {
        fail("a primitive has joints without weights, or weights without joints");
    }
    if (!has_joints) { return; }
    check_joint_type(at(model.accessors, joints->second, "accessor"));
    read_attribute(model, primitive, "JOINTS_0", 4, 4, mesh,
                   [](Vertex* vertex, glm::vec4 value) { vertex->joints = value; });
    read_attribute(model, primitive, "WEIGHTS_0", 4, 4, mesh, set_weights);
}

void read_index_list(const tinygltf::Model& model, const tinygltf::Primitive& primitive, Mesh* mesh) {
    std::vector<uint32_t> indices;
    if (is_given(primitive.indices, "accessor")) {
        indices = read_indices(model, primitive.indices);
    } else {
        for (size_t i = 0; i < mesh->vertices.size(); ++i) { indices.push_back(uint32_t(i)); }
    }
    for (uint32_t index : indices) {
        if (index >= mesh->vertices.size()) {
            fail("a primitive uses vertex " + std::to_string(index) + ", but it only has " +
                 std::to_string(mesh->vertices.size()) + " vertices");
        }
    }
    mesh->indices = triangle_list(std::move(indices), primitive.mode);
}

Mesh read_primitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) { fail("a primitive has no POSITION"); }
    Mesh mesh;
    for (const glm::vec4& value : read_vectors(model, position->second, 3, 3, glm::vec4(1.0f))) {
        mesh.vertices.emplace_back().position = glm::vec3(value);
    }
    read_index_list(model, primitive, &mesh);
    read_attribute(model, primitive, "TEXCOORD_0", 2, 2, &mesh,
                   [](Vertex* vertex, glm::vec4 value) { vertex->uv = glm::vec2(value); });
    read_attribute(model, primitive, "COLOR_0", 3, 4, &mesh,
                   [](Vertex* vertex, glm::vec4 value) { vertex->color = value; });
    const bool has_normals =
        read_attribute(model, primitive, "NORMAL", 3, 3, &mesh, [](Vertex* vertex, glm::vec4 value) {
            vertex->normal = normalized_or(glm::vec3(value), vertex->normal);
        });
    const bool has_tangents = read_attribute(model, primitive, "TANGENT", 4, 4, &mesh,
                                             [](Vertex* vertex, glm::vec4 value) { vertex->tangent = value; });
    read_influences(model, primitive, &mesh);
    if (!has_normals) { generate_flat_normals(&mesh); }
    // Tangents belong to the normals that they came with, and only a normal map needs them.
    const bool has_material = is_given(primitive.material, "material");
    const bool has_normal_map =
        has_material && at(model.materials, primitive.material, "material").normalTexture.index >= 0;
    if (has_normal_map && (!has_tangents || !has_normals)) { generate_tangents(&mesh); }
    return mesh;
}

// Points and lines are left out.
bool is_triangles(const tinygltf::Primitive& primitive) {
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
        fail("a primitive has the mode " + std::to_string(primitive.mode) + ", which glTF does not have");
    }
    return primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
           primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

// The meshes of the scene that one glTF mesh became: one for each of its triangle primitives.
using MeshIndices = std::vector<int>;

std::vector<MeshIndices> read_meshes(const tinygltf::Model& model, Scene* scene) {
    std::vector<MeshIndices> mesh_indices(model.meshes.size());
    size_t vertices = 0;
    size_t indices = 0;
    for (size_t i = 0; i < model.meshes.size(); ++i) {
        for (const tinygltf::Primitive& primitive : model.meshes[i].primitives) {
            if (!is_triangles(primitive)) { continue; }
            Mesh mesh = read_primitive(model, primitive);
            // The default material of glTF stands behind the materials of the file.
            mesh.material = primitive.material >= 0 ? primitive.material : int(model.materials.size());
            vertices += mesh.vertices.size();
            indices += mesh.indices.size();
            check_elements(vertices, indices);
            mesh_indices[i].push_back(int(scene->meshes.size()));
            scene->meshes.push_back(std::move(mesh));
        }
    }
    return mesh_indices;
}

// ---- Images, textures, materials ----------------------------------------------------------------------

Span encoded_image(const tinygltf::Model& model, const tinygltf::Image& image) {
    if (is_given(image.bufferView, "buffer view")) { return buffer_view_bytes(model, image.bufferView); }
    return {image.image.data(), image.image.size()};
}

// stb_image knows more formats than glTF, which nothing here asks for.
bool is_png_or_jpeg(Span file) {
    static const unsigned char png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, jpeg[] = {0xff, 0xd8, 0xff};
    const auto begins = [&](const unsigned char* signature, size_t size) {
        return file.size >= size && std::memcmp(file.data, signature, size) == 0;
    };
    return begins(png, sizeof png) || begins(jpeg, sizeof jpeg);
}

// Takes its pixels, 4 bytes each, from *budget.
Image decode_image(Span encoded, const std::string& name, size_t* budget) {
    const auto size = int(std::min<uint64_t>(encoded.size, kMaxFileBytes));
    int width = 0, height = 0, channels = 0;
    if (!is_png_or_jpeg(encoded) || !stbi_info_from_memory(encoded.data, size, &width, &height, &channels)) {
        fail(name + " is not a PNG or JPEG image");
    }
    if (width > kMaxImageSize || height > kMaxImageSize) {
        fail(name + " is wider or higher than " + std::to_string(kMaxImageSize) + " pixels");
    }
    const size_t bytes = size_t(width) * size_t(height) * 4;
    if (bytes > *budget) { fail("its images decode to more than 2 GiB"); }
    *budget -= bytes;
    stbi_uc* pixels = stbi_load_from_memory(encoded.data, size, &width, &height, &channels, STBI_rgb_alpha);
    if (pixels == nullptr) { fail(name + " cannot be decoded: " + stbi_failure_reason()); }
    Image image{width, height, {}};
    image.rgba.assign(pixels, pixels + bytes);
    stbi_image_free(pixels);
    return image;
}

void read_images(const tinygltf::Model& model, Scene* scene) {
    size_t budget = kMaxImageBytes;
    for (size_t i = 0; i < model.images.size(); ++i) {
        scene->images.push_back(decode_image(encoded_image(model, model.images[i]), label("image", i), &budget));
    }
}

Wrap read_wrap(int gltf_wrap) {
    switch (gltf_wrap) {
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE: return Wrap::clamp;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT: return Wrap::mirror;
    default: return Wrap::repeat;
    }
}

void read_textures(const tinygltf::Model& model, Scene* scene) {
    for (const tinygltf::Texture& source : model.textures) {
        at(model.images, source.source, "image");
        Texture texture;
        texture.image = source.source;
        if (is_given(source.sampler, "sampler")) {
            const tinygltf::Sampler& sampler = at(model.samplers, source.sampler, "sampler");
            texture.wrap_u = read_wrap(sampler.wrapS);
            texture.wrap_v = read_wrap(sampler.wrapT);
            const bool nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
            texture.filter = nearest ? Filter::nearest : Filter::linear;
        }
        scene->textures.push_back(texture);
    }
}

float finite(double value) {
    if (!std::isfinite(static_cast<float>(value))) {
        fail("a material, node, camera or light contains a value that is not finite");
    }
    return static_cast<float>(value);
}

// An empty list means that the file leaves the default.
template <typename Vector>
Vector read_vector(const std::vector<double>& values, Vector fallback) {
    if (values.empty()) { return fallback; }
    if (values.size() != size_t(Vector::length())) {
        fail("a material, node or light has a list of " + std::to_string(values.size()) + " instead of " +
             std::to_string(Vector::length()) + " numbers");
    }
    for (int i = 0; i < Vector::length(); ++i) { fallback[i] = finite(values[size_t(i)]); }
    return fallback;
}

// For tinygltf's TextureInfo and its relatives.
template <typename Info>
int read_texture_index(const tinygltf::Model& model, const Info& info) {
    if (!is_given(info.index, "texture")) { return -1; }
    at(model.textures, info.index, "texture");
    if (info.texCoord != 0) {
        fail("a material uses TEXCOORD_" + std::to_string(info.texCoord) + ", but only TEXCOORD_0 is supported");
    }
    return info.index;
}

// The extra property "radiance" overrides the emissive factor, which cannot exceed 1.
glm::vec3 read_emissive(const tinygltf::Material& source) {
    if (source.extras.Has("radiance")) {
        const tinygltf::Value& radiance = source.extras.Get("radiance");
        glm::vec3 numbers(0.0f);
        for (int i = 0; i < 3; ++i) {
            if (radiance.ArrayLen() != 3 || !radiance.Get(i).IsNumber()) {
                fail("the radiance of a material is not a list of three numbers");
            }
            numbers[i] = finite(radiance.Get(i).GetNumberAsDouble());
        }
        return numbers;
    }
    const auto factor = read_vector(source.emissiveFactor, glm::vec3(0.0f));
    const auto extension = source.extensions.find("KHR_materials_emissive_strength");
    if (extension == source.extensions.end() || !extension->second.Has("emissiveStrength")) { return factor; }
    return factor * finite(extension->second.Get("emissiveStrength").GetNumberAsDouble());
}

AlphaMode read_alpha_mode(const std::string& gltf_mode) {
    if (gltf_mode == "MASK") { return AlphaMode::mask; }
    if (gltf_mode == "BLEND") { return AlphaMode::blend; }
    if (gltf_mode != "OPAQUE" && !gltf_mode.empty()) { fail("a material has an unknown alpha mode"); }
    return AlphaMode::opaque;
}

Material read_material(const tinygltf::Model& model, const tinygltf::Material& source) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    Material material;
    material.name = source.name;
    material.base_color = read_vector(pbr.baseColorFactor, glm::vec4(1.0f));
    material.base_color_texture = read_texture_index(model, pbr.baseColorTexture);
    material.metallic = finite(pbr.metallicFactor);
    material.roughness = finite(pbr.roughnessFactor);
    material.metallic_roughness_texture = read_texture_index(model, pbr.metallicRoughnessTexture);
    material.normal_texture = read_texture_index(model, source.normalTexture);
    material.normal_scale = finite(source.normalTexture.scale);
    material.emissive = read_emissive(source);
    material.emissive_texture = read_texture_index(model, source.emissiveTexture);
    material.alpha_mode = read_alpha_mode(source.alphaMode);
    material.alpha_cutoff = finite(source.alphaCutoff);
    material.double_sided = source.doubleSided;
    material.unlit = source.extensions.count("KHR_materials_unlit") > 0;
    return material;
}

void read_materials(const tinygltf::Model& model, Scene* scene) {
    for (const tinygltf::Material& source : model.materials) {
        scene->materials.push_back(read_material(model, source));
    }
    scene->materials.push_back(read_material(model, tinygltf::Material()));
}

// ---- Nodes, cameras and lights ------------------------------------------------------------------------

glm::mat4 read_matrix(const tinygltf::Node& node) {
    glm::mat4 matrix(1.0f);
    if (node.matrix.size() != 16) { fail("the matrix of a node does not have 16 numbers"); }
    std::transform(node.matrix.begin(), node.matrix.end(), glm::value_ptr(matrix), finite);
    return matrix;
}

Transform read_transform(const tinygltf::Node& node) {
    const auto xyzw = read_vector(node.rotation, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
    Transform transform;
    transform.translation = read_vector(node.translation, glm::vec3(0.0f));
    transform.rotation = glm::normalize(glm::quat(xyzw.w, xyzw.x, xyzw.y, xyzw.z));
    transform.scale = read_vector(node.scale, glm::vec3(1.0f));
    return transform;
}

Camera read_camera(const tinygltf::Camera& source) {
    Camera camera;
    camera.orthographic = source.type == "orthographic";
    if (camera.orthographic) {
        camera.half_height = std::abs(finite(source.orthographic.ymag));
    } else {
        camera.vertical_fov = finite(source.perspective.yfov);
    }
    const bool sees = camera.half_height > 0.0f && camera.vertical_fov > 0.0f && camera.vertical_fov < glm::pi<float>();
    if (!sees) { fail("a camera has a field of view that is not 0 < yfov < pi, or a ymag of 0"); }
    return camera;
}

LightKind read_light_kind(const std::string& gltf_word, const std::string& name) {
    if (gltf_word == "directional") { return LightKind::directional; }
    if (gltf_word == "point") { return LightKind::point; }
    if (gltf_word != "spot") { fail(name + " is neither directional nor point nor spot"); }
    return LightKind::spot;
}

// The extension's units are photometric: candela and lux. Like most renderers, this one takes their numbers for W/sr and
// W/m2 as they are: divided by the 683 lm/W of the definition, no lamp would stand out against emissive materials, whose
// values are in no such unit.
PunctualLight read_light(const tinygltf::Model& model, int light_index) {
    const tinygltf::Light& source = at(model.lights, light_index, "light");
    const std::string name = label("light", size_t(light_index));
    PunctualLight light;
    light.kind = read_light_kind(source.type, name);
    light.intensity = read_vector(source.color, glm::vec3(1.0f)) * finite(source.intensity);
    light.range = finite(source.range);
    light.inner_cone = finite(source.spot.innerConeAngle);
    light.outer_cone = finite(source.spot.outerConeAngle);
    if (glm::any(glm::lessThan(light.intensity, glm::vec3(0.0f))) || light.range < 0.0f) {
        fail(name + " has a negative color, intensity or range");
    }
    const bool is_cone = light.inner_cone >= 0.0f && light.inner_cone <= light.outer_cone && light.outer_cone > 0.0f &&
                         light.outer_cone <= 0.5f * glm::pi<float>() + 1e-4f;
    if (!is_cone) { fail(name + " has cone angles that are not 0 <= inner <= outer <= pi / 2"); }
    return light;
}

// What a node refers to; none if it has no light.
std::optional<PunctualLight> read_light_of(const tinygltf::Model& model, const tinygltf::Node& node) {
    const auto extension = node.extensions.find("KHR_lights_punctual");
    if (extension == node.extensions.end()) { return std::nullopt; }
    const tinygltf::Value& index = extension->second.Get("light");
    if (!index.IsInt()) { fail("a node has a light without a number"); }
    return read_light(model, index.GetNumberAsInt());
}

using NodeIndices = std::vector<int>; // for each node of the file its place in the scene, -1 if it is not there

// Appends the nodes of a glTF scene depth first, so that parents stand before their children.
class NodeReader {
public:
    NodeReader(const tinygltf::Model& model, const std::vector<MeshIndices>& mesh_indices, Scene* scene)
        : model_(model), mesh_indices_(mesh_indices), scene_(scene), indices_(model.nodes.size(), -1) {}

    void add(int gltf_index, int parent, int depth) {
        const tinygltf::Node& source = at(model_.nodes, gltf_index, "node");
        const std::string name = label("node", size_t(gltf_index));
        if (indices_[size_t(gltf_index)] >= 0) { fail(name + " has two parents or is its own ancestor"); }
        if (depth > kMaxNodeDepth) {
            fail("its nodes are nested more than " + std::to_string(kMaxNodeDepth) + " levels deep");
        }
        const int index = int(scene_->nodes.size());
        indices_[size_t(gltf_index)] = index;

        Node& node = scene_->nodes.emplace_back();
        node.parent = parent;
        if (source.matrix.empty()) { node.rest = read_transform(source); }
        node.local = node.rest ? to_matrix(*node.rest) : read_matrix(source);
        if (is_given(source.mesh, "mesh")) { node.meshes = at(mesh_indices_, source.mesh, "mesh"); }
        if (is_given(source.skin, "skin") && source.mesh >= 0) { node.skin = source.skin; }
        count_vertices(node);
        if (is_given(source.camera, "camera")) {
            scene_->cameras.push_back(read_camera(at(model_.cameras, source.camera, "camera")));
            camera_nodes_.push_back(index);
        }
        if (const std::optional<PunctualLight> light = read_light_of(model_, source)) {
            scene_->lights.push_back(*light);
            scene_->lights.back().node = index;
        }
        for (int child : source.children) { add(child, index, depth + 1); }
    }

    void count_vertices(const Node& node) {
        for (int mesh : node.meshes) { drawn_ += scene_->meshes[size_t(mesh)].vertices.size(); }
        if (drawn_ > kMaxDrawn) { fail("its nodes draw more than " + std::to_string(kMaxDrawn) + " vertices"); }
    }

    void place_cameras() {
        for (size_t i = 0; i < camera_nodes_.size(); ++i) {
            scene_->cameras[i].world = scene_->nodes[size_t(camera_nodes_[i])].world;
        }
    }

    const NodeIndices& indices() const { return indices_; }

private:
    const tinygltf::Model& model_;
    const std::vector<MeshIndices>& mesh_indices_;
    Scene* scene_;
    NodeIndices indices_;
    std::vector<int> camera_nodes_; // for each camera of the scene
    size_t drawn_ = 0;              // vertices
};

NodeIndices read_nodes(const tinygltf::Model& model, const std::vector<MeshIndices>& mesh_indices, Scene* scene) {
    NodeReader reader(model, mesh_indices, scene);
    for (int root : at(model.scenes, std::max(model.defaultScene, 0), "scene").nodes) { reader.add(root, -1, 1); }
    update_world_matrices(scene);
    for (const Node& node : scene->nodes) {
        if (!all_finite(node.world)) { fail("its node transforms multiply to a matrix that is not finite"); }
    }
    reader.place_cameras();
    return reader.indices();
}

// ---- Skins and animations -----------------------------------------------------------------------------

Skin read_skin(const tinygltf::Model& model, int skin_index, const NodeIndices& node_indices) {
    const tinygltf::Skin& source = at(model.skins, skin_index, "skin");
    const std::string name = label("skin", size_t(skin_index));
    Skin skin;
    for (int joint : source.joints) {
        skin.nodes.push_back(at(node_indices, joint, "node"));
        if (skin.nodes.back() < 0) { fail("a joint of " + name + " is not in the scene"); }
    }
    if (skin.nodes.empty()) { fail(name + " has no joints"); }
    skin.inverse_bind.assign(skin.nodes.size(), glm::mat4(1.0f));
    if (is_given(source.inverseBindMatrices, "accessor")) {
        skin.inverse_bind = read_matrices(model, source.inverseBindMatrices);
    }
    if (skin.inverse_bind.size() < skin.nodes.size()) { fail(name + " has fewer inverse bind matrices than joints"); }
    skin.inverse_bind.resize(skin.nodes.size());
    return skin;
}

void check_joints(const Mesh& mesh, const std::string& skin_name, size_t joint_count) {
    for (const Vertex& vertex : mesh.vertices) {
        if (vertex.weights == glm::vec4(0.0f)) {
            fail("a mesh drawn with " + skin_name + " has no joints and weights");
        }
        for (int i = 0; i < 4; ++i) {
            if (vertex.joints[i] >= joint_count) {
                fail("a vertex uses joint " + std::to_string(vertex.joints[i]) + ", but " + skin_name + " only has " +
                     std::to_string(joint_count) + " joints");
            }
        }
    }
}

// Only the skins that are drawn: others may belong to another scene of the file.
void read_skins(const tinygltf::Model& model, const NodeIndices& node_indices, Scene* scene) {
    size_t joints = 0;
    scene->skins.resize(model.skins.size());
    for (const Node& node : scene->nodes) {
        if (node.skin < 0) { continue; }
        at(scene->skins, node.skin, "skin");
        Skin& skin = scene->skins[size_t(node.skin)];
        if (skin.nodes.empty()) {
            skin = read_skin(model, node.skin, node_indices);
            joints += skin.nodes.size();
            if (joints > kMaxJoints) { fail("its skins have more than " + std::to_string(kMaxJoints) + " joints"); }
        }
        for (int mesh : node.meshes) {
            check_joints(scene->meshes[size_t(mesh)], label("skin", size_t(node.skin)), skin.nodes.size());
        }
    }
}

std::vector<float> read_times(const tinygltf::Model& model, int accessor_index) {
    const std::string name = label("accessor", size_t(std::max(accessor_index, 0)));
    std::vector<float> times;
    for (const glm::vec4& value : read_vectors(model, accessor_index, 1, 1, glm::vec4(0.0f))) {
        if (value.x < 0.0f || (!times.empty() && value.x <= times.back())) {
            fail(name + " holds the times of an animation, which are negative or do not increase");
        }
        times.push_back(value.x);
    }
    if (times.empty()) { fail(name + " holds the times of an animation but is empty"); }
    return times;
}

Interpolation read_interpolation(const std::string& gltf_word) {
    if (gltf_word == "STEP") { return Interpolation::step; }
    if (gltf_word == "CUBICSPLINE") { return Interpolation::cubic; }
    if (gltf_word != "LINEAR" && !gltf_word.empty()) { fail("an animation has an unknown interpolation"); }
    return Interpolation::linear;
}

Sampler read_sampler(const tinygltf::Model& model, const tinygltf::AnimationSampler& source) {
    Sampler sampler;
    sampler.interpolation = read_interpolation(source.interpolation);
    sampler.times = read_times(model, source.input);
    sampler.values = read_vectors(model, source.output, 1, 4, glm::vec4(0.0f));
    const size_t values_per_key = sampler.interpolation == Interpolation::cubic ? 3 : 1;
    if (sampler.values.size() % (values_per_key * sampler.times.size()) != 0 || sampler.values.empty()) {
        fail("an animation has the wrong number of values for its " + std::to_string(sampler.times.size()) + " times");
    }
    return sampler;
}

// None for what this loader does not move: morph targets, and what extensions animate.
std::optional<AnimatedPart> read_part(const std::string& gltf_path) {
    if (gltf_path == "translation") { return AnimatedPart::translation; }
    if (gltf_path == "rotation") { return AnimatedPart::rotation; }
    if (gltf_path == "scale") { return AnimatedPart::scale; }
    return std::nullopt;
}

// One value of three or four numbers for each key, as the moved part needs.
void check_values(const tinygltf::Model& model, const tinygltf::AnimationSampler& source, const Sampler& sampler,
                  AnimatedPart part) {
    const int type = part == AnimatedPart::rotation ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3;
    const size_t values_per_key = sampler.interpolation == Interpolation::cubic ? 3 : 1;
    if (model.accessors[size_t(source.output)].type != type) {
        fail("an animation moves a rotation by other than VEC4, or a translation or scale by other than VEC3");
    }
    if (sampler.values.size() != values_per_key * sampler.times.size()) {
        fail("an animation has more values than its times ask for");
    }
}

void read_channel(const tinygltf::Model& model, const tinygltf::Animation& source,
                  const tinygltf::AnimationChannel& channel, const NodeIndices& node_indices, const Scene& scene,
                  Animation* animation) {
    const std::optional<AnimatedPart> part = read_part(channel.target_path);
    const Sampler& sampler = at(animation->samplers, channel.sampler, "sampler");
    const int node = at(node_indices, channel.target_node, "node");
    if (!part || node < 0) { return; } // nothing to see
    check_values(model, source.samplers[size_t(channel.sampler)], sampler, *part);
    if (!scene.nodes[size_t(node)].rest) {
        fail("an animation moves " + label("node", size_t(channel.target_node)) + ", which has a matrix");
    }
    animation->channels.push_back({node, *part, channel.sampler});
    animation->duration = std::max(animation->duration, sampler.times.back());
}

void read_animations(const tinygltf::Model& model, const NodeIndices& node_indices, Scene* scene) {
    size_t values = 0;
    for (const tinygltf::Animation& source : model.animations) {
        Animation& animation = scene->animations.emplace_back();
        animation.name = source.name;
        for (const tinygltf::AnimationSampler& sampler : source.samplers) {
            animation.samplers.push_back(read_sampler(model, sampler));
            values += animation.samplers.back().values.size();
            if (values > kMaxElements) {
                fail("its animations have more than " + std::to_string(kMaxElements) + " values");
            }
        }
        for (const tinygltf::AnimationChannel& channel : source.channels) {
            read_channel(model, source, channel, node_indices, *scene, &animation);
        }
    }
}

// ---- All of it ----------------------------------------------------------------------------------------

bool draws_something(const Scene& scene) {
    return std::any_of(scene.nodes.begin(), scene.nodes.end(), [&](const Node& node) {
        return std::any_of(node.meshes.begin(), node.meshes.end(),
                           [&](int mesh) { return !scene.meshes[size_t(mesh)].indices.empty(); });
    });
}

Scene read_scene(const fs::path& path) {
    const tinygltf::Model model = parse_file(path);
    check_version(model);
    check_required_extensions(model);
    Scene scene;
    scene.name = path.stem().string();
    read_images(model, &scene);
    read_textures(model, &scene);
    read_materials(model, &scene);
    const std::vector<MeshIndices> mesh_indices = read_meshes(model, &scene);
    const NodeIndices node_indices = read_nodes(model, mesh_indices, &scene);
    read_skins(model, node_indices, &scene);
    read_animations(model, node_indices, &scene);
    if (!draws_something(scene)) { fail("it has no triangles to draw"); }
    update_bounds(&scene);
    // A picture of it needs distances across it.
    const glm::vec3 size = scene.bounds_max - scene.bounds_min;
    if (!std::isfinite(glm::dot(size, size))) { fail("its node transforms move vertices to infinity, or nearly"); }
    return scene;
}

} // namespace

bool load_gltf(const std::string& path, Scene* scene, std::string* error) {
    try {
        *scene = read_scene(path);
        return true;
    } catch (const std::exception& exception) {
        *error = "cannot load \"" + path + "\": " + one_line(exception.what());
        return false;
    }
}
