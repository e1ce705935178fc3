// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_input.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "cuda/make_backend.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

NegativeEntries NegativeEntryPolicy(const FitJob& job) {
  return job.law == "reference" || job.floor > 0.0 ? NegativeEntries::kWarn
                                                   : NegativeEntries::kReject;
}

// Raises the entries of a column (stride between them) to share · the largest; returns how many.
int RaiseToFloor(double* entries, int count, int stride, double share) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i) largest = std::max(largest, entries[i * stride]);
  int raised = 0;
  for (int i = 0; i < count; ++i) {
    double& entry = entries[i * stride];
    if (entry >= share * largest) continue;
    entry = share * largest;
    ++raised;
  }
  return raised;
}

int RaiseToFloor(MaterialField& field, double share) {
  int raised = 0;
  for (int c = 0; c < kStretchCols; ++c)
    raised += RaiseToFloor(&field.stretch[0].c[0][c], kStretchRows, kStretchCols, share);
  for (auto& row : field.bend[0].b) raised += RaiseToFloor(row, kBendCols, 1, share);
  return raised;
}

std::vector<Observation> ReadObservations(const FitJob& job) {
  const ObservationOptions options{ParseCameraKind(job.camera), ParseCentreMode(job.centre),
                                   job.fit.angles};
  std::vector<Observation> targets;
  for (const std::string& image : job.images)
    targets.push_back(ReadImageObservation(image, options));
  for (const Capture& capture : job.captures)
    targets.push_back(ReadCaptureObservation(capture, job.targets, options));
  return targets;
}

void RequireDistinctNames(const std::vector<Observation>& targets) {
  std::set<std::string> names;
  for (const Observation& target : targets)
    if (!names.insert(target.name).second)
      throw InputError(target.file, "a second image of the name '" + target.name +
                                        "', expected distinct names: they name the output files");
}

void CheckModel(const FitJob& job) {
  const bool entries = job.fit.parameters == ParameterTying::kEntries;
  if (job.tables == TableForm::kLinear && entries)
    throw InputError("num_parameters",
                     "39 with tables linear, expected 1, 2, 3 or 7: they would bend them");
  if (job.tables == TableForm::kIsotropic && job.fit.parameters != ParameterTying::kScales &&
      job.fit.parameters != ParameterTying::kBendScale)
    throw InputError("num_parameters",
                     "more than 2 with tables isotropic, expected 1 or 2: they would "
                     "tell directions apart");
  if (job.model == "homogeneous") return;
  if (job.model != "heterogeneous" && job.model != "bayes" && job.model != "bdp")
    throw InputError("model", "'" + job.model + "', expected homo, heter, bayes or bdp");
  if (job.num_targets() == 0)
    throw InputError("model", job.model + " without images, expected some");
  if (job.fit.integrator != SolveMode::kStatic)
    throw InputError("solve", "dynamic with model " + job.model + ", expected static");
  if (job.model == "bdp" && job.fit.parameters != ParameterTying::kEntries)
    throw InputError("num_parameters",
                     "fewer than 39 with model bdp, expected 39: it learns a mean "
                     "and a deviation of each entry");
  const std::vector<int>& specimen = job.posterior.specimen;
  if (specimen.empty()) return;
  if (specimen.size() != job.num_targets())
    throw InputError("specimens", "found " + std::to_string(specimen.size()) +
                                      " numbers, expected one for each of the " +
                                      std::to_string(job.num_targets()) + " images");
  const std::set<int> names(specimen.begin(), specimen.end());
  if (*names.begin() != 1 || *names.rbegin() != static_cast<int>(names.size()))
    throw InputError("specimens", "expected all numbers from 1 to that of the last specimen");
}

std::vector<std::string> Expand(const std::string& text, const std::string& what,
                                const std::set<std::string>& extensions,
                                const std::string& expected) {
  std::vector<std::string> files;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    std::vector<std::string> found;
    if (fs::is_regular_file(item)) {  // its name may look like a pattern
      found.push_back(item);
    } else if (fs::is_directory(item)) {
      for (const fs::directory_entry& entry : fs::directory_iterator(item))
        if (extensions.contains(entry.path().extension())) found.push_back(entry.path());
      std::sort(found.begin(), found.end());
    } else {
      glob_t matches = {};
      if (glob(item.c_str(), 0, nullptr, &matches) == 0)
        found.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
      globfree(&matches);
    }
    if (found.empty())
      throw InputError(what, "'" + item + "' matches nothing, expected " + expected);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

}  // namespace

