// Pictures on disk: PNG and PFM files, labels, comparisons, histograms, checksums.
// RGB pictures are 3 bytes per pixel, top row first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// All writers return false when any byte could not be written, and then leave no half file behind. The path
// must name a regular file or nothing yet.
bool write_png(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb);

// Little-endian floats with 1 or 3 channels, bottom row first as PFM and OpenGL have it.
bool write_pfm(const std::string& path, int width, int height, int channels, const float* pixels);

// Any text, by the same rules.
bool write_text(const std::string& path, const std::string& text);

// White ASCII text on a darkened box whose top left corner is at (x, y). One font pixel covers
// scale x scale pixels. What lies outside of the picture is cut off.
void draw_label(std::vector<uint8_t>* rgb, int width, int height, int x, int y, int scale, const std::string& text);

// Of labels, where they shall be read in a picture of this height.
int label_scale(int height);

struct LabelledPicture {
    std::vector<uint8_t> rgb;
    std::string label;
};

// Pictures of equal size in full rows of so many columns, a label in the corner of each.
std::vector<uint8_t> picture_grid(const std::vector<LabelledPicture>& pictures, int columns, int width, int height);

// White bars on a darkened box in the lower right corner, the highest for the greatest count. The labels name the ends of
// the axis.
void draw_histogram(std::vector<uint8_t>* rgb, int width, int height, const std::vector<size_t>& counts,
                    const std::string& low, const std::string& high);

// The 64 bit FNV-1a hash.
uint64_t fnv1a64(const void* data, size_t size);
