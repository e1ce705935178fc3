// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "physics/util/options/enum_names.h"

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

}  // namespace drape
