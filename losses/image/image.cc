// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"

#include <glog/logging.h>
#include <libexif/exif-data.h>
#include <png.h>
#include <turbojpeg.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// A decoded picture: rows of pixels, of one byte of grey or three bytes of colour each.
struct Picture {
  int width = 0, height = 0;
  std::vector<uint8_t> samples;
  ExifData exif = {};
};

// Throws InputError (prefix `where`) when the header announces an image that is too large to hold.
void CheckPixelCount(int64_t width, int64_t height, const std::string& where) {
  constexpr int64_t kMaxPixels = int64_t{1} << 26;  // telephones take up to 48 million
  if (width * height > kMaxPixels) {
    throw InputError(where, "image is " + std::to_string(width) + "x" + std::to_string(height) +
                                ", expected at most 2^26 pixels (67 million)");
  }
}

// The value of an entry that is a short or a long number; 0 where there is none.
uint32_t ReadExifEntry(::ExifData* data, ExifIfd directory, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(data->ifd[directory], tag);
  if (entry == nullptr || entry->components == 0) return 0;
  const ExifByteOrder order = exif_data_get_byte_order(data);
  if (entry->format == EXIF_FORMAT_SHORT) return exif_get_short(entry->data, order);
  return entry->format == EXIF_FORMAT_LONG ? exif_get_long(entry->data, order) : 0;
}

// Reads what a JPEG, or EXIF data after their own header, say of the camera: the defaults where
// there are no EXIF data, where they are damaged, or where they do not say.
ExifData ReadExif(const std::vector<uint8_t>& bytes) {
  constexpr uint32_t kMostPixels = 1 << 20;
  const std::unique_ptr<::ExifData, void (*)(::ExifData*)> data(
      exif_data_new_from_data(bytes.data(), static_cast<unsigned>(bytes.size())), exif_data_unref);
  ExifData exif;
  if (data == nullptr) return exif;
  const uint32_t orientation = ReadExifEntry(data.get(), EXIF_IFD_0, EXIF_TAG_ORIENTATION);
  if (orientation >= 1 && orientation <= 8) exif.orientation = static_cast<int>(orientation);
  const ExifEntry* dots = exif_content_get_entry(data->ifd[EXIF_IFD_0], EXIF_TAG_X_RESOLUTION);
  if (dots != nullptr && dots->format == EXIF_FORMAT_RATIONAL && dots->components == 1) {
    const ExifRational ratio = exif_get_rational(dots->data, exif_data_get_byte_order(data.get()));
    const bool by_centimetre = ReadExifEntry(data.get(), EXIF_IFD_0, EXIF_TAG_RESOLUTION_UNIT) == 3;
    if (ratio.denominator > 0)
      exif.density = ratio.numerator / (ratio.denominator * (by_centimetre ? 0.01 : 0.0254));
  }
  const auto number = [&](ExifTag tag) { return ReadExifEntry(data.get(), EXIF_IFD_EXIF, tag); };
  exif.focal_35mm = number(EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM);
  exif.width = static_cast<int>(std::min(number(EXIF_TAG_PIXEL_X_DIMENSION), kMostPixels));
  exif.height = static_cast<int>(std::min(number(EXIF_TAG_PIXEL_Y_DIMENSION), kMostPixels));
  return exif;
}

// Turns and reflects a picture as its EXIF orientation says: 1 … 4 keep width and height, 5 … 8
// exchange them.
Picture Upright(Picture picture) {
  const int orientation = picture.exif.orientation;
  if (orientation == 1) return picture;
  const bool exchanged = orientation >= 5;
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Picture shown{exchanged ? picture.height : picture.width,
                exchanged ? picture.width : picture.height,
                {},
                picture.exif};
  shown.samples.reserve(picture.samples.size());
  const std::size_t channels = picture.samples.size() / picture.width / picture.height;
  for (int row = 0; row < shown.height; ++row)
    for (int col = 0; col < shown.width; ++col) {
      // Where the pixel is stored.
      int column = exchanged ? row : col, line = exchanged ? col : row;
      if (from_right) column = picture.width - 1 - column;
      if (from_bottom) line = picture.height - 1 - line;
      const auto pixel =
          picture.samples.begin() + channels * (std::size_t(line) * picture.width + column);
      shown.samples.insert(shown.samples.end(), pixel, pixel + channels);
    }
  return shown;
}

