// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_input.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <climits>
#include <cmath>
#include <future>
#include <set>
#include <string_view>
#include <utility>

#include "cuda/make_backend.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/pool_start.h"
#include "solver/forward/settle.h"
#include "solver/job/fit_cloths.h"
#include "solver/posterior/space/space_io.h"

namespace drape {
namespace {

std::vector<Observation> ReadObservations(const FitData& data, const ObservationOptions& options) {
  std::vector<Observation> observations;
  for (const std::string& image : data.images)
    observations.push_back(ReadImageObservation(image, options));
  for (const Capture& capture : data.captures)
    observations.push_back(ReadCaptureObservation(capture, data.source, options));
  return observations;
}

void CheckCamera(const CameraInput& camera, const FitData& data) {
  const bool is_given =
      camera.gives_scale() || camera.gives_camera() || camera.width != 0 || camera.height != 0;
  if (!data.captures.empty() && is_given)
    throw InputError("camera_file, camera_scale, image_width_mm, dpi, camera_width, camera_height",
                     "found beside the published data set, whose scale and size are known");
}

std::vector<std::string> ListNotes(const std::vector<Observation>& observations) {
  std::vector<std::string> notes;
  for (const Observation& observation : observations) {
    const auto add = [&](const std::vector<std::string>& more) {
      for (const std::string& note : more) notes.push_back(observation.name + ": " + note);
    };
    if (observation.photograph) add(observation.photograph->warnings);
    add(observation.quality.notes);
  }
  return notes;
}

// Leaves out images with the outline of an image before, to the last bit: a drape counts once.
// Whoever names specimens has looked at them.
void DropRepeats(FitProblem& problem, std::vector<std::string>* notes) {
  if (!problem.specimens.empty()) return;
  std::vector<Observation> kept;
  for (Observation& observation : problem.observations) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Observation& before) {
      return before.radius == observation.radius;
    });
    if (same == kept.end())
      kept.push_back(std::move(observation));
    else
      notes->push_back(observation.name + ": the same outline as " + same->name +
                       ": it counts once");
  }
  problem.observations = std::move(kept);
}

// The warp is known in all images or in none; strips have it in their directions. Elements of a
// field are in one place of the cloth in all images.
void PrepareWarp(FitModel model, bool with_strips, FitProblem& problem,
                 std::vector<std::string>* notes) {
  std::vector<Observation>& observations = problem.observations;
  if (observations.empty()) return;
  problem.mirrors = model != FitModel::kHeterogeneous || observations.size() == 1;
  const Observation first = observations.front();
  const bool known = first.warp.has_value();
  for (Observation& observation : observations) {
    if (observation.warp.has_value() != known)
      throw InputError(observation.file, std::string("the warp is ") +
                                             (known ? "not known" : "known") + ", expected as in " +
                                             first.file);
    const ClothPose pose = {
        first.pose.degrees + observation.warp.value_or(0) - first.warp.value_or(0),
        first.pose.mirrored};
    if (problem.mirrors || observation.pose == pose) continue;
    observation.pose = pose;
    observation.radius = observation.MeasureRadius(int(observation.radius.size())).value();
  }
  if (known) return;
  if (with_strips)
    throw InputError("option 'warp'",
                     "found unknown beside lab_tests, whose strips are cut along warp or weft, "
                     "expected where the warp lies in the images");
  notes->push_back(
      "the warp is not known (--warp): results name a stiffer and a softer direction, one of which "
      "is taken to be up in every image");
}

std::vector<LabMeasurement> ReadAllMeasurements(const std::vector<std::string>& files) {
  std::vector<LabMeasurement> measurements;
  std::set<std::string> names;
  for (const std::string& file : files) {
    for (LabMeasurement& measurement : ReadLabMeasurements(file)) {
      if (!names.insert(measurement.name).second)
        throw InputError(file, "a second measurement of the name '" + measurement.name +
                                   "', expected distinct names");
      measurements.push_back(std::move(measurement));
    }
  }
  return measurements;
}

void CheckTableForm(TableForm form, ParameterTying parameters) {
  if (form == TableForm::kLinear && parameters == ParameterTying::kEntries)
    throw InputError("num_parameters",
                     "39 with table_form linear, expected 1, 2, 3 or 7, which keep tables linear");
  if (form == TableForm::kIsotropic && parameters != ParameterTying::kScales &&
      parameters != ParameterTying::kBendScale)
    throw InputError("num_parameters",
                     "more than 2 with table_form isotropic, expected 1 or 2, which keep tables "
                     "isotropic");
}

