// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"

// jpeglib.h needs size_t and FILE, and jerror.h needs jpeglib.h.
// clang-format off
#include <csetjmp>
#include <cstdio>
#include <jpeglib.h>
#include <jerror.h>
// clang-format on
#include <glog/logging.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

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

// The TIFF structure of EXIF: unsigned numbers in the byte order that its header names.
class Tiff {
 public:
  explicit Tiff(std::span<const uint8_t> bytes)
      : bytes_(bytes), big_endian_(!bytes.empty() && bytes[0] == 'M') {}

  // The number of `size` bytes at `offset`; 0 where the data end before it.
  uint32_t At(size_t offset, size_t size) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i)
      value = value << 8 | bytes_[offset + (big_endian_ ? i : size - 1 - i)];
    return value;
  }

 private:
  std::span<const uint8_t> bytes_;
  bool big_endian_;
};

// The values of a directory's entries that are short or long numbers.
class Directory {
 public:
  Directory(const Tiff& tiff, size_t offset) : tiff_(tiff), offset_(offset) {}

  // 0 where there is no such tag.
  uint32_t Value(uint32_t tag) const {
    constexpr uint32_t kShort = 3;
    constexpr size_t kEntrySize = 12;
    const uint32_t entries = tiff_.At(offset_, 2);
    for (uint32_t i = 0; i < entries; ++i) {
      const size_t entry = offset_ + 2 + kEntrySize * i;
      if (tiff_.At(entry, 2) != tag) continue;
      return tiff_.At(entry + 8, tiff_.At(entry + 2, 2) == kShort ? 2 : 4);
    }
    return 0;
  }

 private:
  const Tiff& tiff_;
  size_t offset_;
};

// What the payload of a JPEG's APP1 segment ("Exif", then a TIFF header) says: the orientation
// 1 … 8, tag 0x0112 of its first directory, and of its EXIF directory the focal length in 35-mm
// film (0xA405) and the size of the picture as it was taken (0xA002, 0xA003). The defaults where
// the payload is not EXIF, is damaged or does not say.
ExifData ReadExif(std::span<const uint8_t> app1) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr uint32_t kTiffMark = 42;
  constexpr uint32_t kOrientation = 0x0112, kExifDirectory = 0x8769;
  constexpr uint32_t kFocalLengthIn35mm = 0xA405, kPixelWidth = 0xA002, kPixelHeight = 0xA003;
  constexpr uint32_t kMostPixels = 1 << 20;
  ExifData exif;
  if (app1.size() < kExif.size() || !std::equal(kExif.begin(), kExif.end(), app1.begin()))
    return exif;
  const Tiff tiff(app1.subspan(kExif.size()));
  if (tiff.At(2, 2) != kTiffMark) return exif;
  const Directory first(tiff, tiff.At(4, 4));
  const uint32_t orientation = first.Value(kOrientation);
  if (orientation >= 1 && orientation <= 8) exif.orientation = static_cast<int>(orientation);
  const uint32_t offset = first.Value(kExifDirectory);
  if (offset == 0) return exif;
  const Directory second(tiff, offset);
  exif.focal_35mm = second.Value(kFocalLengthIn35mm);
  exif.width = static_cast<int>(std::min(second.Value(kPixelWidth), kMostPixels));
  exif.height = static_cast<int>(std::min(second.Value(kPixelHeight), kMostPixels));
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

// libjpeg reports errors through longjmp. The objects are members of this class, outside the
// functions that call setjmp, so that no destructor is skipped.
class JpegReader {
 public:
  explicit JpegReader(const std::vector<uint8_t>& bytes) : bytes_(bytes) {
    info_.err = jpeg_std_error(&errors_);
    errors_.error_exit = [](j_common_ptr info) { Self(info)->Fail(info); };
    errors_.emit_message = [](j_common_ptr info, int level) { Self(info)->Warn(info, level); };
    info_.client_data = this;
  }
  ~JpegReader() { jpeg_destroy_decompress(&info_); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  bool ReadHeader() {
    if (setjmp(escape_)) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, bytes_.data(), bytes_.size());
    jpeg_save_markers(&info_, kApp1, kMaxSegment);
    jpeg_read_header(&info_, TRUE);
    return true;
  }