bool LooksLikeJpeg(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

// After a warning about damaged data, TurboJPEG decodes the rest of the picture as grey. Only bytes
// between the last pixel and the end marker do no harm, and some telephones write them. TurboJPEG
// keeps the first warning, so that no other one can have come before.
bool IsHarmless(tjhandle decoder) {
  return tjGetErrorCode(decoder) == TJERR_WARNING &&
         std::string(tjGetErrorStr2(decoder)).ends_with("extraneous bytes before marker 0xd9");
}

Picture DecodeJpeg(const std::vector<uint8_t>& bytes, int channels, const std::string& where) {
  const std::unique_ptr<void, int (*)(tjhandle)> owner(tjInitDecompress(), tjDestroy);
  tjhandle const decoder = owner.get();
  CHECK(decoder) << tjGetErrorStr2(nullptr);
  int width = 0, height = 0, sampling = 0, space = 0;
  const auto broken = [&](const char* how) {
    return InputError(where, std::string("truncated or damaged JPEG: ") + how);
  };
  if (tjDecompressHeader3(decoder, bytes.data(), bytes.size(), &width, &height, &sampling,
                          &space) != 0)
    throw broken(tjGetErrorStr2(decoder));
  if (width < 1 || height < 1) throw broken("it has no picture");
  if (space == TJCS_CMYK || space == TJCS_YCCK)
    throw InputError(where, "JPEG has 4 channels, expected 1 (grey) or 3 (colour)");
  CheckPixelCount(width, height, where);
  Picture picture{width, height, std::vector<uint8_t>(size_t(channels) * width * height),
                  ReadExif(bytes)};
  if (tjDecompress2(decoder, bytes.data(), bytes.size(), picture.samples.data(), width, 0, height,
                    channels == 1 ? TJPF_GRAY : TJPF_RGB, 0) != 0 &&
      !IsHarmless(decoder))
    throw broken(tjGetErrorStr2(decoder));
  return Upright(std::move(picture));
}

struct PngHandle {
  PngHandle() { png.version = PNG_IMAGE_VERSION; }
  ~PngHandle() { png_image_free(&png); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;
  png_image png = {};
};

constexpr std::size_t kSignatureSize = 8, kHeaderSize = 25;  // of a file, of its first chunk
constexpr std::size_t kFrameSize = 12;                       // of a chunk beside its content
const std::string kTextChunk = "tEXt", kKeyword = std::string("Comment") + '\0';

std::string BigEndian(uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  return bytes;
}

// The contents of the chunks of a type, in a file that may be damaged.
std::vector<std::string> ReadChunks(const std::string& png, const std::string& type) {
  std::vector<std::string> contents;
  for (std::size_t at = kSignatureSize; at + kFrameSize <= png.size();) {
    const std::size_t size = png_get_uint_32(reinterpret_cast<png_const_bytep>(&png[at]));
    const std::string found = png.substr(at + 4, 4);
    if (size > png.size() - at - kFrameSize) break;
    if (found == type) contents.push_back(png.substr(at + 8, size));
    at += size + kFrameSize;
  }
  return contents;
}

constexpr double kInch = 0.0254;  // [m]

// Dots in a metre along x and y; zeros: not stated.
std::array<double, 2> ReadPngDensity(const std::string& png) {
  constexpr std::size_t kSize = 9;
  for (const std::string& chunk : ReadChunks(png, "pHYs")) {
    if (chunk.size() != kSize || chunk.back() != 1) continue;  // 1: by metre
    const auto* bytes = reinterpret_cast<png_const_bytep>(chunk.data());
    return {double(png_get_uint_32(bytes)), double(png_get_uint_32(bytes + 4))};
  }
  return {};
}

// The density of JFIF [JFIF 1.02], else of EXIF.
std::array<double, 2> ReadJpegDensity(const std::vector<uint8_t>& jpeg) {
  constexpr std::size_t kUnits = 13, kEnd = 18;
  if (jpeg.size() >= kEnd && std::memcmp(&jpeg[6], "JFIF", 5) == 0 && jpeg[kUnits] > 0) {
    const double unit = jpeg[kUnits] == 1 ? kInch : 0.01;
    return {(256 * jpeg[14] + jpeg[15]) / unit, (256 * jpeg[16] + jpeg[17]) / unit};
  }
  const double density = ReadExif(jpeg).density;
  return {density, density};
}

// The chunk of a comment [PNG, 11.3.4.3].
std::string TextChunk(const std::string& comment) {
  const std::string content = kKeyword + comment, typed = kTextChunk + content;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(typed.data()), uInt(typed.size()));
  return BigEndian(uint32_t(content.size())) + typed + BigEndian(uint32_t(sum));
}

// comment: empty: none.
void WriteBytes(const uint8_t* pixels, int width, int height, png_uint_32 format,
                const std::string& path, const std::string& comment) {
  PngHandle handle;
  handle.png.width = width;
  handle.png.height = height;
  handle.png.format = format;
  if (format == PNG_FORMAT_RGB) handle.png.flags = PNG_IMAGE_FLAG_FAST;  // noise hardly shrinks
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(handle.png);
  std::string bytes(size, '\0');
  const bool encoded =
      png_image_write_to_memory(&handle.png, bytes.data(), &size, 0, pixels, 0, nullptr);
  CHECK(encoded) << handle.png.message;
  bytes.resize(size);
  if (!comment.empty()) bytes.insert(kSignatureSize + kHeaderSize, TextChunk(comment));
  WriteFileAtomically(path, bytes);
}

bool LooksLikePng(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

// Reads what the eXIf chunk says of the camera: the defaults without one.
ExifData ReadPngExif(const std::string& png) {
  const std::vector<std::string> chunks = ReadChunks(png, "eXIf");
  if (chunks.empty()) return {};
  const std::string data = std::string("Exif\0\0", 6) + chunks[0];
  return ReadExif({data.begin(), data.end()});
}

// Transparent pixels lie on white.
Picture DecodePng(const std::string& bytes, int channels, const std::string& where) {
  PngHandle handle;
  png_image& png = handle.png;
  const auto broken = [&] {
    return InputError(where, std::string("truncated or damaged PNG: ") + png.message);
  };
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) throw broken();
  CheckPixelCount(png.width, png.height, where);
  png.format = channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // otherwise libpng reads 16-bit samples as linear light
  const png_color white = {255, 255, 255};
  std::vector<uint8_t> samples(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, &white, samples.data(), 0, nullptr)) throw broken();
  return Upright({static_cast<int>(png.width), static_cast<int>(png.height), std::move(samples),
                  ReadPngExif(bytes)});
}

