// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/step_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/dynamics.h"
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

// Threads wait for one another for longer than they gain with fewer.
constexpr int kVerticesOfPart = 400;

bool HasBlocks(const BlockPattern& pattern, const ActivePairs& touches) {
  return std::all_of(touches.begin(), touches.end(), [&](const ActivePair& touch) {
    return pattern.HasAllBlocks(touch.pair.vertex);
  });
}

// These return λ·H·w.
template <class Law>
double AdjStretch(const Law& law, const ClothModel& model, const MaterialField& material,
                  const double* x, const double* w, double h, const double* lambda, double* adj_x,
                  double* gradient) {
  double stiffness_work = 0.0;
  const int stride = material.stretch.size() == 1 ? 0 : kStretchEntries;
  for (int f = 0; f < model.mesh.num_faces(); ++f) {
    const Face& face = model.mesh.faces[f];
    const StretchTable& table = material.stretch_of(f);
    const StretchAdjoint adjoint = AdjStretchStep(
        law, GatherColumns(face, x), table, GatherColumns(face, w), h, GatherColumns(face, lambda));
    ScatterColumns(face, adjoint.adj_F, adj_x);
    stiffness_work += face.area * adjoint.stiffness_work;
    double* entry = gradient + static_cast<std::ptrdiff_t>(stride) * f;
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m)
        entry[kStretchCols * r + m] +=
            face.area * adjoint.adj_stiffness[m] * adjoint.by_entry[r][m];
  }
  return stiffness_work;
}

template <class Law>
double AdjBend(const Law& law, const ClothModel& model, const MaterialField& material,
               const double* x, const double* w, double h, const double* lambda, double* adj_x,
               double* gradient) {
  double stiffness_work = 0.0;
  const int stride = material.bend.size() == 1 ? 0 : kBendEntries;
  for (int e = 0; e < model.mesh.num_hinges(); ++e) {
    const Hinge& hinge = model.mesh.hinges[e];
    const BendTable& table = material.bend_of(e);
    const HingeCorners corners = GatherCorners(hinge, x);
    const double theta = DihedralAngle(corners);
    const auto columns = law.Columns(hinge, Dual<1>(theta, 0));
    double of_hinge = 0.0;
    const BendAdjoint adjoint =
        AdjBendStep(law, hinge, table, columns, corners, GatherCorners(hinge, w), h,
                    GatherCorners(hinge, lambda), theta, &of_hinge);
    stiffness_work += of_hinge;
    for (int a = 0; a < 4; ++a) AddTo(adj_x, hinge.vertex[a], adjoint.adj_x.d[a]);
    BendTable by_entry;
    HingeStiffnessByTable(law, hinge, table, columns, by_entry.b);
    double* entry = gradient + static_cast<std::ptrdiff_t>(stride) * e;
    for (int k = 0; k < kBendEntries; ++k) entry[k] += adjoint.adj_kappa * by_entry.entries()[k];
  }
  return stiffness_work;
}

}  // namespace

void AddMaterialColumns(const ClothModel& model, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x,
                        const Eigen::VectorXd& w, double h, RowMatrix& columns) {
  CHECK_GE(columns.cols(), kMaterialEntries);
  const DampedVelocity damped(material, w, h);
  VisitLaws(
      model,
      [&](const auto& law) {
        AddStretchColumns(law, model, material, weight, x.data(), damped.data(), h, columns);
      },
      [&](const auto& law) {
        AddBendColumns(law, model, material, weight, x.data(), damped.data(), h, columns);
      });
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
  const DampedVelocity damped(material, w, h);
  VisitLaws(
      model,
      [&](const auto& law) {
        AddStretchGradient(law, model, material, x.data(), damped.data(), h, lambda,
                           gradient.stretch);
      },
      [&](const auto& law) {
        AddBendGradient(law, model, material, x.data(), damped.data(), h, lambda, gradient.bend);
      });
}

StepSolver::StepSolver(const std::shared_ptr<const ClothModel>& model)
    : StepSolver(model, MakeLinearSolver(model->pattern)) {}

