// Pictures on disk: PNG and PFM files, labels, comparisons, checksums.
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

// Two pictures of equal size next to one another, a label in the corner of each.
std::vector<uint8_t> side_by_side(const std::vector<uint8_t>& left, const std::string& left_label,
                                  const std::vector<uint8_t>& right, const std::string& right_label, int width,
                                  int height);

// The 64 bit FNV-1a hash.
uint64_t fnv1a64(const void* data, size_t size);
