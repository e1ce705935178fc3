// SPDX-License-Identifier: Apache-2.0
// jpeglib.h needs size_t and FILE, and jerror.h needs jpeglib.h.
// clang-format off
#include <csetjmp>
#include <cstdio>
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

#include <cstdlib>
#include <utility>

#include "losses/image/exif.h"
#include "losses/image/image_codec.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

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

  // `gray` has room for width() bytes, `coverage` for width()·height() numbers.
  bool ReadPixels(uint8_t* gray, float* coverage) {
    if (setjmp(escape_)) return false;
    info_.out_color_space = JCS_GRAYSCALE;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      float* row = coverage + size_t(info_.output_scanline) * info_.output_width;
      jpeg_read_scanlines(&info_, &gray, 1);
      for (JDIMENSION col = 0; col < info_.output_width; ++col)
        row[col] = CoverageFromGray(gray[col]);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }

  // `rgb` has room for 3·width()·height() bytes.
  bool ReadColors(uint8_t* rgb) {
    if (setjmp(escape_)) return false;
    info_.out_color_space = JCS_RGB;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      uint8_t* row = rgb + size_t(3) * info_.output_scanline * info_.output_width;
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

InputError Broken(const std::string& where, const JpegReader& reader) {
  return InputError(where, std::string("truncated or damaged JPEG: ") + reader.message());
}

void ReadCheckedHeader(const std::string& where, JpegReader& reader) {
  if (!reader.ReadHeader()) throw Broken(where, reader);
  if (reader.channels() != 1 && reader.channels() != 3) {
    throw InputError(where, "JPEG has " + std::to_string(reader.channels()) +
                                " channels, expected 1 (grey) or 3 (colour)");
  }
  CheckPixelCount(reader.width(), reader.height(), where);
}

}  // namespace

bool LooksLikeJpeg(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

GrayImage DecodeJpeg(const std::vector<uint8_t>& bytes, const std::string& where) {
  JpegReader reader(bytes);
  ReadCheckedHeader(where, reader);
  GrayImage image(reader.width(), reader.height());
  std::vector<uint8_t> gray(image.width);
  const int orientation = reader.exif().orientation;  // the end of the decompression forgets it
  if (!reader.ReadPixels(gray.data(), image.coverage.data())) throw Broken(where, reader);
  return Upright(std::move(image), orientation);
}

Photograph DecodeJpegColors(const std::vector<uint8_t>& bytes, const std::string& where) {
  JpegReader reader(bytes);
  ReadCheckedHeader(where, reader);
  RgbImage image{reader.width(), reader.height(),
                 std::vector<uint8_t>(size_t(3) * reader.width() * reader.height())};
  const ExifData exif = reader.exif();
  if (!reader.ReadColors(image.rgb.data())) throw Broken(where, reader);
  return {Upright(std::move(image), exif.orientation), exif};
}

std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& pixels, int width, int height,
                                int channels, int quality, bool progressive) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = width;
  info.image_height = height;
  info.input_components = channels;
  info.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  if (progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = const_cast<uint8_t*>(&pixels[size_t(info.next_scanline) * width * channels]);
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  std::vector<uint8_t> bytes(buffer, buffer + size);
  jpeg_destroy_compress(&info);
  std::free(buffer);
  return bytes;
}

}  // namespace drape
