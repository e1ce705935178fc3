// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "losses/image/image.h"

// Internal to losses/: the decoders behind ReadImage, which throw InputError (prefix `where`) for a
// damaged or unsupported file, and the encoder of JPEG.
namespace drape {

// Telephones take up to 48 million.
inline constexpr int64_t kMaxPixels = int64_t{1} << 26;

// Throws InputError (prefix `where`) when the header announces an image that is too large to hold.
void CheckPixelCount(int64_t width, int64_t height, const std::string& where);

inline float CoverageFromGray(uint8_t gray) { return 1.0f - gray / 255.0f; }

bool LooksLikeJpeg(const std::vector<uint8_t>& bytes);
GrayImage DecodeJpeg(const std::vector<uint8_t>& bytes, const std::string& where);
Photograph DecodeJpegColors(const std::vector<uint8_t>& bytes, const std::string& where);

// pixels are row-major with interleaved channels: 1 grey, 3 RGB, 4 CMYK. quality is that of
// libjpeg, 1 … 100.
std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& pixels, int width, int height,
                                int channels, int quality = 95, bool progressive = false);

bool LooksLikePng(const std::vector<uint8_t>& bytes);
GrayImage DecodePng(const std::vector<uint8_t>& bytes, const std::string& where);
RgbImage DecodePngColors(const std::vector<uint8_t>& bytes, const std::string& where);

}  // namespace drape
