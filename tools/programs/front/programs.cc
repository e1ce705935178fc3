// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/programs.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "physics/util/errors.h"
#include "tools/programs/equilibria/equilibria_tool.h"
#include "tools/programs/fit/fit_tool.h"
#include "tools/programs/garment/garment_tool.h"
#include "tools/programs/measure/metrics/metrics_tool.h"
#include "tools/programs/predict/predict_tool.h"
#include "tools/programs/results/export/export_tool.h"
#include "tools/programs/results/report/report_tool.h"
#include "tools/programs/simulate/simulate_tool.h"
#include "tools/programs/studies/bench/bench_tool.h"
#include "tools/programs/studies/bench/speed_tool.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr char kReport[] = "from a photograph to a report";
constexpr char kDrapes[] = "drapes and garments";
constexpr char kFabrics[] = "many fabrics and models";
constexpr char kScene[] = "your own scene, and the solver";
constexpr char kStudies[] = "studies of accuracy and cost";

constexpr Program kPrograms[] = {
    {"photo", kReport, "find the outline of a drape in a photograph", nullptr},
    {"fit", kReport, "estimate the stiffness of a fabric from silhouettes or tests", FitMain},
    {"predict", kReport, "predict how further samples of a fabric drape", PredictMain},
    {"report", kReport, "show results in one HTML page", ReportMain},
    {"export", kReport, "write a fitted fabric for other simulators and for statistics",
     ExportMain},
    {"simulate", kDrapes, "drape a fabric of known stiffness", SimulateMain},
    {"metrics", kDrapes, "measure and compare drapes: coefficient, folds, outline", MetricsMain},
    {"equilibria", kDrapes, "find all stable drapes of a fabric", EquilibriaMain},
    {"garment", kDrapes, "dress a moving body in a garment of a fitted fabric", GarmentMain},
    {"space", kFabrics, "measure distances between fabrics, find outliers, recognise fabrics",
     SpaceMain},
    {"compare", kFabrics, "compare material models on drapes that no fit has seen", CompareMain},
    {"check", kScene, "check forces, energies and derivatives of a scene", CheckMain},
    {"bench", kStudies, "measure cost and error over lists of settings", BenchMain},
    {"speed", kStudies, "time a simulation step beside published times", SpeedMain},
    {"stability", kStudies, "map where solvers of a drape succeed and fail", StabilityMain},
    {"gradients", kStudies, "show where gradients of a drape fail", GradientsMain},
    {"compare_optimisers", kStudies, "compare optimisers at equal cost, start and budget",
     CompareOptimisersMain}};

}  // namespace

std::span<const Program> Programs() { return kPrograms; }

const Program* FindProgram(std::string verb) {
  std::replace(verb.begin(), verb.end(), '-', '_');
  for (const Program& program : kPrograms)
    if (verb == program.verb) return &program;
  return nullptr;
}

std::string ProgramFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("/proc/self/exe", "cannot be read: " + error.message());
  return self.parent_path();
}

std::string ProgramPath(const std::string& folder, const std::string& verb) {
  return folder + "/drape_" + verb;
}

bool HasProgram(const std::string& folder, const std::string& verb) {
  return access(ProgramPath(folder, verb).c_str(), X_OK) == 0;
}

}  // namespace drape