void CheckSpecimens(const std::vector<int>& specimens, std::size_t observations) {
  if (specimens.empty()) return;
  if (specimens.size() != observations)
    throw InputError("specimens", "found " + std::to_string(specimens.size()) +
                                      " numbers, expected one for each of the " +
                                      std::to_string(observations) + " images");
  const std::set<int> names(specimens.begin(), specimens.end());
  if (*names.begin() != 1 || *names.rbegin() != static_cast<int>(names.size()))
    throw InputError("specimens", "expected all numbers from 1 to that of the last specimen");
}

void CheckBdp(const FitSpec& spec) {
  if (spec.model == FitModel::kBdp && spec.stages.parameters != ParameterTying::kEntries)
    throw InputError("num_parameters",
                     "fewer than 39 with model bdp, expected 39: it estimates a mean and a "
                     "deviation of each entry");
}

void CheckModel(const FitSpec& spec, const FitData& data) {
  CheckTableForm(spec.table_form, spec.stages.parameters);
  if (!HasPosterior(spec.model) && !data.specimens.empty() && data.captures.empty())
    throw InputError("specimens", std::string("found some with model ") + ToString(spec.model) +
                                      ", expected none: only models bayes and bdp tell specimens "
                                      "apart");
  if (spec.contact.model != ContactModel::kNone &&
      spec.stages.residuals.solve_mode != SolveMode::kStatic)
    throw InputError("contact",
                     std::string("found ") + ToString(spec.contact.model) +
                         " with solve = dynamic, expected static: a step that an obstacle ends "
                         "has no derivative");
  if (spec.model == FitModel::kHomogeneous) return;
  const std::string name = ToString(spec.model);
  if (data.num_observations() == 0)
    throw InputError("model", name + " without images, expected some");
  if (spec.stages.residuals.solve_mode != SolveMode::kStatic)
    throw InputError("solve", "dynamic with model " + name + ", expected static");
  CheckBdp(spec);
  CheckSpecimens(data.specimens, data.num_observations());
}

// Prepares tables as a fit begins with them. density [kg/m²]: 0 keeps the density of the tables.
MaterialField PrepareStartTables(const FitSpec& spec, MaterialField start, double density) {
  if (density > 0.0) start.density = density;
  return InForm(std::move(start), spec.table_form);
}

MaterialField ReadStartTables(const FitSpec& spec, const std::string& file, double density,
                              std::vector<std::string>* notes) {
  Material start =
      ReadMaterial(file, ReadingPolicy(MakeLaw(spec.law), spec.min_relative_stiffness));
  notes->insert(notes->end(), start.warnings.begin(), start.warnings.end());
  return PrepareStartTables(spec, std::move(start.field), density);
}

// Checks the tables of a caller, which no reader of a file has checked.
void RequireStartTables(const FitSpec& spec, const MaterialField& start) {
  if (start.stretch.size() != 1 || start.bend.size() != 1)
    throw InputError("start", "expected one table of stretch and one of bend");
  if (spec.law == LawKind::kReference || spec.min_relative_stiffness > 0.0) return;
  const double* stretch = start.stretch[0].entries();
  if (*std::min_element(stretch, stretch + kStretchEntries) < 0.0)
    throw InputError("start", "found a negative stretch entry, expected none");
}

// The weighed density [kg/m²]: what the user says, or a file of tests; 0: neither.
double FindDensity(const FitData& data, const std::vector<LabMeasurement>& measurements,
                   std::vector<std::string>* notes) {
  constexpr double kAgree = 0.05;  // of two weighings
  double density = data.density;
  std::string from = "of option 'density'";
  for (const LabMeasurement& each : measurements) {
    if (each.density == 0.0 || each.density == density) continue;
    const std::string stated = Format("%s states %g g/m2", each.file.c_str(), 1e3 * each.density);
    if (density == 0.0) {
      density = each.density;
      from = "of " + each.file;
      notes->push_back("the mass of the fabric: " + stated);
    } else if (std::abs(each.density / density - 1.0) > kAgree) {
      notes->push_back(stated + Format(", but %g g/m2 ", 1e3 * density) + from + " is used");
      break;
    }
  }
  return density;
}

