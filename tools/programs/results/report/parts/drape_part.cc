// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/drape_part.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <utility>

#include "losses/camera/camera.h"
#include "losses/image/segmentation.h"
#include "losses/outline/outline.h"
#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kAngles = 360;
constexpr std::size_t kMostDrapes = 12;  // of one folder

// drape_fit writes its drapes as a camera sees them whose centre is that of the image.
Eigen::VectorXd SeenFrom(const Camera& camera, Eigen::VectorXd x) {
  const double scale = camera.pixels_per_metre();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    x[i] -= (camera.cx - 0.5 * (camera.width - 1)) / scale;
    x[i + 1] += (camera.cy - 0.5 * (camera.height - 1)) / scale;
  }
  return x;
}

std::string MakePath(const Eigen::VectorXd& radius, const Camera& camera, const char* layer) {
  std::string path = std::string("<path class=\"") + layer + "\" d=\"";
  for (Eigen::Index k = 0; k < radius.size(); ++k) {
    const double angle = 2 * M_PI * static_cast<double>(k) / static_cast<double>(radius.size());
    path += Format("%s%.2f %.2f", k == 0 ? "M" : "L", camera.cx + 0.5 + radius[k] * std::cos(angle),
                   camera.cy + 0.5 - radius[k] * std::sin(angle));
  }
  return path + "Z\"/>\n";
}

std::string Ring(const Camera& camera, double radius) {
  return Format("<circle class=\"ring\" cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\"/>\n", camera.cx + 0.5,
                camera.cy + 0.5, radius * camera.pixels_per_metre());
}

// 5 cm, in the lower left corner.
std::string Scale(const Camera& camera) {
  constexpr double kLength = 0.05;
  const double edge = 0.04 * camera.width, y = camera.height - edge;
  return Format(
      "<path class=\"scale\" d=\"M%.1f %.1fh%.1f\"/><text x=\"%.1f\" y=\"%.1f\" "
      "font-size=\"%.1f\">5 cm</text>\n",
      edge, y, kLength * camera.pixels_per_metre(), edge, y - 0.5 * edge, 0.045 * camera.width);
}

std::string Toggle(const char* layer, const char* text) {
  return Format(
      "<label class=\"l-%s\"><input type=\"checkbox\" class=\"t-%s\" checked>%s</label>\n", layer,
      layer, text);
}

