// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/observation_files.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "physics/mesh/scan_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr std::size_t kMost = std::size_t{1} << 24;  // rows, points, pixels
constexpr std::size_t kMostFields = 100;             // of a line that are looked at

// The fields of a line, without blanks and quotes around them.
std::vector<std::string> SplitFields(std::string_view line, char separator) {
  constexpr std::string_view kAround = " \t\r\"";
  std::vector<std::string> fields;
  for (std::size_t begin = 0; begin <= line.size() && fields.size() < kMostFields;) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    std::string_view field = line.substr(begin, end - begin);
    field.remove_prefix(std::min(field.find_first_not_of(kAround), field.size()));
    field = field.substr(0, field.find_last_not_of(kAround) + 1);
    fields.emplace_back(field);
    begin = end + 1;
  }
  return fields;
}

struct Table {
  std::string header;  // one of the expected ones
  std::vector<std::vector<double>> rows;
};

class TableReader {
 public:
  explicit TableReader(const std::string& path) : path_(path), text_(ReadWholeFile(path)) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    rest_ = text_;
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  }

  // headers: two that are allowed.
  Table Read(const std::array<std::string, 2>& headers) {
    Table table;
    std::string_view line;
    if (!NextLine(&line)) throw InputError(path_, "the file is empty, expected " + Either(headers));
    separator_ = line.find(';') != std::string_view::npos ? ';' : ',';
    const std::vector<std::string> names = SplitFields(line, separator_);
    const auto found = std::ranges::find_if(
        headers, [&](const std::string& each) { return SplitFields(each, ',') == names; });
    if (found == headers.end())
      Fail("found '" + MakePrintableLine(line) + "', expected " + Either(headers));
    table.header = *found;
    while (NextLine(&line)) {
      if (table.rows.size() == kMost) Fail("found a row more, expected at most 2^24");
      table.rows.push_back(Numbers(line, names));
    }
    if (table.rows.empty()) throw InputError(path_, "found a header alone, expected rows below it");
    return table;
  }

  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(path_ + ":" + std::to_string(line_), problem);
  }

 private:
  static std::string Either(const std::array<std::string, 2>& headers) {
    return "the header '" + headers[0] + "' or '" + headers[1] + "'";
  }

  // The next line that is not blank.
  bool NextLine(std::string_view* line) {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      *line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
      if (line->find_first_not_of(" \t\r") != std::string_view::npos) {
        if (line->ends_with('\r')) line->remove_suffix(1);
        return true;
      }
    }
    return false;
  }

  std::vector<double> Numbers(std::string_view line, const std::vector<std::string>& names) const {
    std::vector<std::string> fields = SplitFields(line, separator_);
    if (fields.size() != names.size())
      Fail(Format("found %zu fields, expected the %zu of the header", fields.size(), names.size()));
    std::vector<double> numbers(fields.size());
    for (std::size_t k = 0; k < fields.size(); ++k) {
      std::string number = fields[k];
      if (separator_ == ';') std::replace(number.begin(), number.end(), ',', '.');
      const char* end = number.data() + number.size();
      const auto [last, error] = std::from_chars(number.data(), end, numbers[k]);
      if (error != std::errc() || last != end || !std::isfinite(numbers[k]))
        Fail(names[k] + ": found '" + MakePrintableLine(fields[k]) + "', expected a number");
    }
    return numbers;
  }

  const std::string path_, text_;
  std::string_view rest_;
  char separator_ = ',';
  int line_ = 0;
};

// The last three columns of a table, shape [3N].
Eigen::VectorXd LastColumns(const Table& table) {
  Eigen::VectorXd x(3 * table.rows.size());
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    std::copy(table.rows[i].end() - 3, table.rows[i].end(), &x[3 * Eigen::Index(i)]);
  return x;
}

// Along each axis without a tenth of the points at either end, which may be outliers.
void CheckExtent(const Eigen::VectorXd& x, const std::string& path) {
  const Eigen::Index count = x.size() / 3;
  double extent = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd along = x.reshaped(3, count).row(axis);
    std::sort(along.begin(), along.end());
    extent = std::max(extent, along[count - 1 - count / 10] - along[count / 10]);
  }
  if (extent > 0.0) CheckUsual(path + ": extent", extent, "m", 0.01, 5);
}

constexpr std::size_t kSignature = 8, kFrame = 12;  // of a file; of a chunk beside its content

