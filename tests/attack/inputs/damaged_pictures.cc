// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "tests/attack/inputs/pictures.h"

namespace drape::attack {
namespace {

std::string AsText(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string MakeStarPng(const PngForm& form = {}) {
  return EncodePngAs(AsText(MakeStarPixels()), kStarSize, form);
}

void AddTruncated(const std::string& name, const std::string& file, const std::string& whole,
                  std::vector<BadPicture>* bad) {
  for (const double part : {0.001, 0.01, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
    const auto size = static_cast<std::size_t>(part * static_cast<double>(whole.size()));
    bad->push_back({name + " cut at " + std::to_string(size), file, whole.substr(0, size)});
  }
}

void AddHeaders(std::vector<BadPicture>* bad) {
  const std::array<uint32_t, 6> sizes = {0, 1, 20000, 65500, 2147483647u, 4294967295u};
  for (const uint32_t size : sizes) {
    const std::string name = "PNG header of " + std::to_string(size);
    bad->push_back({name, "a.png", MakeStarPng({.width = size, .height = size})});
    bad->push_back({name + " rows", "a.png", MakeStarPng({.height = size})});
  }
  for (const uint8_t depth : {uint8_t{0}, uint8_t{3}, uint8_t{32}, uint8_t{255}})
    bad->push_back(
        {"PNG of depth " + std::to_string(depth), "a.png", MakeStarPng({.depth = depth})});
  for (const uint8_t colour : {uint8_t{1}, uint8_t{5}, uint8_t{255}})
    bad->push_back(
        {"PNG of colour " + std::to_string(colour), "a.png", MakeStarPng({.colour = colour})});
  bad->push_back({"PNG palette without one", "a.png", MakeStarPng({.colour = 3})});
  bad->push_back({"PNG of rows too short", "a.png", MakeStarPng({.colour = 6})});
}

// What a reader that inflates everything would hold in memory.
void AddBombs(std::vector<BadPicture>* bad) {
  constexpr std::size_t kMuch = 64u << 20;
  const std::string zeros = Deflate(std::string(kMuch, '\0'));
  const std::string name = std::string("bomb\0\0", 6);
  bad->push_back(
      {"iCCP bomb", "a.png", MakeStarPng({.chunks = MakePngChunk("iCCP", name + zeros)}), false});
  bad->push_back(
      {"zTXt bomb", "a.png", MakeStarPng({.chunks = MakePngChunk("zTXt", name + zeros)}), false});
  constexpr uint32_t kSide = 16000;
  const std::string white = std::string(std::size_t{kSide} / 8, '\xff');
  std::string rows;
  for (uint32_t row = 0; row < kSide; ++row) rows += white;
  bad->push_back({"PNG of 16000 x 16000", "a.png",
                  EncodePngAs(rows, kSide / 8, {.width = kSide, .height = kSide, .depth = 1})});
  std::string texts;
  for (int i = 0; i < 100000; ++i) texts += MakePngChunk("tEXt", std::string("a\0b", 3));
  bad->push_back({"PNG of 100000 texts", "a.png", MakeStarPng({.chunks = texts}), false});
}

void AddJpegs(std::vector<BadPicture>* bad) {
  const std::vector<uint8_t> star = MakeStarPixels();
  for (int orientation = 1; orientation <= 9; ++orientation)
    bad->push_back({"EXIF orientation " + std::to_string(orientation), "a.jpg",
                    EncodeJpegAs(star, {.orientation = orientation}), false});
  std::string jpeg = EncodeJpegAs(star, {});
  const auto frame = jpeg.find("\xff\xc0");
  for (const char* size : {"\xff\xdc\xff\xdc", "\xff\xff\xff\xff", "\x80\x01\x80\x01"}) {
    std::string wrong = jpeg;
    wrong.replace(frame + 5, 4, std::string(size, 4));
    bad->push_back({"JPEG header of another size", "a.jpg", wrong});
  }
  std::string zero = jpeg;
  zero.replace(frame + 5, 4, std::string(4, '\0'));
  bad->push_back({"JPEG header of 0", "a.jpg", zero});
  const std::string progressive = EncodeJpegAs(star, {.progressive = true});
  const auto scan = progressive.find("\xff\xda");
  const std::string scans = progressive.substr(scan, progressive.size() - 2 - scan);
  std::string many = progressive.substr(0, progressive.size() - 2);
  for (int i = 0; i < 300; ++i) many += scans;
  bad->push_back({"JPEG of thousands of scans", "a.jpg", many + "\xff\xd9", false});
  bad->push_back({"JPEG of quality 1", "a.jpg", EncodeJpegAs(star, {.quality = 1}), false});
  AddTruncated("JPEG", "a.jpg", jpeg, bad);
  AddTruncated("progressive JPEG", "a.jpg", progressive, bad);
  bad->push_back({"JPEG with text after it", "a.jpg", jpeg + "more", false});
  bad->push_back({"two JPEGs", "a.jpg", jpeg + jpeg, false});
}

}  // namespace

std::vector<BadPicture> MakeDamagedPictures() {
  const std::string png = MakeStarPng();
  std::string damaged = png, header = png;
  damaged[png.size() / 2] ^= 0x55;
  header[20] ^= 0x55;
  std::vector<BadPicture> bad = {
      {"empty", "a.png", ""},
      {"one byte", "a.png", "x"},
      {"text", "a.png", "hello"},
      {"GIF", "a.gif", std::string("GIF89a\1\0\1\0\0\0\0;", 14)},
      {"BMP", "a.bmp", std::string("BM\x46\0\0\0\0\0\0\0\x36\0\0\0", 14)},
      {"WebP", "a.webp", std::string("RIFF\x1a\0\0\0WEBPVP8L", 16)},
      {"TIFF", "a.tif", std::string("II*\0\x08\0\0\0", 8)},
      {"SVG", "a.png", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>"},
      {"PNG signature", "a.png", png.substr(0, 8)},
      {"JPEG start", "a.jpg", "\xff\xd8\xff"},
      {"a damaged byte", "a.png", damaged},
      {"a damaged header", "a.png", header},
      {"PNG with text after it", "a.png", png + "more", false},
      {"two PNGs", "a.png", png + png, false},
      {"PNG named JPEG", "a.jpg", png, false},
      {"PNG without a name", "a", png, false},
      {"PNG without an end", "a.png", png.substr(0, png.size() - 12), false}};
  AddTruncated("PNG", "a.png", png, &bad);
  AddHeaders(&bad);
  AddBombs(&bad);
  AddJpegs(&bad);
  return bad;
}

}  // namespace drape::attack