StepSolver::StepSolver(std::shared_ptr<const ClothModel> model,
                       std::unique_ptr<LinearSolver> linear)
    : model_(std::move(model)),
      linear_(std::move(linear)),
      matrix_(model_->pattern),
      derivative_(model_->pattern) {
  if (HasSelfContact(model_->scene))
    self_ = std::make_unique<SurfaceContact>(MakeSelfContact(*model_));
}

StepSolver StepSolver::Clone() const {
  StepSolver clone(model_, linear_->Clone());
  clone.SetThreads(threads_);
  return clone;
}

void StepSolver::SetThreads(int threads) {
  const int parts = std::clamp(model_->mesh.num_vertices() / kVerticesOfPart, 1, threads);
  if (parts == 1)
    parts_.clear();
  else if (parts != static_cast<int>(parts_.size()))
    parts_ = SplitAssembly(model_->mesh, parts);
  threads_ = threads;
  linear_->SetThreads(threads);
  if (wide_) wide_->linear->SetThreads(threads);
}

LinearSolver& StepSolver::linear() {
  if (!wide_) return *linear_;
  wide_->linear->CancelLike(*linear_);
  return *wide_->linear;
}

void StepSolver::Forget() {
  if (!wide_) return;
  wide_.reset();
  MakeMatrices();
}

void StepSolver::MakeMatrices() {
  matrix_ = BlockMatrix(wide_model().pattern);
  derivative_ = BlockMatrix(wide_model().pattern);
}

void StepSolver::Widen(const Eigen::VectorXd& x) {
  if (!self_ || !x.allFinite()) return;
  if (HasBlocks(wide_model().pattern, self_->FindActivePairs(x))) return;
  auto model = std::make_shared<ClothModel>(*model_);
  model->pattern = AddGroups(model_->pattern, self_->ListNear(x));
  std::unique_ptr<LinearSolver> linear = linear_->Adapt(model->pattern);
  linear->SetThreads(threads_);
  wide_ = std::make_unique<Wide>(Wide{std::move(model), std::move(linear)});
  MakeMatrices();
}

bool StepSolver::Factor(const MaterialField& material, const Eigen::VectorXd& x, double h,
                        const Eigen::VectorXd* v) {
  Widen(x);
  AssembleStep(wide_model(), material, x, h, force_, matrix_, self_.get(), parts_);
  if (material.dynamics.air_drag != 0.0) {
    CHECK(v != nullptr) << "drag of air needs the velocity before the step";
    AddAirStep(wide_model(), material, x, *v, h, force_, matrix_);
  }
  return linear().Factor(matrix_);
}

const BlockMatrix& StepSolver::StepDerivative(const MaterialField& material,
                                              const Eigen::VectorXd& x, const Eigen::VectorXd& w,
                                              double h) {
  Widen(x);
  AssembleStepDerivative(wide_model(), material, x, w, h, derivative_, self_.get(), parts_);
  return derivative_;
}

double AdjStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
               const Eigen::VectorXd& w, double h, const RowMatrix& lambda, RowMatrix& adj_x,
               MaterialGradient& gradient) {
  CHECK_EQ(lambda.size(), model.num_dofs());
  CHECK_EQ(adj_x.size(), model.num_dofs());
  CHECK_EQ(gradient.stretch.cols(), 1);
  const DampedVelocity damped(material, w, h);
  double stiffness_work = 0.0;
  VisitLaws(
      model,
      [&](const auto& law) {
        stiffness_work += AdjStretch(law, model, material, x.data(), damped.data(), h,
                                     lambda.data(), adj_x.data(), gradient.stretch.data());
      },
      [&](const auto& law) {
        stiffness_work += AdjBend(law, model, material, x.data(), damped.data(), h, lambda.data(),
                                  adj_x.data(), gradient.bend.data());
      });
  for (int i : model.held)
    adj_x.middleRows<3>(3 * i) -= h * model.scene.handles->stiffness * lambda.middleRows<3>(3 * i);
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      adj_x.middleRows<3>(3 * i) +=
          ContactStepDerivative(*model.scene.contact, model.vertex_area[i], x.segment<3>(3 * i),
                                w.segment<3>(3 * i), h)
              .transpose() *
          lambda.middleRows<3>(3 * i);
  return stiffness_work / damped.factor();
}

}  // namespace drape
