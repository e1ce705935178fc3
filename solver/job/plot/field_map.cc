// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/field_map.h"

#include <glog/logging.h>

#include <cmath>
#include <initializer_list>
#include <utility>

#include "solver/job/plot/chart.h"

namespace drape {
namespace {

constexpr double kCentimetres = 100.0;  // a metre

void AppendPolygon(ChartSeries& field, std::initializer_list<Eigen::Vector2d> corners,
                   double value) {
  for (const Eigen::Vector2d& corner : corners) field.points.push_back(kCentimetres * corner);
  field.points.emplace_back(std::nan(""), std::nan(""));
  field.values.resize(field.points.size(), value);
}

void Render(const std::string& path, ChartSeries field, const FieldMapOptions& options) {
  Chart chart{.title = options.title,
              .x = {.label = "weft [cm]"},
              .y = {.label = "warp [cm]"},
              .colour = {.label = options.unit},
              .grid = false,
              .equal_units = true};
  chart.series.push_back(std::move(field));
  WritePicture(path, {.width = 900, .height = 760, .font_size = 13, .charts = {std::move(chart)}});
}

}  // namespace

void RenderFaceMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_face,
                   const FieldMapOptions& options) {
  CHECK_EQ(of_face.size(), mesh.num_faces());
  ChartSeries field{.mark = Mark::kPolygons};
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const int* v = mesh.faces[f].vertex;
    AppendPolygon(field, {mesh.uv.col(v[0]), mesh.uv.col(v[1]), mesh.uv.col(v[2])}, of_face[f]);
  }
  Render(path, std::move(field), options);
}

void RenderHingeMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_hinge,
                    const FieldMapOptions& options) {
  CHECK_EQ(of_hinge.size(), mesh.num_hinges());
  const Eigen::Matrix2Xd centres = FaceCentres(mesh);
  ChartSeries field{.mark = Mark::kPolygons};
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    const Hinge& hinge = mesh.hinges[e];
    AppendPolygon(field,
                  {mesh.uv.col(hinge.vertex[0]), centres.col(hinge.face[0]),
                   mesh.uv.col(hinge.vertex[1]), centres.col(hinge.face[1])},
                  of_hinge[e]);
  }
  Render(path, std::move(field), options);
}

}  // namespace drape