std::string Layers(const ResultFolder& folder, const nlohmann::json& image, ReportPage* page) {
  const std::string file = image.at("file").get<std::string>();
  const Camera camera = CameraFromJson(image, file);
  const GrayImage silhouette = ReadSilhouette(file).image;
  if (silhouette.width != camera.width || silhouette.height != camera.height)
    throw InputError(file, "has another size than the fit's image");
  const std::string drape = folder.File("drape_" + image.at("name").get<std::string>() + ".obj");
  const Mesh mesh = ReadObj(drape);
  const Eigen::VectorXd x = SeenFrom(camera, ReadObjSurface(drape).x);
  Outline seen, fitted;
  OutlineFromImage(silhouette, camera, kAngles, &seen);
  OutlineFromMesh(mesh, x, camera, kAngles, &fitted);
  std::string svg =
      Format("<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"", camera.width, camera.height) +
      EscapeHtml("Outline of " + file + " and of the fitted drape") + "\">\n";
  const std::string uri = ImageUri(ReadWholeFile(file));
  if (page->TakeRoom(uri.size(), file))
    svg += Format("<image width=\"%d\" height=\"%d\" opacity=\"0.35\" href=\"", camera.width,
                  camera.height) +
           uri + "\"/>\n";
  const DrapeDiscs discs = folder.Discs().value_or(DrapeDiscs());
  svg += Ring(camera, discs.support) + Ring(camera, discs.specimen) +
         MakePath(seen.radius, camera, "image") + MakePath(fitted.radius, camera, "fitted") +
         Scale(camera) + "</svg>\n";
  return "<figure class=\"photo\">\n<div class=\"layers\">\n" + Toggle("picture", "picture") +
         Toggle("image", "outline of the image") + Toggle("fitted", "outline of the fit") +
         Toggle("ring", "support and flat cloth") + "</div>\n" + svg + "</figure>\n";
}

// Without what can no longer be read: the picture of the fit.
std::string StoredOverlay(const ResultFolder& folder, const std::string& name,
                          const std::string& reason, ReportPage* page) {
  const std::string file = folder.File("fit_" + name + ".png");
  if (!fs::is_regular_file(file)) return HtmlElement("p", reason, "missing");
  return page->AddImage(file, "Outlines of the image, blue, and of the fit, red", reason);
}

std::string Metrics(const nlohmann::json& image) {
  const double px_per_mm =
      1e-3 * FindNumber(image, "/camera/px_per_m").value_or(Camera().pixels_per_metre());
  std::vector<CellRow> rows;
  const auto add = [&](const char* name, const std::string& first, const std::string& second) {
    rows.push_back({{name, Cell::Kind::kHeader}, NumberCell(first), NumberCell(second)});
  };
  const auto number = [&](const char* where, double factor, const char* format) {
    return NumberText(image, where, factor, format);
  };
  add("drape coefficient [%]", number("/metrics/dc_image", 100, "%.1f"),
      number("/metrics/dc_fit", 100, "%.1f"));
  if (const nlohmann::json* photograph = Find(image, "/photograph"))
    add("the photograph's, ± standard deviation [%]", CoefficientText(*photograph), "");
  add("nodes", number("/metrics/folds_image", 1, "%.0f"), number("/metrics/folds_fit", 1, "%.0f"));
  add("outline error, rms [mm]", "", number("/metrics/profile_rms_px", 1 / px_per_mm, "%.2f"));
  add("the same after settling [mm]", "",
      number("/settled/metrics/profile_rms_px", 1 / px_per_mm, "%.2f"));
  add("overlap of the areas (IoU) [%]", "", number("/metrics/iou", 100, "%.1f"));
  add("lowest vibration [Hz]", "", number("/stability/lowest_frequency_hz", 1, "%.2f"));
  return HtmlTable("", {"", "image", "fit"}, rows);
}

std::string Image(const ResultFolder& folder, const nlohmann::json& image, ReportPage* page) {
  const std::string name = FindText(image, "/name");
  std::string html = HtmlElement("p", name, "quiet");
  try {
    html += Layers(folder, image, page);
  } catch (const std::exception& error) {
    html += StoredOverlay(folder, name, error.what(), page);
  }
  html = "<div class=\"side\">\n<div>" + html + "</div>\n<div>" + Metrics(image);
  for (const std::string& note : FindTexts(image, "/quality/notes"))
    html += HtmlElement("p", note, "quiet");
  return html + "</div></div>\n";
}

template <class Scalar, class Numbers>
std::string Packed(const Numbers& numbers) {
  std::string bytes(sizeof(Scalar) * static_cast<std::size_t>(numbers.size()), '\0');
  for (std::size_t i = 0; i < static_cast<std::size_t>(numbers.size()); ++i) {
    const auto value = static_cast<Scalar>(numbers[i]);
    std::memcpy(&bytes[i * sizeof(Scalar)], &value, sizeof(Scalar));
  }
  return Base64(bytes);
}

// Of the faces around each vertex, by their area.
Eigen::VectorXd MeanOfFaces(const Mesh& mesh, const Eigen::VectorXd& values) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), area = sum;
  for (int f = 0; f < mesh.num_faces(); ++f)
    for (const int v : mesh.faces[f].vertex) {
      sum[v] += mesh.faces[f].area * values[f];
      area[v] += mesh.faces[f].area;
    }
  return sum.cwiseQuotient(area);
}

