// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <atomic>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "losses/readout/readouts.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "solver/forward/settle.h"

namespace drape {

// What drape_bench measures: one run for each setting in the product of some axes.

enum class BenchWork {
  kForward,   // a drape
  kGradient,  // a drape and the gradient of one loss by the material
  kJacobian,  // a drape and the Jacobian of its outline by the material
  kFit        // a material from silhouettes
};
constexpr auto EnumNames(BenchWork) {
  return MakeNames<BenchWork>({{BenchWork::kForward, "forward"},
                               {BenchWork::kGradient, "gradient"},
                               {BenchWork::kJacobian, "jacobian"},
                               {BenchWork::kFit, "fit"}});
}

// One setting; the members of BenchAxes are lists of the same.
struct BenchSetting {
  std::string material = {};          // ReadMaterial
  std::string law = "smooth";         // MakeLaw
  std::string model = "homogeneous";  // one table for the cloth; "heterogeneous_modes": smooth
                                      // fields over it; "heterogeneous_elements": one a face and
                                      // hinge, all alike; of fits also "bdp" and "bayes"
  int draws = 16;                     // of a fit of model bdp or bayes
  std::string mesh = "disc:600";      // ParseMeshSpec
  std::string integrator = "hybrid";  // dynamic: time steps; hybrid: then Newton; static: from
                                      // a drape that fell on a coarse mesh, 20 steps, then Newton
  double h = 0.1;                     // time step [s]
  double relax_time = 10.0;           // simulated [s]
  double tolerance = 1e-9;            // of Newton: ‖f‖ by weight
  std::string mode = "adjoint";       // of the derivative: adjoint or tangent
  std::string backend = "cpu";        // MakeBackend
  int threads = 1;
  int batch = 1;  // drapes at once

  int steps() const;  // relax_time by h
};

struct BenchAxes {
  std::vector<std::string> material = {kBuiltInName}, law = {"smooth"}, model = {"homogeneous"},
                           mesh = {"disc:600"}, integrator = {"hybrid"};
  std::vector<int> draws = {16};
  std::vector<double> h = {0.1}, relax_time = {10.0}, tolerance = {1e-9};
  std::vector<std::string> mode = {"adjoint"}, backend = {"cpu"};
  std::vector<int> threads = {1}, batch = {1};
};

// The axes of a run by the names of their options, in the order of BenchSetting, a file by its name
// without the folder: {"material": "wool", "law": "smooth", …}. A run without samples of a
// posterior has no "draws", one of a single thread no "batch".
nlohmann::ordered_json ListAxes(const BenchSetting& setting);

// One line that tells a run from all others, whatever the values of the axes beside its own:
// "forward material=wool mesh=disc:300", with the axes that differ from those of BenchSetting().
std::string RunName(BenchWork work, const BenchSetting& setting);

// Whether the setting is of a model that only fits have.
bool IsDistribution(const BenchSetting& setting);

// The product; the first axis varies slowest. Axes that a run does not have (the mode of a forward
// run, the draws of a table, the batch of one thread) do not multiply it. Throws InputError for two
// runs of one name: a value that is given twice, or two files of one name.
std::vector<BenchSetting> ListRuns(BenchWork work, const BenchAxes& axes);

// The cloth of a mesh in the drape test, as the law takes it.
std::shared_ptr<const ClothModel> MakeBenchModel(const std::string& mesh, const Law& law);

// Times of equal runs [s].
struct RunTimes {
  std::vector<double> wall;
  std::vector<double> cpu;  // processor time of all threads
};

// Repeats `run` at most so many times, and no more once so many seconds of wall clock are spent.
RunTimes TimeRuns(const std::function<void()>& run, int repeats, double seconds);

// The median, and slowest − fastest, of at least one time.
double MedianTime(std::vector<double> times);
double TimeSpread(const std::vector<double>& times);

// Wall clock [s], for differences.
double WallSeconds();

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
