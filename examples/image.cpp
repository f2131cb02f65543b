#include "image.hpp"

#include <stb_easy_font.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cmath>
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

constexpr int kTextMargin = 3, kLineHeight = 9; // font pixels

// Pixels of a printable line, with its margin.
int label_width(std::string line, int scale) { return (stb_easy_font_width(line.data()) + 2 * kTextMargin) * scale; }
int label_height(int scale) { return (kLineHeight + 2 * kTextMargin) * scale; }

// White, the margin's corner at (x, y).
void draw_text(std::vector<uint8_t>* rgb, int width, int height, int x, int y, int scale, const std::string& line) {
    for (const Rectangle& part : text_rectangles(line)) {
        const Rectangle area = {x + (part.left + kTextMargin) * scale, y + (part.top + kTextMargin) * scale,
                                x + (part.right + kTextMargin) * scale, y + (part.bottom + kTextMargin) * scale};
        fill(rgb, width, height, area, 255, 1.0f);
    }
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
    const std::string line = printable(text);
    const Rectangle box = {x, y, x + label_width(line, scale), y + label_height(scale)};
    fill(rgb, width, height, box, 0, 0.65f);
    draw_text(rgb, width, height, x, y, scale, line);
}

int label_scale(int height) { return std::max(1, height / 360); }

std::vector<uint8_t> picture_grid(const std::vector<LabelledPicture>& pictures, int columns, int width, int height) {
    const size_t row_size = size_t(width) * 3, rows = pictures.size() / size_t(columns);
    std::vector<uint8_t> grid;
    grid.reserve(pictures.size() * row_size * size_t(height));
    for (size_t line = 0; line < rows * size_t(height); ++line) {
        for (size_t column = 0; column < size_t(columns); ++column) {
            const std::vector<uint8_t>& rgb = pictures[line / size_t(height) * size_t(columns) + column].rgb;
            const auto begin = rgb.begin() + std::ptrdiff_t(line % size_t(height) * row_size);
            grid.insert(grid.end(), begin, begin + std::ptrdiff_t(row_size));
        }
    }
    const int margin = 8; // pixels
    for (int i = 0; i < int(pictures.size()); ++i) {
        const int x = i % columns * width + margin, y = i / columns * height + margin;
        draw_label(&grid, columns * width, int(rows) * height, x, y, label_scale(height), pictures[size_t(i)].label);
    }
    return grid;
}

void draw_histogram(std::vector<uint8_t>* rgb, int width, int height, const std::vector<size_t>& counts,
                    const std::string& low, const std::string& high) {
    const int bins = int(counts.size()), scale = label_scale(height), margin = 8; // pixels
    const int bar = std::max(1, width / 3 / bins), tallest = height / 4;
    const int right = width - 2 * margin, left = right - bins * bar, bottom = height - 2 * margin - label_height(scale);
    const Rectangle box = {left - margin, bottom - tallest - margin, right + margin, height - margin};
    const size_t greatest = std::max(*std::max_element(counts.begin(), counts.end()), size_t{1});
    fill(rgb, width, height, box, 0, 0.65f);
    fill(rgb, width, height, {left, bottom, right, bottom + scale}, 160, 1.0f);
    for (int i = 0; i < bins; ++i) {
        const int top = bottom - int(std::lround(double(tallest) * double(counts[size_t(i)]) / double(greatest)));
        fill(rgb, width, height, {left + i * bar, top, left + (i + 1) * bar, bottom}, 255, 1.0f);
    }
    draw_text(rgb, width, height, left, bottom, scale, printable(low));
    draw_text(rgb, width, height, right - label_width(printable(high), scale), bottom, scale, printable(high));
}

uint64_t fnv1a64(const void* data, size_t size) {
    const auto* bytes = static_cast<const uint8_t*>(data);
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; ++i) { hash = (hash ^ bytes[i]) * 0x100000001b3u; }
    return hash;
}