// Reads what a fit begins with and the tables that it is compared with.
void ReadAllStartTables(const FitSpec& spec, const FitData& data, double density, FitInput* input) {
  FitProblem& problem = input->problem;
  if (!data.ground_truth.empty())
    input->ground_truth = std::make_unique<MaterialField>(
        ReadMaterial(data.ground_truth, {NegativeEntries::kWarn}).field);
  problem.material = ReadStartTables(spec, data.material, density, &input->notes);
  input->start_name = data.material;
  if (spec.simpler_models && data.lab_measurements.empty())
    problem.simpler_models = SimplerModels({spec.table_form, spec.stages.parameters});
}

// Whether no table of the start is kept, so that other tables can start: all numbers of the form
// are fitted, or the two scales of linear tables, whose other numbers are those of pooled drapes.
bool FitsWholeTables(TableForm form, ParameterTying parameters) {
  return (form == TableForm::kGiven && parameters == ParameterTying::kEntries) ||
         (form == TableForm::kLinear &&
          (parameters == ParameterTying::kColumns || parameters == ParameterTying::kScales)) ||
         (form == TableForm::kIsotropic && parameters == ParameterTying::kScales);
}

// Lets images start from a pool, where there is one for their discs and what is fitted is not held
// by the start tables. Who gives guesses of a grid gets the grid.
void UsePool(const FitSpec& spec, FitInput* input) {
  FitProblem& problem = input->problem;
  const InitialGuessOptions& grid = spec.stages.grid;
  const InitialGuessOptions usual;
  const bool is_pooled =
      spec.start_pool && !problem.observations.empty() && !input->strips &&
      FitsWholeTables(spec.table_form, spec.stages.parameters) && spec.law == LawKind::kSmooth &&
      spec.contact.model == ContactModel::kNone &&
      spec.stages.residuals.solve_mode == SolveMode::kStatic && grid.stretch == usual.stretch &&
      grid.bend == usual.bend && grid.lifts == usual.lifts;
  const OutlinePool* pool = is_pooled ? FindBuiltInPool(input->discs) : nullptr;
  if (pool == nullptr) return;
  constexpr int kSettled = 2;  // for each that is fitted
  std::vector<MaterialField> tables = ListPooledTables(
      *pool, problem.observations, kSettled * spec.stages.candidates_per_round.front(),
      problem.material.density);
  if (tables.empty()) return;
  for (MaterialField& each : tables) each = InForm(std::move(each), spec.table_form);
  problem.is_pooled = true;
  problem.mirrors = false;
  problem.material = tables.front();
  problem.other_materials.assign(tables.begin() + 1, tables.end());
  problem.simpler_models.clear();
  if (spec.simpler_models && spec.stages.parameters == ParameterTying::kEntries)
    problem.simpler_models = {{TableForm::kLinear, ParameterTying::kColumns}};
}

// Where what is fitted shows stiffness over weight. A tensile test does not.
void NoteDensity(const std::vector<LabMeasurement>& measurements, FitInput* input) {
  const bool weighs =
      !input->problem.observations.empty() ||
      std::any_of(measurements.begin(), measurements.end(), [](const LabMeasurement& each) {
        return each.kind == LabMeasurementKind::kCantilever;
      });
  if (input->density_is_given || !weighs) return;
  input->notes.push_back(
      Format("the density, %g kg/m2, is that of the start tables, not a measurement: stiffnesses "
             "are in proportion to it, the bending length is not affected",
             input->problem.material.density));
}

// The population of fabrics about the tables of a fabric of that density [kg/m²].
std::shared_ptr<const FabricPrior> ReadPrior(const FitSpec& spec, double density) {
  if (spec.prior.empty()) return nullptr;
  if (spec.model != FitModel::kBayes)
    throw InputError("prior", std::string("found with model ") + ToString(spec.model) +
                                  ", expected bayes: it is the prior of a posterior");
  const SpacePrior space = ReadSpacePrior(spec.prior);
  if (space.frame.tying != spec.stages.parameters)
    throw InputError(spec.prior, std::string("is of fits with num_parameters ") +
                                     ToString(space.frame.tying) + ", expected that of this fit, " +
                                     ToString(spec.stages.parameters));
  FabricPrior prior{space.frame.Table(space.theta.mean, density),
                    space.theta.covariance.llt().matrixL()};
  return std::make_shared<const FabricPrior>(std::move(prior));
}

