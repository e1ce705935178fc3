// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/scan_io.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

static_assert(std::endian::native == std::endian::little);

using Eigen::Vector3d;

// A file that is read from its beginning to its end, as words or as bytes.
class Source {
 public:
  Source(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  [[noreturn]] void Fail(const std::string& problem) const {
    const auto line = std::count(text_.begin(), text_.begin() + at_, '\n') + 1;
    throw InputError(path_ + ":" + std::to_string(line), problem);
  }
  // Empty at the end of the file.
  std::string_view Word() {
    constexpr std::string_view kBlanks = " \t\r\n";
    at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size());
    return Bytes(std::min(text_.find_first_of(kBlanks, at_), text_.size()) - at_);
  }
  void SkipLine() { at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1; }
  std::string_view Bytes(size_t count) {
    if (count > text_.size() - at_) Fail("the file ends early");
    return text_.substr(std::exchange(at_, at_ + count), count);
  }
  double Number() {
    const std::string_view word = Word();
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty()) Fail("the file ends early");
    if (error != std::errc() || end != word.data() + word.size())
      Fail("found '" + MakePrintableLine(word) + "', expected a number");
    return value;
  }

 private:
  std::string_view text_;
  const std::string& path_;
  size_t at_ = 0;
};

Eigen::VectorXd Stacked(const std::vector<Vector3d>& points) {
  Eigen::VectorXd x(3 * points.size());
  for (size_t i = 0; i < points.size(); ++i) x.segment<3>(3 * Eigen::Index(i)) = points[i];
  return x;
}

ObjSurface MakeSurface(const std::vector<Vector3d>& points,
                       std::vector<std::array<int, 3>> triangles, const std::string& path) {
  ObjSurface surface{Stacked(points), std::move(triangles)};
  if (!surface.x.allFinite()) throw InputError(path, "a coordinate is not finite");
  return surface;
}

// A triangle of a binary STL: a normal, three corners [float32], and two bytes that are not used.
constexpr size_t kStlHeader = 84, kStlTriangle = 50;

ObjSurface ReadStl(std::string_view text, const std::string& path) {
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
  std::map<std::array<double, 3>, int> places;
  std::vector<int> corners;
  const auto add = [&](double x, double y, double z) {
    const auto [place, is_new] = places.try_emplace({x, y, z}, static_cast<int>(points.size()));
    if (is_new) points.emplace_back(x, y, z);
    corners.push_back(place->second);
    if (corners.size() < 3) return;
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      triangles.push_back({corners[0], corners[1], corners[2]});
    corners.clear();
  };
  uint32_t count = 0;
  if (text.size() >= kStlHeader) std::memcpy(&count, &text[kStlHeader - 4], sizeof(count));
  Source source(text, path);
  if (count > 0 && text.size() == kStlHeader + kStlTriangle * count) {
    source.Bytes(kStlHeader);
    for (uint32_t i = 0; i < count; ++i) {
      float n[12];
      std::memcpy(n, source.Bytes(kStlTriangle).data(), sizeof(n));
      for (int k = 3; k < 12; k += 3) add(n[k], n[k + 1], n[k + 2]);
    }
  } else if (text.starts_with("solid")) {
    source.SkipLine();
    for (std::string_view word; !(word = source.Word()).empty();) {
      if (word != "vertex") continue;
      const double x = source.Number(), y = source.Number(), z = source.Number();
      add(x, y, z);
    }
    if (!corners.empty()) source.Fail("the file ends early");
  } else {
    throw InputError(path, Format("found %zu bytes, expected text that begins with 'solid', or %zu "
                                  "bytes of the %u triangles that it states",
                                  text.size(), kStlHeader + kStlTriangle * count, count));
  }
  return MakeSurface(points, std::move(triangles), path);
}