LoadedJob LoadJob(const FitJob& job) {
  if (job.num_targets() == 0 && job.tests.empty())
    throw InputError("images", "none, and no tests, expected at least one silhouette or test");
  if (!job.images.empty() && !job.captures.empty())
    throw InputError("images", "found some beside captures of a data set, expected one of both");
  CheckModel(job);
  LoadedJob loaded;
  loaded.fit = job.fit;
  loaded.notes = job.notes;
  std::vector<LabMeasurement> tests;
  std::set<std::string> names;
  for (const std::string& file : job.tests) {
    tests.push_back(ReadLabMeasurement(file));
    if (!names.insert(tests.back().name).second)
      throw InputError(
          file, "a second test of the name '" + tests.back().name + "', expected distinct names");
  }
  loaded.problem.targets = ReadObservations(job);
  RequireDistinctNames(loaded.problem.targets);
  const Material start = ReadMaterial(job.material, {NegativeEntryPolicy(job)});
  loaded.problem.material = start.field;
  if (job.density > 0.0) loaded.problem.material.density = job.density;
  const int raised = RaiseToFloor(loaded.problem.material, job.floor);
  if (raised > 0) {
    std::ostringstream note;
    note << raised << " start entries of " << job.material << " were raised to " << job.floor
         << " of their column's largest";
    loaded.notes.push_back(note.str());
  }
  loaded.problem.material = InForm(std::move(loaded.problem.material), job.tables);
  if (!job.truth.empty())
    loaded.truth =
        std::make_unique<MaterialField>(ReadMaterial(job.truth, {NegativeEntries::kWarn}).field);
  if (!tests.empty())
    loaded.tests = std::make_unique<StripResiduals>(std::move(tests), MakeLaw(job.law));
  if (loaded.problem.targets.empty()) return loaded;
  const auto model = [&](const std::string& mesh) {
    return std::make_shared<const ClothModel>(ParseMeshSpec(mesh), CusickScene(), MakeLaw(job.law));
  };
  loaded.fine_model = model(job.mesh);
  if (loaded.fine_model->held.size() == static_cast<size_t>(loaded.fine_model->mesh.num_vertices()))
    throw InputError(job.mesh,
                     "found all vertices on the support of radius 0.09 m, expected a cloth "
                     "that hangs over it");
  loaded.fine = MakeBackend(job.backend, loaded.fine_model, job.threads, &loaded.backend_choice);
  loaded.coarse = MakeBackend(job.backend, model(job.coarse_mesh), job.threads);
  loaded.problem.fine = loaded.fine.get();
  loaded.problem.coarse = loaded.coarse.get();
  return loaded;
}

std::string CheckpointKey(const FitJob& job, const LoadedJob& loaded) {
  const FitProblem& problem = loaded.problem;
  nlohmann::json id = {{"mesh", job.mesh},
                       {"coarse_mesh", job.coarse_mesh},
                       {"material", job.material},
                       {"law", job.law},
                       {"camera", job.camera},
                       {"centre", job.centre},
                       {"min_relative_stiffness", job.floor},
                       {"stretch", job.fit.grid.stretch},
                       {"bend", job.fit.grid.bend},
                       {"lifts", job.fit.grid.lifts},
                       {"initial_time_step", job.fit.grid.h},
                       {"initial_steps", job.fit.grid.steps},
                       {"candidates_per_round", job.fit.keep},
                       {"iterations", job.fit.iterations},
                       {"num_parameters", static_cast<int>(job.fit.parameters)},
                       {"prior_sigma", job.fit.prior_sigma},
                       {"sigma_px", job.fit.sigma_px},
                       {"angles", job.fit.angles},
                       {"settle_time_step", job.fit.settle_h},
                       {"settle_steps", job.fit.settle_steps},
                       {"initial_damping", job.fit.initial_damping},
                       {"newton_iterations", job.fit.newton_iterations},
                       {"max_outline_change", job.fit.max_outline_change},
                       {"max_jump", job.fit.max_jump},
                       {"warm_restart", job.fit.warm_restart},
                       {"solve", static_cast<int>(job.fit.integrator)},
                       {"density", problem.material.density},
                       {"stretch_table", problem.material.stretch[0].c},
                       {"bend_table", problem.material.bend[0].b}};
  for (const Observation& target : problem.targets)
    id["images"].push_back(
        {target.name, std::vector<double>(target.radius.begin(), target.radius.end())});
  for (const Capture& c : job.captures)
    id["data"].push_back({c.fabric, c.sample, c.capture, ToString(job.targets)});
  if (!loaded.tests) return id.dump();
  for (const LabMeasurement& test : loaded.tests->tests()) {
    nlohmann::json points;
    for (const LabPoint& point : test.points) points.push_back({point.set, point.reading});
    id["tests"].push_back({test.name, ToString(test.kind), test.direction, test.length, test.width,
                           test.sigma, points});
  }
  return id.dump();
}

std::vector<std::string> ExpandImages(const std::string& text) {
  return Expand(text, "images", {".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG"},
                "an image, a folder with .jpg or .png files, or a pattern");
}

std::vector<std::string> ExpandTests(const std::string& text) {
  return Expand(text, "tests", {".json", ".JSON"},
                "a test file, a folder with .json files, or a pattern");
}

}  // namespace drape