// The discs of the drapes that are fitted: those of the images and the options, or of the captures.
DrapeDiscs FitDiscs(const FitSpec& spec, const FitData& data) {
  std::vector<std::string> files = data.images;
  for (const std::string& image : data.images)
    files.push_back(spec.observation.camera.FileFor(image));
  const DrapeDiscs discs = FindDiscs(spec.observation.discs, files);
  if (!data.captures.empty() && discs != DrapeDiscs())
    throw InputError("option 'specimen' or 'support'",
                     "found " + ToString(discs) + " beside the published data set, expected its " +
                         ToString(DrapeDiscs()));
  return discs;
}

// The names of the images are to be those of output files: short and distinct.
void CheckNames(const std::vector<Observation>& observations) {
  constexpr std::size_t kLongest = NAME_MAX - std::string_view("start_.json").size();
  for (const Observation& observation : observations)
    if (observation.name.size() > kLongest)
      throw InputError(observation.file,
                       "found a name of " + std::to_string(observation.name.size()) +
                           " bytes, expected at most " + std::to_string(kLongest) +
                           ": it names the output files");
  std::set<std::string> names;
  for (const Observation& observation : observations)
    if (!names.insert(observation.name).second)
      throw InputError(observation.file,
                       "a second image of the name '" + observation.name +
                           "', expected distinct names: they name the output files");
}

}  // namespace

FitInput MakeFitInput(const FitSpec& spec, ObservedFabric fabric) {
  if (fabric.drapes.empty())
    throw InputError("observations", "found nothing, expected at least one silhouette");
  FitData data;
  for (const Observation& each : fabric.drapes) data.images.push_back(each.name);
  data.specimens = fabric.specimens;
  CheckModel(spec, data);
  FitInput input;
  input.discs = fabric.drapes.front().discs;
  for (const Observation& each : fabric.drapes) {
    if (each.radius.size() != spec.observation.angles)
      throw InputError(each.name,
                       Format("found an outline of %d angles, expected %d",
                              static_cast<int>(each.radius.size()), spec.observation.angles));
    if (each.discs != input.discs)
      throw InputError(each.name, "found " + ToString(each.discs) + ", expected the size of '" +
                                      fabric.drapes.front().name + "', " + ToString(input.discs));
  }
  FitProblem& problem = input.problem;
  problem.observations = std::move(fabric.drapes);
  problem.specimens = std::move(fabric.specimens);
  input.notes = ListNotes(problem.observations);
  DropRepeats(problem, &input.notes);
  PrepareWarp(spec.model, false, problem, &input.notes);
  input.density_is_given = fabric.density > 0.0;
  RequireStartTables(spec, fabric.start);
  RaiseSmallEntries(fabric.start, spec.min_relative_stiffness);
  problem.material = PrepareStartTables(spec, std::move(fabric.start), fabric.density);
  if (spec.simpler_models)
    problem.simpler_models = SimplerModels({spec.table_form, spec.stages.parameters});
  UsePool(spec, &input);
  NoteDensity({}, &input);
  input.prior = ReadPrior(spec, problem.material.density);
  MakeCloths(spec, nullptr, &input);
  return input;
}

