// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/obj_io.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>

#include "physics/mesh/self_intersection.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Tokens = std::vector<std::string_view>;

Tokens SplitAtBlanks(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  Tokens tokens;
  for (size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;
       begin = line.find_first_not_of(kBlanks, begin)) {
    const size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    tokens.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  return tokens;
}

// Splits "a/b/c" into {a, b, c}; fields may be empty.
Tokens SplitAtSlashes(std::string_view token) {
  Tokens fields;
  for (size_t begin = 0; begin <= token.size();) {
    const size_t end = std::min(token.find('/', begin), token.size());
    fields.push_back(token.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

template <typename T>
bool ParseWhole(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::string Quoted(std::string_view text) { return std::string(1, '\'').append(text) + '\''; }

// What says nothing of the triangles, in files of all kinds of programs.
constexpr std::string_view kSilent[] = {
    "o",   "g",     "s",        "usemtl",   "mtllib", "l",  "p",          "usemap",   "maplib",
    "lod", "bevel", "c_interp", "d_interp", "mg",     "vp", "shadow_obj", "trace_obj"};
constexpr size_t kMostSkipped = 5;  // that are named

class Parser {
 public:
  Parser(const std::string& path, bool round_to_float)
      : path_(path), round_to_float_(round_to_float) {}

  ObjContent Parse(std::string_view text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    std::string joined;  // lines that a backslash continues
    for (int number = 1; !text.empty(); ++number) {
      const size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (joined.empty()) line_ = number;
      const bool is_comment = joined.empty() && line.starts_with('#');  // "# C:\" ends there
      if (line.ends_with('\\') && !is_comment && !text.empty()) {
        line.remove_suffix(1);
        joined.append(line) += ' ';
      } else {
        ParseLine(joined.append(line));
        joined.clear();
      }
    }
    AddTriangles();
    return std::move(content_);
  }

 private:
  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(path_ + ":" + std::to_string(line_), problem);
  }

  void ParseLine(std::string_view line) {
    const Tokens tokens = SplitAtBlanks(line.substr(0, line.find('#')));
    if (tokens.empty()) return;
    const std::string_view key = tokens[0];
    if (key == "v") {
      const auto n = ParseNumbers(tokens, {3, 4, 6, 7});  // with w, or a colour
      if (tokens.size() == 5 && ParseNumber(tokens[4]) != 1)
        Fail("w is " + std::string(tokens[4]) + ", expected 1 or none");
      content_.v.emplace_back(n[0], n[1], n[2]);
    } else if (key == "vt") {
      const auto n = ParseNumbers(tokens, {2, 3});
      content_.vt.emplace_back(n[0], n[1]);
    } else if (key == "vn") {
      ParseNumbers(tokens, {3});
      ++content_.num_vn;
    } else if (key == "f") {
      ParseFace(tokens);
    } else if (std::find(std::begin(kSilent), std::end(kSilent), key) == std::end(kSilent) &&
               content_.skipped.size() < kMostSkipped) {
      content_.skipped.insert(Quoted(key));
    }
  }

  std::array<double, 3> ParseNumbers(const Tokens& tokens,
                                     const std::vector<size_t>& counts) const {
    const size_t count = tokens.size() - 1;
    if (std::find(counts.begin(), counts.end(), count) == counts.end()) {
      std::string expected;
      for (const size_t each : counts)
        expected += (expected.empty()        ? ""
                     : each == counts.back() ? " or "
                                             : ", ") +
                    std::to_string(each);
      Fail(Quoted(tokens[0]) + " has " + std::to_string(count) + " numbers, expected " + expected);
    }
    std::array<double, 3> numbers = {};
    for (size_t k = 0; k < std::min<size_t>(count, 3); ++k) numbers[k] = ParseNumber(tokens[k + 1]);
    return numbers;
  }

  double ParseNumber(std::string_view token) const {
    double value = 0;
    const bool ok = ParseWhole(token.starts_with('+') ? token.substr(1) : token, value);
    if (round_to_float_) value = static_cast<float>(value);
    if (!ok || !std::isfinite(value)) Fail(Quoted(token) + " is not a finite number");
    return value;
  }

  void ParseFace(const Tokens& tokens) {
    if (tokens.size() < 4)
      Fail("the face has " + std::to_string(tokens.size() - 1) + " corners, expected 3 or more");
    for (size_t k = 1; k < tokens.size(); ++k) corners_.push_back(ParseCorner(tokens[k]));
    polygons_.push_back({line_, corners_.size()});
  }

  // A corner is written as a, a/b, a//c or a/b/c.
  ObjCorner ParseCorner(std::string_view token) const {
    const Tokens fields = SplitAtSlashes(token);
    const bool has_vt = fields.size() >= 2 && !fields[1].empty();
    if (fields.size() > 3 || (fields.size() == 2 && !has_vt)) {
      Fail("corner " + Quoted(token) + ", expected a, a/b, a//c or a/b/c");
    }
    return {ParseIndex(fields[0], content_.v.size(), token),
            has_vt ? ParseIndex(fields[1], content_.vt.size(), token) : -1,
            fields.size() == 3 ? ParseIndex(fields[2], content_.num_vn, token) : -1};
  }

  int ParseIndex(std::string_view field, int64_t count_so_far, std::string_view corner) const {
    int index = 0;
    if (!ParseWhole(field, index) || index == 0) {
      Fail("corner " + Quoted(corner) + ": " + Quoted(field) +
           " is not an index, expected a positive or negative whole number");
    }
    if (index > 0) return index - 1;
    if (-static_cast<int64_t>(index) > count_so_far) {
      Fail("corner " + Quoted(corner) + ": index " + std::to_string(index) +
           " precedes the first of " + std::to_string(count_so_far) + " entries");
    }
    return static_cast<int>(count_so_far) + index;
  }

  // Runs at the end of the file, since a face may precede its vertices.
  void AddTriangles() {
    size_t begin = 0;
    for (const auto& [line, end] : polygons_) {
      line_ = line;
      std::vector<Eigen::Vector3d> points;
      for (size_t k = begin; k < end; ++k) {
        CheckUpperBound("v", corners_[k].v, content_.v.size());
        CheckUpperBound("vt", corners_[k].vt, content_.vt.size());
        CheckUpperBound("vn", corners_[k].vn, content_.num_vn);
        points.push_back(content_.v[corners_[k].v]);
      }
      for (const auto& [a, b, c] : SplitPolygon(points, path_ + ":" + std::to_string(line)))
        content_.faces.push_back(
            {{corners_[begin + a], corners_[begin + b], corners_[begin + c]}, line});
      begin = end;
    }
  }

  void CheckUpperBound(const std::string& key, int index, int64_t count) const {
    if (index >= count) {
      Fail(key + " index " + std::to_string(index + 1) + ", but the file has " +
           std::to_string(count) + " '" + key + "' lines");
    }
  }

  const std::string& path_;
  const bool round_to_float_;
  ObjContent content_;
  std::vector<ObjCorner> corners_;
  std::vector<std::pair<int, size_t>> polygons_;  // line, end among the corners
  int line_ = 0;
};

constexpr std::string_view kComment = "# ";

using Triangles = std::vector<std::array<int, 3>>;

ObjContent Load(const std::string& path, const ObjOptions& options) {
  ObjContent content = ParseObj(ReadWholeFile(path), path, options.round_to_float);
  std::string skipped;
  for (const std::string& key : content.skipped) (skipped += skipped.empty() ? "" : ", ") += key;
  if (content.faces.empty())
    throw InputError(
        path, "the file has no faces" + (skipped.empty() ? "" : "; no keyword of OBJ: " + skipped));
  if (!skipped.empty()) NoteInput(path, "skipped lines that begin with " + skipped);
  if (options.first_vt_is_dummy && !content.vt.empty()) {
    content.vt.erase(content.vt.begin());
  }
  return content;
}

template <typename Numbers>
void AppendLine(const char* key, const Numbers& numbers, std::string* text) {
  *text += key;
  for (const double number : numbers) AppendNumber(*text += ' ', number);
  *text += '\n';
}

void AppendVertices(const Eigen::VectorXd& x, std::string* text) {
  for (Eigen::Index i = 0; i < x.size(); i += 3) AppendLine("v", x.segment<3>(i), text);
}

ObjSurface MakeSurface(const ObjContent& content) {
  ObjSurface surface;
  surface.x.resize(3 * content.v.size());
  for (size_t i = 0; i < content.v.size(); ++i) surface.x.segment<3>(3 * i) = content.v[i];
  for (const ObjFace& face : content.faces) {
    surface.triangles.push_back({face.corner[0].v, face.corner[1].v, face.corner[2].v});
  }
  return surface;
}

// The vt of each vertex if each vertex has exactly one value; otherwise std::nullopt and the cause
// in `reason`.
std::optional<Eigen::Matrix2Xd> UvFromVt(const ObjContent& content, std::string& reason) {
  Eigen::Matrix2Xd uv = Eigen::Matrix2Xd::Zero(2, content.v.size());
  std::vector<bool> known(content.v.size(), false);
  for (const ObjFace& face : content.faces) {
    for (const ObjCorner& corner : face.corner) {
      const auto line = [&] { return " (line " + std::to_string(face.line) + ")"; };
      if (corner.vt < 0 || corner.vt >= static_cast<int>(content.vt.size())) {
        reason = "a corner has no vt" + line();
        return std::nullopt;
      }
      if (known[corner.v] && uv.col(corner.v) != content.vt[corner.vt]) {
        reason = "vertex " + std::to_string(corner.v + 1) + " has two different vt" + line();
        return std::nullopt;
      }
      uv.col(corner.v) = content.vt[corner.vt];
      known[corner.v] = true;
    }
  }
  return uv;
}

bool IsFlat(const ObjContent& content) {
  for (const Eigen::Vector3d& v : content.v) {
    if (v.z() != content.v[0].z()) return false;
  }
  return true;
}

Eigen::Matrix2Xd UvFromXy(const ObjContent& content) {
  Eigen::Matrix2Xd uv(2, content.v.size());
  for (size_t i = 0; i < content.v.size(); ++i) uv.col(i) = content.v[i].head<2>();
  return uv;
}

Eigen::Matrix2Xd MaterialCoordinates(const ObjContent& content, const std::string& path) {
  std::string reason;
  if (auto uv = UvFromVt(content, reason)) return *std::move(uv);
  if (IsFlat(content)) return UvFromXy(content);
  throw InputError(path, "no material coordinates: " + reason +
                             ", and z is not constant; expected one vt per vertex or a flat mesh");
}

// Whether texture coordinates are places on a picture rather than in a cloth of metres.
bool FillsUnitSquare(const Eigen::Matrix2Xd& uv) {
  constexpr double kNear = 0.01;
  return (uv.rowwise().minCoeff().array().abs() < kNear).all() &&
         ((uv.rowwise().maxCoeff().array() - 1.0).abs() < kNear).all();
}

// The material coordinates. Those in 0 … 1 would otherwise be read as a cloth of one metre: of a
// flat mesh x and y are taken in their place.
Eigen::Matrix2Xd CheckUvIsInMetres(const ObjContent& content, const Eigen::Matrix2Xd& uv,
                                   const std::string& path) {
  double length_uv = 0, length_v = 0;
  for (const ObjFace& face : content.faces) {
    for (int k = 0; k < 3; ++k) {
      const int a = face.corner[k].v, b = face.corner[(k + 1) % 3].v;
      length_uv += (uv.col(b) - uv.col(a)).norm();
      length_v += (content.v[b] - content.v[a]).norm();
    }
  }
  const double most = FillsUnitSquare(uv) ? 1.1 : 2.0;
  if (length_uv <= most * length_v && length_v <= most * length_uv) return uv;
  const double edges = 3.0 * content.faces.size();
  const std::string found = "vt is not in metres: its mean edge is " +
                            std::to_string(length_uv / edges) + ", that of v is " +
                            std::to_string(length_v / edges);
  if (!IsFlat(content)) throw InputError(path, found);
  NoteInput(path, found + "; of the flat mesh x and y are taken");
  return UvFromXy(content);
}

// Turns over a mesh that is clockwise throughout. A mixed orientation is an error at the line of
// the first face that differs.
void OrientCounterClockwise(const ObjContent& content, const Eigen::Matrix2Xd& uv,
                            const std::string& path, Triangles& triangles) {
  std::optional<bool> clockwise;
  for (size_t f = 0; f < triangles.size(); ++f) {
    const auto& t = triangles[f];
    const Eigen::Vector2d e1 = uv.col(t[1]) - uv.col(t[0]), e2 = uv.col(t[2]) - uv.col(t[0]);
    const double det = e1.x() * e2.y() - e2.x() * e1.y();
    if (det == 0) continue;  // BuildMesh reports it
    if (clockwise.value_or(det < 0) != (det < 0)) {
      throw InputError(path + ":" + std::to_string(content.faces[f].line),
                       "the face is oriented opposite to the first one in material coordinates");
    }
    clockwise = det < 0;
  }
  if (!clockwise.value_or(false)) return;
  for (auto& t : triangles) std::swap(t[1], t[2]);
}

}  // namespace

std::vector<std::array<int, 3>> SplitPolygon(const std::vector<Eigen::Vector3d>& corners,
                                             const std::string& where) {
  constexpr int kMost = 1000;
  constexpr double kRounding = 1e-9;
  const int n = static_cast<int>(corners.size());
  if (n < 3) throw InputError(where, Format("found a face of %d corners, expected 3 or more", n));
  if (n == 3) return {{0, 1, 2}};
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int k = 0; k < n; ++k)
    normal += (corners[k] - corners[0]).cross(corners[(k + 1) % n] - corners[0]);
  const auto least_area = [&](int from) {
    double least = HUGE_VAL;
    for (int k = 1; k + 1 < n; ++k) {
      const Eigen::Vector3d a = corners[(from + k) % n] - corners[from],
                            b = corners[(from + k + 1) % n] - corners[from];
      least = std::min(least, a.cross(b).dot(normal));
    }
    return least;
  };
  int best = 0;
  double area = -HUGE_VAL;
  for (int from = 0; from < n && n <= kMost; ++from)
    if (const double least = least_area(from); least > area)
      std::tie(best, area) = std::pair(from, least);
  if (n > 4 && !(area >= -kRounding * normal.squaredNorm()))
    throw InputError(where, Format("found a face of %d corners, expected 3, or a polygon of at "
                                   "most %d of which one corner sees all",
                                   n, kMost));
  std::vector<std::array<int, 3>> triangles;
  for (int k = 1; k + 1 < n; ++k) triangles.push_back({best, (best + k) % n, (best + k + 1) % n});
  return triangles;
}

ObjContent ParseObj(std::string_view text, const std::string& path, bool round_to_float) {
  return Parser(path, round_to_float).Parse(text);
}

ObjSurface ReadObjSurface(const std::string& path, const ObjOptions& options) {
  return MakeSurface(Load(path, options));
}

Eigen::Vector3d Extents(const ObjSurface& surface) {
  const auto x = surface.x.reshaped(3, surface.x.size() / 3);
  return x.rowwise().maxCoeff() - x.rowwise().minCoeff();
}

void RequireClosed(const ObjSurface& surface, const std::string& where) {
  std::map<std::pair<int, int>, int> faces;
  for (size_t f = 0; f < surface.triangles.size(); ++f) {
    const auto& t = surface.triangles[f];
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!faces.try_emplace({a, b}, static_cast<int>(f)).second)
        throw InputError(where,
                         Format("face %zu: edge %d-%d runs as in another face, expected two "
                                "faces at each edge, which traverse it in opposite directions",
                                f + 1, a + 1, b + 1));
    }
  }
  for (const auto& [edge, face] : faces)
    if (!faces.count({edge.second, edge.first}))
      throw InputError(where, Format("face %d: edge %d-%d has no second face, expected a closed "
                                     "surface",
                                     face + 1, edge.first + 1, edge.second + 1));
}