Picture ReadPicture(const std::string& path, int channels) {
  const std::string text = ReadWholeFile(path);
  std::vector<uint8_t> bytes(text.begin(), text.end());
  if (bytes.empty()) throw InputError(path, "is empty, expected a JPEG or PNG file");
  if (LooksLikeJpeg(bytes)) return DecodeJpeg(bytes, channels, path);
  if (LooksLikePng(bytes)) return DecodePng(text, channels, path);
  throw InputError(path, "is neither JPEG nor PNG (by its first bytes)");
}

}  // namespace

GrayImage ReadImage(const std::string& path) {
  const Picture picture = ReadPicture(path, 1);
  GrayImage image(picture.width, picture.height);
  for (size_t i = 0; i < picture.samples.size(); ++i)
    image.coverage[i] = 1.0f - picture.samples[i] / 255.0f;
  return image;
}

Photograph ReadPhotograph(const std::string& path) {
  Picture picture = ReadPicture(path, 3);
  return {{picture.width, picture.height, std::move(picture.samples)}, picture.exif};
}

std::optional<DrapeDiscs> ReadPngDiscs(const std::string& path) {
  const std::string bytes = ReadWholeFile(path);
  if (!LooksLikePng({bytes.begin(), bytes.begin() + std::min(bytes.size(), kSignatureSize)}))
    return std::nullopt;
  for (const std::string& content : ReadChunks(bytes, kTextChunk)) {
    if (!content.starts_with(kKeyword)) continue;
    if (const auto discs = ParseDiscsLine(content.substr(kKeyword.size()))) return discs;
  }
  return std::nullopt;
}

double ReadPixelsPerMetre(const std::string& path) {
  constexpr double kAgree = 0.005, kFillers[] = {72, 96};
  const std::string text = ReadWholeFile(path);
  const std::vector<uint8_t> bytes(text.begin(), text.end());
  const auto [x, y] = LooksLikeJpeg(bytes)  ? ReadJpegDensity(bytes)
                      : LooksLikePng(bytes) ? ReadPngDensity(text)
                                            : std::array{0.0, 0.0};
  if (!(x > 0) || std::abs(x / y - 1) > kAgree)
    throw InputError(path, Format("states %g and %g dots an inch along x and y, expected one "
                                  "number for dpi; give ruler, camera_scale or image_width_mm",
                                  x * kInch, y * kInch));
  for (const double filler : kFillers)
    if (std::abs(x * kInch - filler) < 0.5)
      NoteInput(path, Format("states %g dots an inch, which many programs write without knowing "
                             "the scale",
                             filler));
  return x;
}

void WritePng(const GrayImage& image, const std::string& path,
              const std::optional<DrapeDiscs>& discs) {
  CHECK_EQ(image.coverage.size(), size_t(image.width) * image.height);
  std::vector<uint8_t> gray(image.coverage.size());
  for (size_t i = 0; i < gray.size(); ++i) {
    const float c = image.coverage[i];
    CHECK(c >= 0 && c <= 1) << "coverage " << c << " of pixel " << i;
    gray[i] = static_cast<uint8_t>(std::lround(255 * (1 - c)));
  }
  WriteBytes(gray.data(), image.width, image.height, PNG_FORMAT_GRAY, path,
             discs ? DiscsLine(*discs) : "");
}

void WritePng(const RgbImage& image, const std::string& path) {
  CHECK_EQ(image.rgb.size(), size_t(3) * image.width * image.height);
  WriteBytes(image.rgb.data(), image.width, image.height, PNG_FORMAT_RGB, path, "");
}

}  // namespace drape