namespace {

// An experiment as the observation of a fit.
Observation MakeExperimentObservation(Experiment experiment, const std::string& file) {
  Observation observation;
  observation.name = experiment.name;
  observation.file = file;
  observation.warp = 90;
  observation.experiment = std::make_shared<const Experiment>(std::move(experiment));
  return observation;
}

std::shared_ptr<const ClothModel> MakeModel(const Mesh& mesh, const Experiment& experiment,
                                            LawKind law) {
  auto model = std::make_shared<const ClothModel>(mesh, experiment.scene, MakeLaw(law));
  RequireThinCloth(*model);
  return model;
}

void CheckExperiment(const FitSpec& spec, const FitData& data) {
  if (data.num_observations() + data.lab_measurements.size() > 0)
    throw InputError("experiment",
                     "found one beside images, data or lab_tests, expected one of "
                     "them: its file has keys for what belongs to it");
  CheckTableForm(spec.table_form, spec.stages.parameters);
  CheckBdp(spec);
  if (spec.model == FitModel::kHeterogeneous && spec.fields.basis == FieldBasis::kModes)
    throw InputError("field_basis",
                     "found modes with an experiment, expected elements: modes are of a disc");
  if (spec.stages.residuals.solve_mode != SolveMode::kStatic)
    throw InputError("solve", "found dynamic with an experiment, expected static");
}

// Experiments that move begin at their start; others after the first, where the start tables bring
// them.
void SettleFurther(const FitSpec& spec, std::vector<Experiment> experiments,
                   const std::string& file, FitInput& input) {
  FitProblem& problem = input.problem;
  for (Experiment& each : experiments) {
    SettledExperiment further{.experiment = std::make_shared<const Experiment>(std::move(each)),
                              .model = {},
                              .start = {}};
    further.model = MakeModel(further.experiment->mesh, *further.experiment, spec.law);
    if (further.experiment->motion) {
      further.start = MakeStart(*further.experiment, *further.model, 0);
      if (further.experiment->velocity.size() > 0) further.start.v = further.experiment->velocity;
      // A device has no faces on which air could act in a scene without stretch.
      further.backend =
          MakeBackend(further.model->scene.stretch ? spec.backend : "cpu", further.model, 1,
                      input.device.empty() ? &input.device : nullptr)
              ->name();
      problem.further.push_back(std::move(further));
      continue;
    }
    const std::unique_ptr<Backend> backend = MakeCpuBackend(further.model, 1);
    const State start = MakeStart(*further.experiment, *further.model, 0);
    SettledDrape drape = std::move(
        Settle(*backend, problem.material, {&start, 1}, MakeSettleOptions(spec.stages)).front());
    if (!drape.IsUsable(SolveMode::kStatic))
      throw InputError(file, "experiment '" + further.experiment->name + "' is " +
                                 ToString(drape.rest.status) +
                                 " with the start tables, expected a cloth that comes to rest");
    further.start = AtRest({std::move(drape.rest.x)}).front();
    problem.further.push_back(std::move(further));
  }
}

// A density is seen beside a force alone [MODEL, M68].
void RequireNewtons(const ExperimentFile& file, const std::vector<LabMeasurement>& measurements,
                    const std::string& path) {
  const bool fits_drag = std::ranges::count(file.fitted, FreeNumber::kAirDrag) > 0;
  const bool found =
      std::ranges::any_of(file.experiments,
                          [&](const Experiment& each) {
                            return each.in_newtons || (each.dynamics.air_drag > 0.0 && !fits_drag);
                          }) ||
      std::ranges::any_of(measurements, [](const LabMeasurement& each) {
        return each.kind == LabMeasurementKind::kTensile;
      });
  if (!found)
    throw InputError(path,
                     "key 'fit': found density and no number in newtons, expected a force, a load, "
                     "a known air_drag or a tensile test: without one only stiffness by density "
                     "is seen");
}

// Models beside the one table are about a cloth at rest; where its elements have tables of their
// own, about nothing else.
void RequireModel(const FitSpec& spec, const FitInput& input, const std::string& path) {
  const FitProblem& problem = input.problem;
  if (spec.model == FitModel::kHomogeneous) return;
  const auto fail = [&](const std::string& found) {
    throw InputError(path, std::string("model ") + ToString(spec.model) + ": found " + found);
  };
  const Experiment* searched = FindExperiment(problem);
  if (searched == nullptr)
    fail("motions alone or a density that is fitted, expected a cloth at rest of known density");
  if (spec.model == FitModel::kBayes) return;
  if (input.strips != nullptr || !problem.further.empty())
    fail(
        "further experiments or lab_tests, expected one experiment: elements of one cloth have "
        "tables of their own");
  for (const Sight& sight : MakeSights(*searched, problem.fine->model()))
    if (sight.readouts.front()->reads_material())
      fail("frequencies, whose derivatives are by one table, expected none");
}

// Fits experiments that are complete. where: their file, or what else a user knows them by.
FitInput MakeExperimentInput(const FitSpec& spec, FitData data, ExperimentFile file,
                             const std::string& where) {
  CheckExperiment(spec, data);
  if (!file.material.empty()) data.material = file.material;
  if (file.density > 0.0) data.density = file.density;
  data.lab_measurements = file.lab_measurements;
  FitInput input;
  input.notes = data.notes;
  std::vector<LabMeasurement> measurements = ReadAllMeasurements(file.lab_measurements);
  for (const Experiment& each : file.experiments)
    for (const Measurement& measurement : each.measurements)
      for (const std::string& note : measurement.quality.notes)
        input.notes.push_back(measurement.name + ": " + note);
  const double density = FindDensity(data, measurements, &input.notes);
  const bool fits_density = std::ranges::count(file.fitted, FreeNumber::kDensity) > 0;
  if (fits_density) RequireNewtons(file, measurements, where);
  input.density_is_given = density > 0.0 || fits_density;
  const auto at_rest =
      std::find_if(file.experiments.begin(), file.experiments.end(),
                   [&](const Experiment& each) { return !each.motion && !fits_density; });
  if (at_rest != file.experiments.end()) {
    input.problem.observations = {MakeExperimentObservation(std::move(*at_rest), where)};
    file.experiments.erase(at_rest);
  }
  input.problem.mirrors = false;
  ReadAllStartTables(spec, data, density, &input);
  NoteDensity(measurements, &input);
  if (!measurements.empty())
    input.strips = std::make_unique<Strips>(std::move(measurements), MakeLaw(spec.law));
  if (const Experiment* searched = FindExperiment(input.problem)) {
    input.fine.model = MakeModel(searched->mesh, *searched, spec.law);
    input.fine.backend = MakeBackend(spec.backend, input.fine.model, spec.threads, &input.device);
    input.problem.fine = input.problem.coarse = input.fine.backend.get();
    if (searched->search_mesh.num_vertices() > 0) {
      FitInput::Cloth& search = input.search.emplace_back();
      search.model = MakeModel(searched->search_mesh, *searched, spec.law);
      search.backend = MakeBackend(spec.backend, search.model, spec.threads, nullptr);
      input.problem.search = {search.backend.get()};
      input.problem.coarse = search.backend.get();
    }
  }
  input.problem.fitted = file.fitted;
  for (const Experiment& each : file.experiments)
    if (each.motion && !input.problem.material.dynamics.Acts())
      input.problem.material.dynamics = each.dynamics;
  SettleFurther(spec, std::move(file.experiments), where, input);
  RequireModel(spec, input, where);
  input.prior = ReadPrior(spec, input.problem.material.density);
  return input;
}

}  // namespace

