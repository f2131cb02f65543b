// Any bytes as a glTF file: refused with one sentence, or a scene that is whole. Beside the file lies one that it may name.
#include "scene.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <unistd.h>

extern "C" {
#include <cmocka.h>
}

namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, const uint8_t* bytes, size_t size) {
    std::ofstream stream(path, std::ios::binary);
    if (!stream.write(reinterpret_cast<const char*>(bytes), std::streamsize(size)).flush()) {
        fail_msg("cannot write %s", path.c_str());
    }
}

// Of this process; goes at its end.
struct Directory {
    fs::path path = fs::temp_directory_path() / ("fuzz_gltf." + std::to_string(getpid()));

    Directory() {
        const uint8_t zeros[256] = {};
        fs::create_directory(path);
        write_file(path / "zeros.bin", zeros, sizeof zeros);
    }
    ~Directory() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;
};

template <typename T>
void check_index(int index, const std::vector<T>& list, int least, const char* what) {
    if (index < least || index >= int(list.size())) { fail_msg("%s %d of %zu", what, index, list.size()); }
}

void check_mesh(const Scene& scene, const Mesh& mesh) {
    check_index(mesh.material, scene.materials, 0, "material");
    if (mesh.indices.size() % 3 != 0) { fail_msg("%zu indices", mesh.indices.size()); }
    for (const uint32_t index : mesh.indices) { check_index(int(index), mesh.vertices, 0, "vertex"); }
}

void check_node(const Scene& scene, size_t i) {
    const Node& node = scene.nodes[i];
    if (node.parent >= int(i)) { fail_msg("node %zu stands before its parent %d", i, node.parent); }
    for (const int mesh : node.meshes) { check_index(mesh, scene.meshes, 0, "mesh"); }
    if (node.skin >= 0) { check_index(node.skin, scene.skins, 0, "skin"); }
}

void check_material(const Scene& scene, const Material& material) {
    check_index(material.base_color_texture, scene.textures, -1, "texture");
    check_index(material.metallic_roughness_texture, scene.textures, -1, "texture");
    check_index(material.normal_texture, scene.textures, -1, "texture");
    check_index(material.emissive_texture, scene.textures, -1, "texture");
}

void check_scene(const Scene& scene) {
    for (const Texture& texture : scene.textures) { check_index(texture.image, scene.images, 0, "image"); }
    for (const Material& material : scene.materials) { check_material(scene, material); }
    for (const Mesh& mesh : scene.meshes) { check_mesh(scene, mesh); }
    for (size_t i = 0; i < scene.nodes.size(); ++i) { check_node(scene, i); }
    for (int i = 0; i < 3; ++i) {
        if (!(scene.bounds_max[i] >= scene.bounds_min[i]) ||
            !std::isfinite(scene.bounds_max[i] - scene.bounds_min[i])) {
            fail_msg("bounds %g to %g", double(scene.bounds_min[i]), double(scene.bounds_max[i]));
        }
    }
}

void check_sentence(const std::string& sentence, const std::string& path) {
    const bool is_line = sentence.find_first_of("\n\r\033") == std::string::npos && sentence.size() < path.size() + 400;
    if (!is_line || sentence.find(path) == std::string::npos) { fail_msg("no sentence: %s", sentence.c_str()); }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static const Directory directory;
    const std::string path = (directory.path / "scene.gltf").string();
    Scene scene;
    std::string error;
    write_file(path, bytes, size);
    if (!load_gltf(path, &scene, &error)) {
        check_sentence(error, path);
        return 0;
    }
    check_scene(scene);
    for (const double seconds : {-1.0, 0.3, 1e9}) { pose(&scene, seconds); }
    return 0;
}