// The largest principal strain of each face against its rest shape, λ − 1 [%].
Eigen::VectorXd Stretch(const Mesh& mesh, const Eigen::VectorXd& x) {
  Eigen::VectorXd stretch(mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Face& face = mesh.faces[f];
    Eigen::Matrix<double, 3, 2> edges;
    for (int k = 0; k < 2; ++k)
      edges.col(k) = x.segment<3>(3 * face.vertex[k + 1]) - x.segment<3>(3 * face.vertex[0]);
    Eigen::Matrix2d inverse_rest;
    inverse_rest << face.inverse_rest[0], face.inverse_rest[1], face.inverse_rest[2],
        face.inverse_rest[3];
    const Eigen::Matrix<double, 3, 2> deformation = edges * inverse_rest;
    const Eigen::Matrix2d squares = deformation.transpose() * deformation;
    stretch[f] =
        100 *
        (std::sqrt(
             Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(squares).eigenvalues().maxCoeff()) -
         1);
  }
  return stretch;
}

// The angle of each hinge over the length between the centres of its faces, at its vertices [1/m].
Eigen::VectorXd Curvature(const Mesh& mesh, const Eigen::VectorXd& x) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), count = sum;
  const auto normal = [&](int f) {
    const int* v = mesh.faces[f].vertex;
    const Eigen::Vector3d a = x.segment<3>(3 * v[0]), b = x.segment<3>(3 * v[1]),
                          c = x.segment<3>(3 * v[2]);
    return Eigen::Vector3d((b - a).cross(c - a).normalized());
  };
  for (const Hinge& hinge : mesh.hinges) {
    const double cosine = std::clamp(normal(hinge.face[0]).dot(normal(hinge.face[1])), -1.0, 1.0);
    const double length = 2 * hinge.rest_area / (3 * hinge.rest_length);
    for (const int v : {hinge.vertex[0], hinge.vertex[1]}) {
      sum[v] += std::acos(cosine) / length;
      count[v] += 1;
    }
  }
  return sum.cwiseQuotient(count.cwiseMax(1.0));
}

// In 65,535 steps from the least to the most.
Json NumbersJson(const Eigen::VectorXd& values) {
  const double least = values.minCoeff(), most = values.maxCoeff();
  const double step = most > least ? (most - least) / 65535 : 1.0;
  const Eigen::VectorXd steps = ((values.array() - least) / step).round();
  return {{"least", least}, {"most", most}, {"steps", Packed<std::uint16_t>(steps)}};
}

Json FieldJson(const char* name, const char* unit, const Eigen::VectorXd& values) {
  Json json = {{"name", name}, {"unit", unit}};
  json.update(NumbersJson(values));
  return json;
}

std::string PackedFaces(const Mesh& mesh) {
  std::vector<int> corners;
  for (const Face& face : mesh.faces) corners.insert(corners.end(), face.vertex, face.vertex + 3);
  return mesh.num_vertices() <= 65536 ? Packed<std::uint16_t>(corners)
                                      : Packed<std::uint32_t>(corners);
}

// A drape of the viewer. Its faces are left out where they are those of the viewer's first drape.
Json DrapeJson(const Mesh& mesh, const Eigen::VectorXd& x, const std::string& name,
               const std::optional<DrapeDiscs>& discs, const Json& viewer) {
  Eigen::VectorXd height(mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) height[v] = 1e3 * x[3 * v + 2];
  Json json = {{"name", name},
               {"support_m", discs ? Json(discs->support) : Json()},
               {"positions", NumbersJson(x)},
               {"fields",
                {FieldJson("height", "mm", height),
                 FieldJson("stretch", "%", MeanOfFaces(mesh, Stretch(mesh, x))),
                 FieldJson("curvature", "1/m", Curvature(mesh, x))}}};
  const std::string faces = PackedFaces(mesh);
  if (viewer.empty() || viewer[0].at("faces") != faces) json["faces"] = faces;
  return json;
}

// A drape to show, read when it is its turn.
struct StoredDrape {
  std::string name;
  std::function<std::pair<Mesh, Eigen::VectorXd>()> read;
};

