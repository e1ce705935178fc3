// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/linalg/linear_solver.h"
#include "physics/material/material.h"

namespace drape {

// Derivatives of the step force g(x; w) = h·f(x) − h²·H(x)·w of assembly.h by the material tables
// [MODEL, M40].

// columns += ∂g/∂entry · weight for the 39 table entries of all elements at once, shape [3V, 39]
// (24 stretch entries row-major, then 15 bend entries); further columns are left unchanged.
// `weight` holds a number for each entry: ones for the derivative by the entry itself, the material
// for that by its logarithm, any field for a directional derivative.
void AddMaterialColumns(const ClothModel& model, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x,
                        const Eigen::VectorXd& w, double h, RowMatrix& columns);

// Gradients of m scalars by each table entry of a material field of one table for the whole cloth
// or one for each element.
struct MaterialGradient {
  RowMatrix stretch;  // [24·(1 or F), m]
  RowMatrix bend;     // [15·(1 or E), m]

  static MaterialGradient Zero(const MaterialField& like, int m);
  // Σ entry gradient × weight over all elements, shape [39, m], in the order of the columns of
  // AddMaterialColumns.
  RowMatrix Contract(const MaterialField& weight) const;
};

// gradient += (∂g/∂entry)ᵀ·lambda, the adjoint of AddMaterialColumns entry by entry; lambda has
// shape [3V, m].
void AddMaterialGradient(const ClothModel& model, const MaterialField& material,
                         const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                         const RowMatrix& lambda, MaterialGradient& gradient);

// The workspace of one thread for the steps of one model [MODEL, M30]. Where the cloth touches
// itself, in a scene that has this contact, the pattern of the matrices is widened by the pairs
// that touch or soon may; it stays so until Forget().
class StepSolver {
 public:
  explicit StepSolver(const std::shared_ptr<const ClothModel>& model);
  // Uses `linear` instead of MakeLinearSolver's.
  StepSolver(std::shared_ptr<const ClothModel> model, std::unique_ptr<LinearSolver> linear);
  // Returns a solver for another thread, which shares the symbolic analysis.
  StepSolver Clone() const;
  // The threads of one assembly and one factorisation (LinearSolver::SetThreads), also of widened
  // patterns.
  void SetThreads(int threads);
  int threads() const { return threads_; }
  // The parts of the mesh, one a thread; empty for one thread.
  const AssemblyParts& parts() const { return parts_; }

  const ClothModel& model() const { return *model_; }
  // The model with the pattern of the present matrices. Widen can end the life of
  // both.
  const ClothModel& wide_model() const { return wide_ ? *wide_->model : *model_; }
  LinearSolver& linear();
  // The solver of the model's own pattern, for Interruptible: linear() is cancelled as it is.
  LinearSolver& own_linear() { return *linear_; }

  // Contact of the cloth with itself; null if the scene has none.
  SurfaceContact* self_contact() { return self_.get(); }
  // Goes back to the model's own pattern, so that nothing depends on what was solved before.
  void Forget();

  // Factors A(x); force() is f(x) afterwards, with the push of the wind where there is drag of air:
  // it depends on v, the velocity before the step [m/s], shape [3V], which may be null otherwise.
  // Returns false when A is not positive definite.
  [[nodiscard]] bool Factor(const MaterialField& material, const Eigen::VectorXd& x, double h,
                            const Eigen::VectorXd* v = nullptr);
  const Eigen::VectorXd& force() const { return force_; }
  // Widens the pattern by the pairs of the cloth that touch at x, as Factor and StepDerivative do.
  void Widen(const Eigen::VectorXd& x);
  // Assembles ∂g/∂x with w held.
  const BlockMatrix& StepDerivative(const MaterialField& material, const Eigen::VectorXd& x,
                                    const Eigen::VectorXd& w, double h);

 private:
  struct Wide {
    std::shared_ptr<const ClothModel> model;
    std::unique_ptr<LinearSolver> linear;
  };
  void MakeMatrices();

  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<LinearSolver> linear_;
  int threads_ = 1;
  AssemblyParts parts_;
  std::unique_ptr<SurfaceContact> self_;
  std::unique_ptr<Wide> wide_;
  Eigen::VectorXd force_;
  BlockMatrix matrix_, derivative_;
};

// Adjoint of the step force g(x; w) of assembly.h for one λ, shape [3V, 1], element by element: no
// matrix is assembled, and geometry and law are evaluated once for both results [MODEL, M42].
//   adj_x += (∂g/∂x)ᵀ·λ with w held, shape [3V, 1];  gradient += (∂g/∂entry)ᵀ·λ, one column.
// Returns λ·H·w of the elements. For many λ, AssembleStepDerivative with
// AddTransposeMultiply and AddMaterialGradient costs less.
double AdjStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
               const Eigen::VectorXd& w, double h, const RowMatrix& lambda, RowMatrix& adj_x,
               MaterialGradient& gradient);

}  // namespace drape