FitInput MakeFitInput(const FitSpec& spec, ExperimentFile experiments) {
  const std::string where = "experiments in memory";
  CompleteExperiments(experiments, where);
  return MakeExperimentInput(spec, {}, std::move(experiments), where);
}

FitInput ReadFitInput(const FitSpec& spec, const FitData& data) {
  const ReadRecord record;
  const std::future<void> waking = WakeGpus(spec.backend);
  if (!data.experiment.empty()) {
    FitInput input =
        MakeExperimentInput(spec, data, ReadExperiments(data.experiment), data.experiment);
    input.files = record.files();
    return input;
  }
  if (data.num_observations() == 0 && data.lab_measurements.empty())
    throw InputError(
        "images",
        "found no silhouette and no lab_tests, expected at least one silhouette or measurement");
  if (!data.images.empty() && !data.captures.empty())
    throw InputError("images", "found some beside captures of a data set, expected one of both");
  CheckModel(spec, data);
  CheckCamera(spec.observation.camera, data);
  FitInput input;
  input.notes = data.notes;
  std::vector<LabMeasurement> measurements = ReadAllMeasurements(data.lab_measurements);
  input.discs = FitDiscs(spec, data);
  ObservationOptions observation = spec.observation;
  observation.discs = GivenDiscs(input.discs);
  input.problem.observations = ReadObservations(data, observation);
  input.problem.specimens = data.specimens;
  CheckNames(input.problem.observations);
  for (std::string& note : ListNotes(input.problem.observations))
    input.notes.push_back(std::move(note));
  DropRepeats(input.problem, &input.notes);
  PrepareWarp(spec.model, !measurements.empty(), input.problem, &input.notes);
  const double density = FindDensity(data, measurements, &input.notes);
  input.density_is_given = density > 0.0;
  ReadAllStartTables(spec, data, density, &input);
  NoteDensity(measurements, &input);
  input.prior = ReadPrior(spec, input.problem.material.density);
  if (!measurements.empty())
    input.strips = std::make_unique<Strips>(std::move(measurements), MakeLaw(spec.law));
  UsePool(spec, &input);
  if (!input.problem.observations.empty()) MakeCloths(spec, data.shared, &input);
  input.files = record.files();
  return input;
}

}  // namespace drape
