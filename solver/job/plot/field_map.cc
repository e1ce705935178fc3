// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/field_map.h"

#include <glog/logging.h>

#include <initializer_list>

#include "physics/util/atomic_file.h"
#include "solver/job/plot/gnuplot.h"

namespace drape {
namespace {

constexpr double kCentimetres = 100.0;  // a metre
// Colours that grow in lightness alone, readable in grey too ("viridis", Smith and van der Walt).
constexpr char kPalette[] =
    "set palette defined (0 '#440154', .25 '#3b528b', .5 '#21918c', .75 '#5ec962', 1 '#fde725')\n";

// Corners of a polygon in the units of the plot, each with the value that colours it.
void AppendPolygon(std::string& data, std::initializer_list<Eigen::Vector2d> corners,
                   double value) {
  for (const Eigen::Vector2d& corner : corners) {
    AppendNumber(data, kCentimetres * corner.x());
    AppendNumber(data += ' ', kCentimetres * corner.y());
    AppendNumber(data += ' ', value);
    data += '\n';
  }
  data += "\n\n";
}

void Draw(const std::string& path, const std::string& data, const FieldMapOptions& options) {
  std::string script =
      "set encoding utf8\nset terminal pngcairo size 900,760 font 'Sans,13'\n"
      "set size ratio -1\nset style fill solid noborder\nset tics out\n"
      "set xlabel 'weft [cm]'\nset ylabel 'warp [cm]'\n";
  script += "set title \"" + options.title + "\"\nset cblabel \"" + options.unit + "\"\n";
  script += kPalette;
  script += "$field << END\n" + data + "END\n";
  script += "plot $field using 1:2:3 with filledcurves closed fillcolor palette notitle\n";
  WriteFileAtomically(path, RunGnuplot(script));
}

}  // namespace

void RenderFaceMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_face,
                   const FieldMapOptions& options) {
  CHECK_EQ(of_face.size(), mesh.num_faces());
  std::string data;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const int* v = mesh.faces[f].vertex;
    AppendPolygon(data, {mesh.uv.col(v[0]), mesh.uv.col(v[1]), mesh.uv.col(v[2])}, of_face[f]);
  }
  Draw(path, data, options);
}

void RenderHingeMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_hinge,
                    const FieldMapOptions& options) {
  CHECK_EQ(of_hinge.size(), mesh.num_hinges());
  const Eigen::Matrix2Xd centres = FaceCentres(mesh);
  std::string data;
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    const Hinge& hinge = mesh.hinges[e];
    AppendPolygon(data,
                  {mesh.uv.col(hinge.vertex[0]), centres.col(hinge.face[0]),
                   mesh.uv.col(hinge.vertex[1]), centres.col(hinge.face[1])},
                  of_hinge[e]);
  }
  Draw(path, data, options);
}

}  // namespace drape