template <class T>
double As(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

// The formats of numbers in a PLY file.
struct PlyType {
  std::string_view name, other_name;
  size_t size;
  double (*read)(const char* bytes);
};
constexpr PlyType kPlyTypes[] = {
    {"char", "int8", 1, As<int8_t>},    {"uchar", "uint8", 1, As<uint8_t>},
    {"short", "int16", 2, As<int16_t>}, {"ushort", "uint16", 2, As<uint16_t>},
    {"int", "int32", 4, As<int32_t>},   {"uint", "uint32", 4, As<uint32_t>},
    {"float", "float32", 4, As<float>}, {"double", "float64", 8, As<double>}};

class PlyReader {
 public:
  PlyReader(std::string_view text, const std::string& path) : source_(text, path), path_(path) {}

  ObjSurface Read() {
    ReadHeader();
    RequirePlaces();
    std::vector<Vector3d> points;
    std::vector<std::vector<double>> faces;  // numbers of their corners
    for (const Element& element : elements_) {
      // Elements without content take no bytes, so that any number of them would be read.
      for (double i = 0; i < element.count && !element.properties.empty(); ++i) {
        if (element.name == "vertex") points.emplace_back(0, 0, 0);
        for (const Property& property : element.properties) {
          const double length = property.count_type ? Value(*property.count_type) : 1;
          std::vector<double> values;
          while (double(values.size()) < length) values.push_back(Value(*property.type));
          if (element.name == "vertex" && property.name.size() == 1 && property.name >= "x" &&
              property.name <= "z" && values.size() == 1)
            points.back()[property.name[0] - 'x'] = values[0];
          if (element.name == "face" && property.name.starts_with("vertex_ind"))
            faces.push_back(std::move(values));
        }
      }
    }
    std::vector<std::array<int, 3>> triangles;
    for (const std::vector<double>& face : faces) AddTriangles(face, points, &triangles);
    return MakeSurface(points, std::move(triangles), path_);
  }

 private:
  struct Property {
    std::string_view name;
    const PlyType* type;
    const PlyType* count_type;  // of a list; else nullptr
  };
  struct Element {
    std::string_view name;
    double count;
    std::vector<Property> properties;
  };

  const PlyType* ReadType() {
    const std::string_view name = source_.Word();
    for (const PlyType& type : kPlyTypes)
      if (name == type.name || name == type.other_name) return &type;
    source_.Fail("found the type '" + MakePrintableLine(name) + "', expected one of PLY");
  }

  void ReadHeader() {
    for (std::string_view key; key != "end_header"; source_.SkipLine()) {
      key = source_.Word();
      if (key == "format") {
        const std::string_view format = source_.Word();
        is_text_ = format == "ascii";
        is_swapped_ = format == "binary_big_endian";
      } else if (key == "element") {
        const std::string_view name = source_.Word();
        elements_.push_back({name, source_.Number(), {}});
      } else if (key == "property" && !elements_.empty()) {
        Source ahead = source_;
        const bool is_list = ahead.Word() == "list";
        if (is_list) source_.Word();
        const PlyType* count_type = is_list ? ReadType() : nullptr;
        const PlyType* type = ReadType();
        elements_.back().properties.push_back({source_.Word(), type, count_type});
      } else if (key != "ply" && key != "comment" && key != "obj_info" && key != "end_header") {
        source_.Fail("found '" + MakePrintableLine(key) + "', expected a line of a PLY header");
      }
    }
  }

  void RequirePlaces() const {
    for (const Element& element : elements_)
      for (const std::string_view axis : {"x", "y", "z"})
        if (element.name == "vertex" &&
            std::none_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& property) { return property.name == axis; }))
          throw InputError(
              path_, "the element vertex has no " + std::string(axis) + ", expected x, y and z");
  }

  double Value(const PlyType& type) {
    if (is_text_) return source_.Number();
    std::string bytes(source_.Bytes(type.size));
    if (is_swapped_) std::reverse(bytes.begin(), bytes.end());
    return type.read(bytes.data());
  }

  void AddTriangles(const std::vector<double>& face, const std::vector<Vector3d>& points,
                    std::vector<std::array<int, 3>>* triangles) const {
    std::vector<Vector3d> corners;
    for (const double i : face) {
      if (!(i >= 0 && i < double(points.size())))
        throw InputError(
            path_, Format("found a face of vertex %g, expected 0 … %zu", i, points.size() - 1));
      corners.push_back(points[static_cast<size_t>(i)]);
    }
    for (const auto& [a, b, c] : SplitPolygon(corners, path_))
      triangles->push_back({int(face[a]), int(face[b]), int(face[c])});
  }

  Source source_;
  const std::string& path_;
  bool is_text_ = false, is_swapped_ = false;
  std::vector<Element> elements_;
};

// A file that is not OBJ. It may have no faces.
ObjSurface ReadScan(const std::string& path, const std::string& extension) {
  const std::string text = ReadWholeFile(path);
  return extension == ".stl" ? ReadStl(text, path) : PlyReader(text, path).Read();
}

}  // namespace

std::string LowerExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool IsSurfaceFile(const std::string& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".obj" || extension == ".stl" || extension == ".ply";
}

ObjSurface ReadSurface(const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension != ".stl" && extension != ".ply") return ReadObjSurface(path);
  ObjSurface surface = ReadScan(path, extension);
  if (surface.triangles.empty()) throw InputError(path, "the file has no faces");
  return surface;
}

Eigen::VectorXd ReadVertices(const std::string& path) {
  const std::string extension = LowerExtension(path);
  const bool is_scan = extension == ".stl" || extension == ".ply";
  Eigen::VectorXd x =
      is_scan ? ReadScan(path, extension).x : Stacked(ParseObj(ReadWholeFile(path), path, false).v);
  if (x.size() == 0) throw InputError(path, "the file has no vertices");
  return x;
}

}  // namespace drape