// The chunks of a PNG without which it has no picture. Others, such as those on gamma, would change
// the samples.
std::string CriticalChunks(const std::string& png) {
  std::string critical = png.substr(0, kSignature);
  for (std::size_t at = kSignature; at + kFrame <= png.size();) {
    const std::size_t size = png_get_uint_32(reinterpret_cast<png_const_bytep>(&png[at]));
    if (std::isupper(static_cast<unsigned char>(png[at + 4])))
      critical += png.substr(at, size + kFrame);
    at += size + kFrame;
  }
  return critical;
}

// Throws InputError unless the header is that of a picture of 16-bit grey of a size that can be
// held.
void CheckIsGrey16(const std::string& bytes, const std::string& path) {
  constexpr std::size_t kWidth = 16, kHeight = 20, kDepth = 24, kColour = 25, kHeader = 33;
  const auto* png = reinterpret_cast<png_const_bytep>(bytes.data());
  if (bytes.size() < kHeader || png_sig_cmp(png, 0, kSignature) != 0)
    throw InputError(path, "is no PNG (by its first bytes), expected a grey PNG of 16 bits");
  if (png[kDepth] != 16 || png[kColour] != PNG_COLOR_TYPE_GRAY)
    throw InputError(path, Format("has %d bits a sample, colour type %d, expected a grey PNG of 16 "
                                  "bits (colour type 0)",
                                  png[kDepth], png[kColour]));
  const std::size_t width = png_get_uint_32(png + kWidth), height = png_get_uint_32(png + kHeight);
  if (width > kMost || height > kMost || width * height > kMost)
    throw InputError(path, Format("image is %zux%zu, expected at most 2^24 pixels", width, height));
}

}  // namespace

MeasuredMarkers ReadMarkers(const std::string& path) {
  const std::array<std::string, 2> headers = {"weft_m,warp_m,x_m,y_m,z_m", "vertex,x_m,y_m,z_m"};
  TableReader reader(path);
  const Table table = reader.Read(headers);
  MeasuredMarkers markers;
  markers.x = LastColumns(table);
  CheckExtent(markers.x, path);
  if (table.header == headers[0]) {
    markers.material.resize(2, static_cast<Eigen::Index>(table.rows.size()));
    for (std::size_t i = 0; i < table.rows.size(); ++i)
      markers.material.col(Eigen::Index(i)) << table.rows[i][0], table.rows[i][1];
    return markers;
  }
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double vertex = table.rows[i][0];
    if (!(vertex >= 0 && vertex <= 1e9 && vertex == std::floor(vertex)))
      throw InputError(
          path, Format("row %zu: vertex: found %g, expected a whole number from 0", i + 1, vertex));
    markers.vertices.push_back(static_cast<int>(vertex));
  }
  return markers;
}

PlaceWeights WeightsOfMarkers(const Mesh& mesh, const MeasuredMarkers& markers,
                              const std::string& where) {
  return markers.vertices.empty() ? WeightsOfPlaces(mesh, markers.material, where)
                                  : WeightsOfVertices(mesh, markers.vertices, where);
}

Eigen::VectorXd ReadPointCloud(const std::string& path) {
  Eigen::VectorXd x = IsSurfaceFile(path)
                          ? ReadVertices(path)
                          : LastColumns(TableReader(path).Read({"x,y,z", "x_m,y_m,z_m"}));
  if (x.size() > 3 * static_cast<Eigen::Index>(kMost))
    throw InputError(path, Format("found %td points, expected at most 2^24", x.size() / 3));
  CheckExtent(x, path);
  return x;
}

DepthMap ReadDepthMap(const std::string& path, double metres_per_count) {
  if (!(metres_per_count > 0.0 && std::isfinite(metres_per_count)))
    throw InputError("metres_per_count",
                     Format("found %g, expected metres, more than 0", metres_per_count));
  const std::string bytes = ReadWholeFile(path);
  CheckIsGrey16(bytes, path);
  const std::string picture = CriticalChunks(bytes);
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  std::vector<uint16_t> counts;
  bool is_read = png_image_begin_read_from_memory(&png, picture.data(), picture.size()) != 0;
  if (is_read) {
    png.format = PNG_FORMAT_LINEAR_Y;
    counts.resize(size_t(png.width) * png.height);
    is_read = png_image_finish_read(&png, nullptr, counts.data(), 0, nullptr) != 0;
  }
  png_image_free(&png);
  if (!is_read) throw InputError(path, std::string("truncated or damaged PNG: ") + png.message);
  DepthMap map{int(png.width), int(png.height), {}, {}};
  for (const uint16_t count : counts) {
    if (count != 0) map.pixels.push_back(static_cast<int>(map.depth.size()));
    map.depth.push_back(metres_per_count * count);
  }
  if (map.pixels.empty()) throw InputError(path, "all counts are 0 (no data), expected depths");
  return map;
}

}  // namespace drape