void RequireSolid(const ObjSurface& surface, const std::string& where) {
  const auto vertex = [&](int i) -> Eigen::Vector3d { return surface.x.segment<3>(3 * i); };
  double volume = 0;
  for (const auto& t : surface.triangles)
    volume += vertex(t[0]).dot(vertex(t[1]).cross(vertex(t[2])));
  if (!(volume > 0))
    throw InputError(where, Format("the volume is %g m³, expected > 0: faces counter-clockwise as "
                                   "seen from outside",
                                   volume / 6));
  const auto found = FindSelfIntersections(surface.triangles, surface.x);
  if (found.empty()) return;
  const Eigen::Vector3d place = vertex(surface.triangles[found[0].first][0]);
  throw InputError(
      where, Format("faces %d and %d intersect near (%.4g, %.4g, %.4g), expected a "
                    "surface that does not intersect itself",
                    found[0].first + 1, found[0].second + 1, place.x(), place.y(), place.z()));
}

Mesh ReadObj(const std::string& path, const ObjOptions& options) {
  const ObjContent content = Load(path, options);
  CheckUsual(path + ": extent", Extents(MakeSurface(content)).maxCoeff(), "m", 0.01, 5);
  const Eigen::Matrix2Xd uv = CheckUvIsInMetres(content, MaterialCoordinates(content, path), path);
  ObjSurface surface = MakeSurface(content);
  OrientCounterClockwise(content, uv, path, surface.triangles);
  return BuildMesh(surface.x, uv, surface.triangles, path);
}

