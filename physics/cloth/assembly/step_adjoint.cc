// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/step_adjoint.h"

#include <glog/logging.h>

namespace drape {
namespace {

template <class Law>
void AdjStretch(const Law& law, const ClothModel& model, const MaterialField& material,
                const double* x, const double* w, double h, const double* lambda, double* adj_x,
                double* gradient) {
  const int stride = material.stretch.size() == 1 ? 0 : kStretchEntries;
  for (int f = 0; f < model.mesh.num_faces(); ++f) {
    const Face& face = model.mesh.faces[f];
    const StretchTable& table = material.stretch_of(f);
    const StretchAdjoint adjoint = AdjStretchStep(
        law, GatherColumns(face, x), table, GatherColumns(face, w), h, GatherColumns(face, lambda));
    ScatterColumns(face, adjoint.adj_F, adj_x);
    double by_entry[kStretchRows][kStretchCols];
    law.StiffnessByTable(adjoint.G, table, by_entry);
    double* entry = gradient + static_cast<std::ptrdiff_t>(stride) * f;
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m)
        entry[kStretchCols * r + m] += face.area * adjoint.adj_stiffness[m] * by_entry[r][m];
  }
}

template <class Law>
void AdjBend(const Law& law, const ClothModel& model, const MaterialField& material,
             const double* x, const double* w, double h, const double* lambda, double* adj_x,
             double* gradient) {
  const int stride = material.bend.size() == 1 ? 0 : kBendEntries;
  for (int e = 0; e < model.mesh.num_hinges(); ++e) {
    const Hinge& hinge = model.mesh.hinges[e];
    const BendTable& table = material.bend_of(e);
    const HingeCorners corners = GatherCorners(hinge, x);
    const double theta = DihedralAngle(corners);
    const BendAdjoint adjoint = AdjBendStep(law, hinge, table, corners, GatherCorners(hinge, w), h,
                                            GatherCorners(hinge, lambda), theta);
    for (int i = 0; i < 12; ++i) adj_x[3 * hinge.vertex[i / 3] + i % 3] += adjoint.adj_x[i];
    BendTable by_entry;
    HingeStiffnessByTable(law, hinge, table, theta, by_entry.b);
    double* entry = gradient + static_cast<std::ptrdiff_t>(stride) * e;
    for (int k = 0; k < kBendEntries; ++k) entry[k] += adjoint.adj_kappa * by_entry.entries()[k];
  }
}

}  // namespace

void AdjStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
             const Eigen::VectorXd& w, double h, const RowMatrix& lambda, RowMatrix& adj_x,
             MaterialGradient& gradient) {
  CHECK_EQ(lambda.size(), model.num_dofs());
  CHECK_EQ(adj_x.size(), model.num_dofs());
  CHECK_EQ(gradient.stretch.cols(), 1);
  if (model.scene.stretch)
    std::visit(
        [&](const auto& law) {
          AdjStretch(law, model, material, x.data(), w.data(), h, lambda.data(), adj_x.data(),
                     gradient.stretch.data());
        },
        model.law.stretch);
  if (model.scene.bend)
    std::visit(
        [&](const auto& law) {
          AdjBend(law, model, material, x.data(), w.data(), h, lambda.data(), adj_x.data(),
                  gradient.bend.data());
        },
        model.law.bend);
  for (int i : model.held)
    adj_x.middleRows<3>(3 * i) -= h * model.scene.handles->stiffness * lambda.middleRows<3>(3 * i);
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      adj_x.middleRows<3>(3 * i) +=
          ContactStepDerivative(*model.scene.contact, model.vertex_area[i], x.segment<3>(3 * i),
                                w.segment<3>(3 * i), h)
              .transpose() *
          lambda.middleRows<3>(3 * i);
}

}  // namespace drape
