// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/material_sensitivity.h"

#include <glog/logging.h>

#include <algorithm>
#include <vector>

#include "physics/material/laws/element_sensitivity.h"
#include "physics/util/math/simd.h"

namespace drape {
namespace {

template <class Law>
void AddStretchColumns(const Law& law, const ClothModel& model, const MaterialField& material,
                       const MaterialField& weight, const double* x, const double* w, double h,
                       RowMatrix& columns) {
  for (int f = 0; f < model.mesh.num_faces(); ++f) {
    const Face& face = model.mesh.faces[f];
    const FaceSensitivity s = EvaluateSensitivity(law, face, material.stretch_of(f), x, w, h);
    const StretchTable& scale = weight.stretch_of(f);
    double factor[kStretchEntries];
    for (int k = 0; k < kStretchEntries; ++k) factor[k] = s.by_entries()[k] * scale.entries()[k];
    const ShapeGradient shape = GradientOf(face);
    for (int i = 0; i < 9; ++i) {
      const double u = shape.u[i / 3], v = shape.v[i / 3];
      double* row = &columns(3 * face.vertex[i / 3] + i % 3, 0);
      Vec4 b;  // along c11 c12 c22 c33, as in each row of a table
      static_assert(kStretchCols == 4);
      for (int m = 0; m < kStretchCols; ++m)
        b[m] = u * (&s.basis[m].u.x)[i % 3] + v * (&s.basis[m].v.x)[i % 3];
      for (int k = 0; k < kStretchEntries; k += kStretchCols)
        Store(LoadAs<Vec4>(row + k) + LoadAs<Vec4>(factor + k) * b, row + k);
    }
  }
}

template <class Law>
void AddBendColumns(const Law& law, const ClothModel& model, const MaterialField& material,
                    const MaterialField& weight, const double* x, const double* w, double h,
                    RowMatrix& columns) {
  for (int e = 0; e < model.mesh.num_hinges(); ++e) {
    const Hinge& hinge = model.mesh.hinges[e];
    const HingeSensitivity s = EvaluateSensitivity(law, hinge, material.bend_of(e), x, w, h);
    const BendTable& scale = weight.bend_of(e);
    double factor[kBendEntries];
    for (int k = 0; k < kBendEntries; ++k) factor[k] = s.by_entries()[k] * scale.entries()[k];
    for (int i = 0; i < 12; ++i) {
      double* row = &columns(3 * hinge.vertex[i / 3] + i % 3, kStretchEntries);
      const double basis = (&s.basis.d[0].x)[i];
      for (int k = 0; k < kBendEntries; ++k) row[k] += factor[k] * basis;
    }
  }
}

void AddScaledRow(double scale, const double* from, int columns, double* to) {
  for (int j = 0; j < columns; ++j) to[j] += scale * from[j];
}

template <class Law>
void AddStretchGradient(const Law& law, const ClothModel& model, const MaterialField& material,
                        const double* x, const double* w, double h, const RowMatrix& lambda,
                        RowMatrix& gradient) {
  const int columns = static_cast<int>(lambda.cols());
  std::vector<double> along_basis(columns);
  double* u = along_basis.data();
  for (int f = 0; f < model.mesh.num_faces(); ++f) {
    const Face& face = model.mesh.faces[f];
    const FaceSensitivity s = EvaluateSensitivity(law, face, material.stretch_of(f), x, w, h);
    const ShapeGradient shape = GradientOf(face);
    const int first = material.stretch.size() == 1 ? 0 : kStretchEntries * f;
    for (int m = 0; m < kStretchCols; ++m) {
      std::fill_n(u, columns, 0.0);
      for (int i = 0; i < 9; ++i)
        AddScaledRow(
            shape.u[i / 3] * (&s.basis[m].u.x)[i % 3] + shape.v[i / 3] * (&s.basis[m].v.x)[i % 3],
            &lambda(3 * face.vertex[i / 3] + i % 3, 0), columns, u);
      for (int r = 0; r < kStretchRows; ++r)
        if (s.by_entry[r][m] != 0.0)
          AddScaledRow(s.by_entry[r][m], u, columns, &gradient(first + kStretchCols * r + m, 0));
    }
  }
}

template <class Law>
void AddBendGradient(const Law& law, const ClothModel& model, const MaterialField& material,
                     const double* x, const double* w, double h, const RowMatrix& lambda,
                     RowMatrix& gradient) {
  const int columns = static_cast<int>(lambda.cols());
  std::vector<double> along_basis(columns);
  double* u = along_basis.data();
  for (int e = 0; e < model.mesh.num_hinges(); ++e) {
    const Hinge& hinge = model.mesh.hinges[e];
    const HingeSensitivity s = EvaluateSensitivity(law, hinge, material.bend_of(e), x, w, h);
    const int first = material.bend.size() == 1 ? 0 : kBendEntries * e;
    std::fill_n(u, columns, 0.0);
    for (int i = 0; i < 12; ++i)
      AddScaledRow((&s.basis.d[0].x)[i], &lambda(3 * hinge.vertex[i / 3] + i % 3, 0), columns, u);
    for (int k = 0; k < kBendEntries; ++k)
      if (const double by_entry = s.by_entries()[k]; by_entry != 0.0)
        AddScaledRow(by_entry, u, columns, &gradient(first + k, 0));
  }
}

RowMatrix ContractEntries(const RowMatrix& gradient, int entries, const auto& weight_of) {
  RowMatrix sum = RowMatrix::Zero(entries, gradient.cols());
  for (int row = 0; row < gradient.rows(); ++row)
    sum.row(row % entries) += weight_of(row / entries, row % entries) * gradient.row(row);
  return sum;
}

}  // namespace

void AddMaterialColumns(const ClothModel& model, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x,
                        const Eigen::VectorXd& w, double h, RowMatrix& columns) {
  CHECK_GE(columns.cols(), kMaterialEntries);
  if (model.scene.stretch)
    std::visit(
        [&](const auto& law) {
          AddStretchColumns(law, model, material, weight, x.data(), w.data(), h, columns);
        },
        model.law.stretch);
  if (model.scene.bend)
    std::visit(
        [&](const auto& law) {
          AddBendColumns(law, model, material, weight, x.data(), w.data(), h, columns);
        },
        model.law.bend);
}

MaterialGradient MaterialGradient::Zero(const MaterialField& like, int m) {
  return {RowMatrix::Zero(kStretchEntries * like.stretch.size(), m),
          RowMatrix::Zero(kBendEntries * like.bend.size(), m)};
}

RowMatrix MaterialGradient::Contract(const MaterialField& weight) const {
  RowMatrix all(kMaterialEntries, stretch.cols());
  all << ContractEntries(stretch, kStretchEntries,
                         [&](int f, int k) { return weight.stretch_of(f).entries()[k]; }),
      ContractEntries(bend, kBendEntries,
                      [&](int e, int k) { return weight.bend_of(e).entries()[k]; });
  return all;
}

void AddMaterialGradient(const ClothModel& model, const MaterialField& material,
                         const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                         const RowMatrix& lambda, MaterialGradient& gradient) {
  CHECK_EQ(lambda.rows(), model.num_dofs());
  CHECK_EQ(gradient.stretch.cols(), lambda.cols());
  if (model.scene.stretch)
    std::visit(
        [&](const auto& law) {
          AddStretchGradient(law, model, material, x.data(), w.data(), h, lambda, gradient.stretch);
        },
        model.law.stretch);
  if (model.scene.bend)
    std::visit(
        [&](const auto& law) {
          AddBendGradient(law, model, material, x.data(), w.data(), h, lambda, gradient.bend);
        },
        model.law.bend);
}

}  // namespace drape