void WriteObj(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::optional<DrapeDiscs>& discs) {
  CHECK_EQ(x.size(), 3 * mesh.num_vertices());
  std::string text = "# drapefit cloth, metres\n";
  if (discs) text += std::string(kComment) + DiscsLine(*discs) + "\n";
  AppendVertices(x, &text);
  for (int i = 0; i < mesh.num_vertices(); ++i) AppendLine("vt", mesh.uv.col(i), &text);
  for (const Face& face : mesh.faces) {
    text += 'f';
    for (const int vertex : face.vertex) {
      const std::string index = std::to_string(vertex + 1);
      text += ' ' + index + '/' + index;
    }
    text += '\n';
  }
  WriteFileAtomically(path, text);
}

void WriteObj(const std::string& path, const ObjSurface& surface) {
  std::string text = "# drapefit surface, metres\n";
  AppendVertices(surface.x, &text);
  for (const auto& [a, b, c] : surface.triangles)
    text += Format("f %d %d %d\n", a + 1, b + 1, c + 1);
  WriteFileAtomically(path, text);
}

std::optional<DrapeDiscs> ReadObjDiscs(const std::string& path) {
  std::istringstream lines(ReadWholeFile(path));
  for (std::string line; std::getline(lines, line) && line.starts_with('#');)
    if (line.starts_with(kComment))
      if (const auto discs = ParseDiscsLine(line.substr(kComment.size()))) return discs;
  return std::nullopt;
}

}  // namespace drape
