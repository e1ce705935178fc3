// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "physics/cloth/state.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/readout.h"
#include "solver/forward/settle.h"
#include "solver/studies/bench/cases/bench_plan.h"

namespace drape {

// What all runs of a benchmark have in common: the drape test of BS 5058 from one seed shape, which
// holds the branch.
struct BenchProblem {
  StartShape seed;
  std::string coarse_mesh = "disc:300";  // on which a static run relaxes before Newton
};

// What is compared with a reference. The outline is r(θ) [m] at kBranchAngles angles. Derivatives
// are by the logarithms of the 39 table entries, each of the whole cloth.
struct BenchDrape {
  std::string status = {};        // "ok", or why there is none
  Eigen::VectorXd x = {};         // [m], shape [3V]
  Eigen::VectorXd outline = {};   // [m], shape [kBranchAngles]
  Eigen::VectorXd gradient = {};  // of the loss, shape [39]; empty without
  RowMatrix jacobian = {};        // of the outline [px], shape [kBenchAngles, 39]; empty without
};

inline constexpr int kBenchAngles = 90;           // of the outline that is differentiated
inline constexpr double kBenchLossRadius = 0.12;  // [m]; the loss is ½ Σ (r_k − this)² [px²]

// How far a shape is from rest.
struct RestMeasure {
  double residual = 0.0;  // ForceResidual
  double drift = 0.0;     // of a nudged drape [m]; infinite where it does not come to rest

  bool IsAtRest() const { return residual <= kAtRestResidual && drift <= kAtRestDrift; }
};

// The model, material and backends of one setting, made before the clock starts.
class SettingSolver {
 public:
  // Throws InputError for a mesh, a material or a backend that cannot be had.
  SettingSolver(const BenchSetting& setting, const BenchProblem& problem,
                const std::atomic<bool>* cancel);

  const Mesh& mesh() const { return backend_->model().mesh; }
  // The work of one run, the outline included: `batch` times the same at once. Not of a fit.
  BenchDrape Run(BenchWork work);
  // Whether a shape x, shape [3V], is at rest (kAtRestResidual, kAtRestDrift): the forces that
  // remain, and how far it comes to rest when it is nudged.
  RestMeasure MeasureRest(const Eigen::VectorXd& x);

 private:
  bool is_dynamic() const { return setting_.integrator == "dynamic"; }
  State Seed(const Mesh& mesh) const;
  SettleOptions Settling() const;
  // A drape that fell on the coarse mesh, on this one; its status is the steps'.
  RolloutStatus StartFromCoarse(State* start);
  BenchDrape DrapeAlone();
  // Derivatives of a dynamic setting repeat the steps; others follow DrapeAlone.
  BenchDrape StepTangents();
  // The gradient of the loss, or the Jacobian of the outline.
  BenchDrape StepAdjoint(bool of_loss);
  // Reads the outline at x, whose derivatives by the table entries are dx. Returns false where it
  // cannot be read.
  bool AddReadout(const Eigen::VectorXd& x, const RowMatrix& dx, BenchDrape* drape);
  void AddTangents(const State& rest, BenchDrape* drape);
  void AddAdjoint(const State& rest, bool of_loss, BenchDrape* drape);
  BenchDrape Differentiate(BenchWork work);
  std::vector<RolloutInput> Batch(const State& state) const;
  RolloutOptions Steps() const;
  BenchDrape Seen(const std::string& status, Eigen::VectorXd x) const;

  BenchSetting setting_;
  BenchProblem problem_;
  const std::atomic<bool>* cancel_;
  MaterialField material_, coarse_material_;
  std::unique_ptr<Backend> backend_, coarse_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> from_coarse_;
  std::unique_ptr<Readout> readout_;
};

}  // namespace drape
