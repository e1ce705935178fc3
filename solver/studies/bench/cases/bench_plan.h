// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "physics/material/material_io.h"

namespace drape {

// What drape_bench measures: one run for each setting in the product of some axes.

enum class BenchWork {
  kForward,   // a drape
  kGradient,  // a drape and the gradient of one loss by the material
  kJacobian,  // a drape and the Jacobian of its outline by the material
  kFit        // a material from silhouettes
};
// "forward", "gradient", "jacobian" or "fit". Throws InputError for any other.
BenchWork ParseBenchWork(const std::string& text);
const char* ToString(BenchWork work);

// One setting; the members of BenchAxes are lists of the same.
struct BenchSetting {
  std::string material;               // ReadMaterial
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

// Names and values of a setting's axes in the order of BenchSetting, as in runs.csv:
// a material by the stem of its file.
std::vector<std::pair<std::string, std::string>> ListAxes(const BenchSetting& setting);

// One line that tells a run from all others, whatever the order of the axes' values.
std::string CheckpointKey(BenchWork work, const BenchSetting& setting);

// "disc:600 hybrid h=0.1": the axes that the run has and of which `varied` has several values.
std::string MakeLabel(const BenchSetting& setting, const BenchAxes& varied);
// The mark of a run in a chart, "hybrid cuda": its method (model, integrator, mode, backend) as
// far as the axes vary it, or its integrator.
std::string MethodName(const BenchSetting& setting, const BenchAxes& axes);

// Whether the setting is of a model that only fits have.
bool IsDistribution(const BenchSetting& setting);

// The product; the first axis varies slowest. Axes that a run does not have (the mode of a forward
// run, the draws of a table, the batch of one thread) count with their first value only. Throws
// InputError for an axis without a value, a value that no run can have, or one that is given
// twice.
std::vector<BenchSetting> ListRuns(BenchWork work, const BenchAxes& axes);

}  // namespace drape