// "drape_a.obj" → "a".
std::string DrapeName(const std::string& file) {
  const std::string stem = fs::path(file).stem().string();
  return stem.starts_with("drape_") ? stem.substr(6) : stem;
}

// Meshes of drape_fit, drape_simulate and drape_predict.
std::vector<StoredDrape> MeshFiles(const ResultFolder& folder) {
  std::vector<StoredDrape> drapes;
  for (const std::string& file : folder.Files(".obj"))
    drapes.push_back({DrapeName(file), [path = folder.File(file)] {
                        return std::pair(ReadObj(path), ReadObjSurface(path).x);
                      }});
  return drapes;
}

// States of drape_equilibria, on the mesh that its summary names.
std::vector<StoredDrape> BranchStates(const ResultFolder& folder) {
  std::vector<StoredDrape> drapes;
  for (const nlohmann::json& branch : FindList(folder.summary, "/branches"))
    drapes.push_back({Format("branch %zu, %.0f %% of the drapes", drapes.size() + 1,
                             100 * FindNumber(branch, "/frequency").value_or(0.0)),
                      [path = folder.File(FindText(branch, "/state")),
                       spec = FindText(folder.summary, "/mesh")] {
                        Mesh mesh = ParseMeshSpec(spec);
                        const int vertices = mesh.num_vertices();
                        return std::pair(std::move(mesh), ReadState(path, vertices).x);
                      }});
  return drapes;
}

std::vector<StoredDrape> ListDrapes(const ResultFolder& folder) {
  if (folder.program == "drape_equilibria") return BranchStates(folder);
  const bool drapes_hang =
      folder.IsFit() || folder.program == "drape_simulate" || folder.program == "drape_predict";
  return drapes_hang ? MeshFiles(folder) : std::vector<StoredDrape>();
}

std::string Drapes(const ResultFolder& folder, ReportPage* page) {
  std::string html;
  Json drapes = Json::array();
  const std::vector<StoredDrape> stored = ListDrapes(folder);
  for (std::size_t i = 0; i < std::min(stored.size(), kMostDrapes); ++i) try {
      const auto [mesh, x] = stored[i].read();
      Json drape = DrapeJson(mesh, x, stored[i].name, folder.Discs(), drapes);
      if (!page->TakeRoom(drape.dump().size(), folder.name + ": drape " + stored[i].name)) continue;
      drapes.push_back(std::move(drape));
    } catch (const InputError& error) {
      html += HtmlElement("p", error.what(), "missing");
    }
  if (drapes.size() < stored.size())
    html += HtmlElement("p", Format("%zu of %zu drapes are shown", drapes.size(), stored.size()),
                        "missing");
  if (drapes.empty()) return html;
  page->drapes.push_back(drapes);
  return Format("<div class=\"drapes\" data-drapes=\"%zu\"></div>\n", page->drapes.size() - 1) +
         html;
}

}  // namespace

void AddImages(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("images", "Image and fit", SideBySide(folders, [&](const auto& folder) {
                     std::string html;
                     if (folder.IsFit())
                       for (const nlohmann::json& image : FindList(folder.summary, "/images"))
                         html += "<div>" + Image(folder, image, page) + "</div>";
                     return html.empty() ? "" : "<div class=\"side\">\n" + html + "</div>\n";
                   }));
}

void AddDrapes(const std::vector<ResultFolder>& folders, ReportPage* page) {
  std::string html = SideBySide(folders, [&](const auto& folder) { return Drapes(folder, page); });
  if (!html.empty())
    html = "<p class=\"quiet unscripted\">The drape in three dimensions needs a script.</p>\n" +
           HtmlElement("p",
                       "Drag or use the arrow keys to turn, the wheel or two fingers to zoom. "
                       "Stretch is the largest principal strain against the flat cloth.",
                       "quiet") +
           html;
  page->AddSection("drape", "Drape in three dimensions", html);
}

}  // namespace drape
