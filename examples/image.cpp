#include "image.hpp"

#include <stb_easy_font.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace {

bool write_all(const std::string& path, const std::vector<uint8_t>& bytes) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) { return false; }
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    const bool closed = std::fclose(file) == 0; // a full disk may only show here
    return written && closed;
}

// Renaming onto a device or a pipe would replace it by a file.
bool is_replaceable(const std::string& path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    return !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
}

// A write that fails leaves the file that was there before, or none.
bool write_file(const std::string& path, const std::vector<uint8_t>& bytes) {
    if (!is_replaceable(path)) { return false; }
    const std::string temporary = path + ".tmp";
    if (write_all(temporary, bytes) && std::rename(temporary.c_str(), path.c_str()) == 0) { return true; }
    std::remove(temporary.c_str());
    return false;
}

void append_bytes(void* bytes, void* data, int size) {
    const auto* begin = static_cast<const uint8_t*>(data);
    auto* out = static_cast<std::vector<uint8_t>*>(bytes);
    out->insert(out->end(), begin, begin + size);
}

void append_little_endian(std::vector<uint8_t>* bytes, float value) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int shift = 0; shift < 32; shift += 8) { bytes->push_back(uint8_t(bits >> shift)); }
}

struct Rectangle {
    int left, top, right, bottom; // right and bottom are exclusive
};

// Moves the color of every pixel towards "tone": 0 keeps the picture, 1 replaces it.
void fill(std::vector<uint8_t>* rgb, int width, int height, Rectangle area, uint8_t tone, float opacity) {
    for (int y = std::max(area.top, 0); y < std::min(area.bottom, height); ++y) {
        for (int x = std::max(area.left, 0); x < std::min(area.right, width); ++x) {
            uint8_t* pixel = &(*rgb)[(size_t(y) * size_t(width) + size_t(x)) * 3];
            for (int c = 0; c < 3; ++c) {
                pixel[c] = uint8_t(float(pixel[c]) * (1.0f - opacity) + float(tone) * opacity);
            }
        }
    }
}

// stb_easy_font indexes its tables with the character, unchecked.
std::string printable(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return text;
}

struct FontVertex {
    float x, y, z;
    uint8_t color[4];
};

// In font pixels, each quad from its upper left (first) to its lower right (third) vertex.
std::vector<Rectangle> text_rectangles(std::string text) {
    std::vector<FontVertex> vertices(text.size() * 4 * 24); // no glyph has 24 quads
    const int quads = stb_easy_font_print(0.0f, 0.0f, text.data(), nullptr, vertices.data(),
                                          int(vertices.size() * sizeof(FontVertex)));
    std::vector<Rectangle> rectangles;
    for (size_t i = 0; i < size_t(quads) * 4; i += 4) {
        rectangles.push_back({int(vertices[i].x), int(vertices[i].y), int(vertices[i + 2].x), int(vertices[i + 2].y)});
    }
    return rectangles;
}

} // namespace

bool write_png(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb) {
    if (width <= 0 || height <= 0 || rgb.size() != size_t(width) * size_t(height) * 3) { return false; }
    std::vector<uint8_t> bytes;
    const int encoded = stbi_write_png_to_func(append_bytes, &bytes, width, height, 3, rgb.data(), width * 3);
    return encoded != 0 && write_file(path, bytes);
}

bool write_pfm(const std::string& path, int width, int height, int channels, const float* pixels) {
    if (width <= 0 || height <= 0 || (channels != 1 && channels != 3)) { return false; }
    const std::string header = std::string(channels == 3 ? "PF" : "Pf") + "\n" + std::to_string(width) + " " +
                               std::to_string(height) + "\n-1.0\n";
    std::vector<uint8_t> bytes(header.begin(), header.end());
    const size_t count = size_t(width) * size_t(height) * size_t(channels);
    bytes.reserve(bytes.size() + count * sizeof(float));
    for (size_t i = 0; i < count; ++i) { append_little_endian(&bytes, pixels[i]); }
    return write_file(path, bytes);
}

bool write_text(const std::string& path, const std::string& text) {
    return write_file(path, std::vector<uint8_t>(text.begin(), text.end()));
}

void draw_label(std::vector<uint8_t>* rgb, int width, int height, int x, int y, int scale, const std::string& text) {
    const int margin = 3, line_height = 9; // font pixels
    std::string line = printable(text);
    const int line_width = stb_easy_font_width(line.data());
    const Rectangle box = {x, y, x + (line_width + 2 * margin) * scale, y + (line_height + 2 * margin) * scale};
    fill(rgb, width, height, box, 0, 0.65f);
    for (const Rectangle& part : text_rectangles(line)) {
        const Rectangle area = {x + (part.left + margin) * scale, y + (part.top + margin) * scale,
                                x + (part.right + margin) * scale, y + (part.bottom + margin) * scale};
        fill(rgb, width, height, area, 255, 1.0f);
    }
}

std::vector<uint8_t> side_by_side(const std::vector<uint8_t>& left, const std::string& left_label,
                                  const std::vector<uint8_t>& right, const std::string& right_label, int width,
                                  int height) {
    const size_t row_size = size_t(width) * 3;
    std::vector<uint8_t> pair;
    pair.reserve(2 * row_size * size_t(height));
    for (int y = 0; y < height; ++y) {
        const auto offset = std::ptrdiff_t(size_t(y) * row_size);
        pair.insert(pair.end(), left.begin() + offset, left.begin() + offset + std::ptrdiff_t(row_size));
        pair.insert(pair.end(), right.begin() + offset, right.begin() + offset + std::ptrdiff_t(row_size));
    }
    const int scale = std::max(1, height / 360);
    const int margin = 8; // pixels
    draw_label(&pair, 2 * width, height, margin, margin, scale, left_label);
    draw_label(&pair, 2 * width, height, width + margin, margin, scale, right_label);
    return pair;
}

uint64_t fnv1a64(const void* data, size_t size) {
    const auto* bytes = static_cast<const uint8_t*>(data);
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; ++i) { hash = (hash ^ bytes[i]) * 0x100000001b3u; }
    return hash;
}