  // `samples` has room for all pixels in that colour space.
  bool ReadPixels(J_COLOR_SPACE space, uint8_t* samples) {
    if (setjmp(escape_)) return false;
    info_.out_color_space = space;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      uint8_t* row =
          samples + size_t(info_.output_components) * info_.output_scanline * info_.output_width;
      jpeg_read_scanlines(&info_, &row, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }

  int width() const { return static_cast<int>(info_.image_width); }
  int height() const { return static_cast<int>(info_.image_height); }
  int channels() const { return info_.num_components; }
  ExifData exif() const {
    for (const jpeg_marker_struct* marker = info_.marker_list; marker; marker = marker->next) {
      const ExifData exif = ReadExif({marker->data, marker->data_length});
      if (exif.orientation != 1 || exif.focal_35mm > 0 || exif.width > 0) return exif;
    }
    return {};
  }
  const char* message() const { return message_; }

 private:
  static constexpr int kApp1 = JPEG_APP0 + 1;
  static constexpr unsigned kMaxSegment = 0xFFFF;

  static JpegReader* Self(j_common_ptr info) { return static_cast<JpegReader*>(info->client_data); }

  [[noreturn]] void Fail(j_common_ptr info) {
    errors_.format_message(info, message_);
    longjmp(escape_, 1);
  }

  // Level −1 is a warning about corrupt data after which libjpeg continues: a truncated file would
  // become a grey one.
  void Warn(j_common_ptr info, int level) {
    if (level < 0 && errors_.msg_code != JWRN_EXTRANEOUS_DATA) Fail(info);
  }

  const std::vector<uint8_t>& bytes_;
  jpeg_decompress_struct info_ = {};
  jpeg_error_mgr errors_ = {};
  jmp_buf escape_;
  char message_[JMSG_LENGTH_MAX] = {};
};

bool LooksLikeJpeg(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

Picture DecodeJpeg(const std::vector<uint8_t>& bytes, int channels, const std::string& where) {
  JpegReader reader(bytes);
  const auto broken = [&] {
    return InputError(where, std::string("truncated or damaged JPEG: ") + reader.message());
  };
  if (!reader.ReadHeader()) throw broken();
  if (reader.channels() != 1 && reader.channels() != 3) {
    throw InputError(where, "JPEG has " + std::to_string(reader.channels()) +
                                " channels, expected 1 (grey) or 3 (colour)");
  }
  CheckPixelCount(reader.width(), reader.height(), where);
  Picture picture{reader.width(), reader.height(),
                  std::vector<uint8_t>(size_t(channels) * reader.width() * reader.height()),
                  reader.exif()};  // the end of the decompression forgets it
  if (!reader.ReadPixels(channels == 1 ? JCS_GRAYSCALE : JCS_RGB, picture.samples.data()))
    throw broken();
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

// Transparent pixels lie on white.
Picture DecodePng(const std::vector<uint8_t>& bytes, int channels, const std::string& where) {
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
  return {static_cast<int>(png.width), static_cast<int>(png.height), std::move(samples)};
}

Picture ReadPicture(const std::string& path, int channels) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(path, "is a folder, expected a JPEG or PNG file");
  }
  errno = 0;
  if (!std::ifstream(path, std::ios::binary))
    throw InputError(path, std::string("cannot be read: ") + std::strerror(errno));
  const std::string text = ReadWholeFile(path);
  std::vector<uint8_t> bytes(text.begin(), text.end());
  if (bytes.empty()) throw InputError(path, "is empty, expected a JPEG or PNG file");
  if (LooksLikeJpeg(bytes)) return DecodeJpeg(bytes, channels, path);
  if (LooksLikePng(bytes)) return DecodePng(bytes, channels, path);
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
  for (std::size_t at = kSignatureSize; at + kFrameSize <= bytes.size();) {
    const std::size_t size = png_get_uint_32(reinterpret_cast<png_const_bytep>(&bytes[at]));
    const std::string type = bytes.substr(at + 4, 4);
    if (type == "IDAT" || size > bytes.size() - at - kFrameSize) break;
    const std::string content = bytes.substr(at + 8, size);
    if (type == kTextChunk && content.starts_with(kKeyword)) {
      if (const auto discs = ParseDiscsLine(content.substr(kKeyword.size()))) return discs;
    }
    at += size + kFrameSize;
  }
  return std::nullopt;
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
