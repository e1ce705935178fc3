// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "losses/camera/camera.h"
#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/protocol/field_io.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_io.h"

namespace drape {
namespace {

constexpr int kReportedModes = 3;

// The outlines of an image and of a drape in it; false where one is missing.
bool ReadOutlines(const Mesh& mesh, const Observation& observation, const Eigen::VectorXd& x,
                  Outline* image, Outline* fitted) {
  return OutlineFromImage(observation.image, observation.camera, kReportAngles, image) &&
         OutlineFromMesh(mesh, observation.InImage(x), observation.camera, kReportAngles, fitted);
}

bool Measure(const Mesh& mesh, const Observation& observation, Eigen::VectorXd x,
             MeasuredDrape* drape) {
  constexpr int kSupersample = 4;
  Outline image, fitted;
  if (!ReadOutlines(mesh, observation, x, &image, &fitted)) return false;
  drape->metrics =
      CompareSilhouettes(observation.image, image.radius,
                         Rasterize(mesh, observation.InImage(x), observation.camera, kSupersample),
                         fitted.radius, observation.camera, observation.discs);
  // The drape coefficient of a photograph is that of the drape's vertical projection.
  const Camera above;
  const bool is_photograph =
      observation.camera.kind == CameraKind::kPinhole &&
      OutlineFromMesh(mesh, observation.InImage(x), above, kReportAngles, &fitted);
  drape->radius = MetresFromPixels(fitted.radius, is_photograph ? above : observation.camera);
  if (is_photograph) drape->metrics.fitted = MeasureShape(drape->radius, observation.discs);
  drape->x = std::move(x);
  return true;
}

// The drape moved so that a camera of this scale, centred in the image, sees it where the image has
// it. That of a photograph stays where it is: its camera file says where the support is.
Eigen::VectorXd SeenFromNominalCamera(const Eigen::VectorXd& x, const Camera& camera) {
  if (camera.kind == CameraKind::kPinhole) return x;
  const double cx = 0.5 * (camera.width - 1), cy = 0.5 * (camera.height - 1);
  Eigen::VectorXd moved = x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    moved[i] += (camera.cx - cx) / camera.pixels_per_metre();
    moved[i + 1] -= (camera.cy - cy) / camera.pixels_per_metre();
  }
  return moved;
}

using nlohmann::ordered_json;

constexpr double kMillimetre = 1e-3;

ordered_json ImageJson(const Observation& observation, const DrapeReport& drape, double lift) {
  ordered_json json = {
      {"file", observation.file},
      {"name", observation.name},
      {"metrics", MetricsJson(drape.fitted.metrics)},
      {"settled",
       {{"metrics", MetricsJson(drape.settled.metrics)},
        {"status", ToString(drape.status)},
        {"drift_m", drape.drift}}},
      {"force_residual", drape.force_residual},
      {"stability", StabilityJson(drape.lowest_eigenvalues)},
      {"self_intersections", drape.self_intersections},
      {"camera", CameraJson(observation.camera)},
      {"warp_degrees", observation.warp ? ordered_json(*observation.warp) : nullptr},
      {"cloth_turned_degrees", observation.pose.degrees},
      {"cloth_mirrored", observation.pose.mirrored},
      {"quality", QualityJson(observation.quality)},
      {"initial_lift", lift}};
  if (observation.photograph) json["photograph"] = PhotographJson(*observation.photograph);
  return json;
}

// Means over the images of each number that ImageJson gives for one.
ordered_json ComputeMean(const ordered_json& images, const ordered_json::json_pointer& where) {
  ordered_json mean = ordered_json::object();
  for (const auto& image : images)
    for (const auto& [key, value] : image.at(where).items())
      mean[key] = mean.value(key, 0.0) + value.get<double>() / static_cast<double>(images.size());
  return mean;
}

ordered_json FitJson(const StagedFitState& state, const FitCandidate& best) {
  return {{"termination", ToString(best.termination)},
          {"cost", best.cost},
          {"iterations", state.iterations},
          {"rollouts", state.counts.rollouts},
          {"tangents", state.counts.tangents},
          {"failed_rollouts", state.counts.failed},
          {"branch_jumps", state.counts.jumps},
          {"capped_steps", state.counts.capped}};
}

ordered_json SpectrumJson(const Spectrum& spectrum) {
  return {{"singular_values", spectrum.values}, {"determined_directions", spectrum.determined}};
}

ordered_json ParametersJson(double prior_sigma, const Eigen::VectorXd& theta) {
  return {{"count", theta.size()}, {"log_factors", theta}, {"prior_sigma", prior_sigma}};
}

// The fit of the laboratory measurements alone, about the start tables.
ordered_json LabFitJson(double prior_sigma, const FitSummary& fit) {
  ordered_json json = {{"termination", ToString(fit.termination)}};
  if (fit.termination == FitTermination::kFailed) return json;
  json.update({{"cost", fit.final_cost},
               {"iterations", std::max<int>(0, static_cast<int>(fit.iterations.size()) - 1)},
               {"rollouts", fit.counts.rollouts},
               {"tangents", fit.counts.tangents},
               {"seconds", {{"fit", fit.seconds}}},
               {"parameters", ParametersJson(prior_sigma, fit.theta)},
               {"spectrum", SpectrumJson(ComputeSpectrum(fit.jacobian, prior_sigma))}});
  return json;
}

// The stiffness of the fitted table or of the mean of its fields, beside the reference if there is
// one.
ordered_json StiffnessJson(const FitReport& report) {
  ordered_json json;
  for (const StiffnessQuantity& quantity :
       ListStiffness(MeanTables(report.material), report.stiffness_weights, report.directions))
    json[quantity.key]["fitted"] = quantity.value;
  if (report.ground_truth == nullptr) return json;
  for (const StiffnessQuantity& quantity :
       ListStiffness(*report.ground_truth, report.stiffness_weights, report.directions))
    json[quantity.key]["reference"] = quantity.value;
  return json;
}

// What does not depend on the density, and where that is from.
ordered_json BendingJson(const FitReport& report) {
  const double density = report.material.density;
  const double rigidity = EffectiveBend(MeanTables(report.material), report.stiffness_weights);
  return {{"density_kg_m2", density},
          {"density_from", report.density_is_given ? "given" : "start tables"},
          {"bend_over_weight_m3", BendOverWeight(rigidity, density)},
          {"bending_length_m", BendingLength(rigidity, density)}};
}

std::string MisfitKey(const FitProblem& problem) {
  return FindExperiment(problem) == nullptr ? "profile_rms_px" : "misfit_sigma";
}

// The fits by the models that were fitted first, and whether the own model's began with their best.
ordered_json SimplerModelsJson(const FitProblem& problem, const StagedFitState& state,
                               const FitCandidate& best) {
  const int own = static_cast<int>(problem.simpler_models.size());
  ordered_json fits = ordered_json::array();
  bool began_carried = best.is_carried;
  for (const PartResult& result : state.part_results) {
    if (result.part == own) began_carried = result.began_carried;
    if (result.part >= own) continue;
    fits.push_back({{"model", NameFor(problem.simpler_models[result.part])},
                    {"cost", result.cost},
                    {MisfitKey(problem), result.profile_rms}});
  }
  return {{"fits", fits}, {"result_began_with_the_best", began_carried}};
}

// The fits by the own model, on coarser meshes first.
ordered_json MeshesJson(const FitSpec& spec, const FitProblem& problem, const StagedFitState& state,
                        const FitReport& report) {
  std::vector<PartResult> results = state.part_results;
  results.push_back(FindResult(problem, spec.stages, state).value());
  ordered_json fits = ordered_json::array();
  for (const PartResult& result : results) {
    if (result.part < static_cast<int>(problem.simpler_models.size())) continue;
    const Backend* backend = PartProblem(problem, result.part).fine;
    fits.push_back({{"vertices", backend->model().mesh.num_vertices()},
                    {"cost", result.cost},
                    {MisfitKey(problem), result.profile_rms},
                    {"stretch_n_per_m", result.stretch},
                    {"bend_n_m", result.bend}});
  }
  ordered_json json = {{"fits", fits}, {"error", nullptr}};
  if (report.mesh_error)
    json["error"] = {{"log_stretch", report.mesh_error->log_stretch},
                     {"log_bend", report.mesh_error->log_bend}};
  return json;
}

ordered_json GuessJson(const FitReport& report, const FitProblem& problem,
                       const InitialGuess& guess) {
  if (problem.is_pooled)
    return {{"pooled_drape", guess.table + 1}, {"of", problem.other_materials.size() + 1}};
  return {{"material", report.start_name},
          {"stretch", guess.stretch},
          {"bend", guess.bend},
          {"lifts", guess.lifts},
          {"coarse_" + MisfitKey(problem), guess.profile_rms}};
}

// The outlines of image and fit at equal angles, counter-clockwise from the right, in pixels of the
// image; null where one of them is missing.
ordered_json OutlinesJson(const Mesh& mesh, const Observation& observation,
                          const Eigen::VectorXd& x) {
  const auto rounded = [](const Eigen::VectorXd& radius) {
    std::vector<double> list;
    for (const double value : radius) list.push_back(std::round(100.0 * value) / 100.0);
    return list;
  };
  Outline image, fitted;
  if (x.size() == 0 || !ReadOutlines(mesh, observation, x, &image, &fitted)) return nullptr;
  return {{"px_per_m", observation.camera.pixels_per_metre()},
          {"image_px", rounded(image.radius)},
          {"fit_px", rounded(fitted.radius)}};
}

ordered_json ExperimentsJson(const FitProblem& problem, const FitReport& report) {
  ordered_json measurements = ordered_json::array();
  for (const MeasurementReport& each : report.measurements)
    measurements.push_back({{"experiment", each.experiment},
                            {"name", each.name},
                            {"numbers", each.count},
                            {"misfit_sigma", each.misfit},
                            {"largest_sigma", each.largest},
                            {"mesh_factor", each.mesh_factor},
                            {"step_factor", each.step_factor}});
  ordered_json json = {{"measurements", measurements}};
  for (const DynamicsReport& each : report.dynamics) {
    ordered_json& of = json["dynamics"][ToString(each.number)];
    if (IsVector(each.number))
      of = {{"value", each.values}, {"sd", each.sd}};
    else
      of = {{"value", each.values[0]}, {"log_sd", each.sd[0]}};
  }
  if (report.drapes.empty()) return json;
  const DrapeReport& drape = report.drapes.front();
  json["drape"] = {{"experiment", problem.observations.front().name},
                   {"force_residual", drape.force_residual},
                   {"stability", StabilityJson(drape.lowest_eigenvalues)},
                   {"self_intersections", drape.self_intersections}};
  return json;
}

// Metrics of each image and their means.
ordered_json ImagesJson(const FitProblem& problem, const FitReport& report,
                        const InitialGuess& guess) {
  ordered_json images = ordered_json::array();
  for (std::size_t i = 0; i < report.drapes.size(); ++i) {
    images.push_back(ImageJson(problem.observations[i], report.drapes[i], guess.lifts[i]));
    images.back()["outlines"] = OutlinesJson(problem.fine->model().mesh, problem.observations[i],
                                             report.drapes[i].fitted.x);
  }
  if (const std::optional<Contact>& contact = problem.fine->model().scene.contact)
    for (std::size_t i = 0; i < report.drapes.size(); ++i) {
      const Eigen::VectorXd& x = report.drapes[i].fitted.x;
      images[i]["smallest_gap_m"] = SmallestGap(*contact, x);
      if (contact->self)
        images[i]["smallest_self_gap_m"] = SmallestSelfGap(problem.fine->model(), x);
    }
  return {{"images", images},
          {"mean", ComputeMean(images, ordered_json::json_pointer("/metrics"))},
          {"mean_settled", ComputeMean(images, ordered_json::json_pointer("/settled/metrics"))}};
}

// The sheets that a laboratory would fill in: of the material and of the drape in each image.
ordered_json LaboratoryJson(const FitProblem& problem, const FitReport& report) {
  ordered_json json = ordered_json::object();
  if (report.fabric_sheet) json["material"] = SheetJson(*report.fabric_sheet);
  if (report.linear_sheet) json["linear"] = SheetJson(*report.linear_sheet);
  if (report.reference_sheet) json["reference"] = SheetJson(*report.reference_sheet);
  for (std::size_t i = 0; i < report.at_once.size(); ++i)
    json["at_once_" + problem.observations[i].name] = SheetJson(report.at_once[i]);
  for (std::size_t i = 0; FindExperiment(problem) == nullptr && i < report.drapes.size(); ++i)
    json["drape_" + problem.observations[i].name] = DrapeSheetJson(
        report.drapes[i].laboratory, "Drape in the image " + problem.observations[i].name);
  return json;
}

// The rows of a sheet that fit on a screen.
std::string ShortSheet(const LaboratorySheet& sheet) {
  return SheetText(sheet, {"dc_percent", "nodes", "node_severity", "drape_distance_ratio_percent",
                           "bending_in_drape_un_m", "bending_warp_un_m", "bending_weft_un_m",
                           "bending_stiffer_un_m", "bending_softer_un_m", "bending_ratio",
                           "bending_overall_un_m", "bending_length_overall_cm", "shear_n_per_m"});
}

std::string LaboratoryText(const FitProblem& problem, const FitReport& report) {
  std::string text;
  for (std::size_t i = 0; FindExperiment(problem) == nullptr && i < report.drapes.size(); ++i)
    text += ShortSheet(DrapeSheet(report.drapes[i].laboratory,
                                  "Drape in the image " + problem.observations[i].name));
  return text + (report.fabric_sheet ? ShortSheet(*report.fabric_sheet) : "");
}

ordered_json Summary(const FitSpec& spec, const FitData& data, const FitProblem& problem,
                     const StagedFitState& state, const FitReport& report) {
  const double prior_sigma = spec.stages.prior_sigma;
  ordered_json json = {{"tool", "drape_fit"},
                       {"status", report.cancelled  ? "cancelled"
                                  : report.fitted() ? "done"
                                                    : "failed"}};
  json.update({{"model", ToString(spec.model)},
               {"verdict", VerdictJson(report.verdict)},
               {"notes", report.notes}});
  if (report.fitted()) {
    json["directions"] = {report.directions.warp, report.directions.weft};
    json["stiffness"] = StiffnessJson(report);
    json["bending"] = BendingJson(report);
    json["laboratory"] = LaboratoryJson(problem, report);
  }
  if (!report.strips.empty()) json["lab_measurements"] = StripsJson(report.strips);
  if (!report.measurements.empty()) json.update(ExperimentsJson(problem, report));
  if (problem.observations.empty()) {
    if (report.lab_fit) json.update(LabFitJson(prior_sigma, *report.lab_fit));
    return json;
  }
  if (FindExperiment(problem) == nullptr) json.update(DiscsJson(problem.observations[0].discs));
  json["backend"] = problem.fine->name();
  if (!data.captures.empty()) {
    json["fabric"] = data.captures[0].fabric;
    json["data_source"] = ToString(data.source);
    json["density"] = problem.material.density;
  }
  if (report.lab_fit) json["lab_fit"] = LabFitJson(prior_sigma, *report.lab_fit);
  const FitCandidate* best = Best(state);
  if (best == nullptr) return json;
  json.update(FitJson(state, *best));
  json["seconds"] = {
      {"grid", state.grid_seconds}, {"fit", state.fit_seconds}, {"report", report.report_seconds}};
  if (!problem.simpler_models.empty())
    json["simpler_models"] = SimplerModelsJson(problem, state, *best);
  json["meshes"] = MeshesJson(spec, problem, state, report);
  json["initial_guess"] = GuessJson(report, problem, best->guess);
  json["parameters"] = ParametersJson(prior_sigma, best->theta);
  if (FindExperiment(problem) == nullptr)
    json["parameters"]["sigma_px"] = spec.stages.residuals.sigma_px;
  json["spectrum"] = SpectrumJson(report.spectrum);
  if (report.fields) json["fields"] = FieldJson(*report.fields, spec.fields);
  if (report.posterior)
    json["posterior"] = PosteriorJson(*report.posterior, report.stiffness_weights);
  if (FindExperiment(problem) == nullptr) json.update(ImagesJson(problem, report, best->guess));
  return json;
}

// The means of one table of each kind, beside the tables that the images were made with, if given:
// "c11  fitted [reference  ratio]".
std::string MaterialTable(const FitReport& report) {
  const MaterialField* reference = report.ground_truth;
  std::string table = Format("  %-22s %10s%s\n", "mean of the table", "fitted",
                             reference == nullptr ? "" : "  reference  ratio");
  std::vector<StiffnessQuantity> exact;
  if (reference != nullptr)
    exact = ListStiffness(*reference, report.stiffness_weights, report.directions);
  const std::vector<StiffnessQuantity> found =
      ListStiffness(MeanTables(report.material), report.stiffness_weights, report.directions);
  for (std::size_t i = 0; i < found.size(); ++i) {
    table += Format("  %-22s %10.4g", found[i].name.c_str(), found[i].scale * found[i].value);
    if (reference != nullptr)
      table +=
          Format(" %10.4g %6.2f", exact[i].scale * exact[i].value, found[i].value / exact[i].value);
    table += std::string("  ") + found[i].unit + "\n";
  }
  return table;
}

std::string MeasurementTable(const FitReport& report) {
  std::string table;
  if (!report.measurements.empty())
    table = Format("%-16s %8s %12s %10s  %s\n", "experiment", "numbers", "rms [sigma]", "largest",
                   "measurement");
  for (const MeasurementReport& each : report.measurements)
    table += Format("%-16.16s %8d %12.2f %10.1f  %s\n", each.experiment.c_str(), each.count,
                    each.misfit, each.largest, each.name.c_str());
  for (const DynamicsReport& each : report.dynamics)
    for (std::size_t i = 0; i < each.values.size(); ++i) {
      const double value = each.values[i], far = kQuantile90 * each.sd[i];
      const bool is_vector = IsVector(each.number);
      table += Format("  %-22s %10.4g (%.4g ... %.4g)\n", ToString(each.number), value,
                      is_vector ? value - far : value * std::exp(-far),
                      is_vector ? value + far : value * std::exp(far));
    }
  return table;
}

std::string ImageTable(const FitProblem& problem, const FitReport& report) {
  if (FindExperiment(problem) != nullptr || report.drapes.empty()) return "";
  std::string table =
      Format("%-28s %8s %7s %6s %8s %8s %7s %16s %10s %8s\n", "image", "rms [px]", "mse", "iou",
             "dc image", "dc fit", "folds", "settled rms [px]", "drift [mm]", "stable");
  for (std::size_t i = 0; i < report.drapes.size(); ++i) {
    const DrapeReport& drape = report.drapes[i];
    const SilhouetteMetrics& m = drape.fitted.metrics;
    table += Format("%-28.28s %8.2f %7.4f %6.3f %8.3f %8.3f %3d/%-3d %16.2f %10.2g %8s\n",
                    problem.observations[i].name.c_str(), m.profile_rms, m.mse, m.iou,
                    m.image.drape_coefficient, m.fitted.drape_coefficient, m.image.folds,
                    m.fitted.folds, drape.settled.metrics.profile_rms, drape.drift / kMillimetre,
                    IsStable(drape.lowest_eigenvalues) ? "yes" : "no");
  }
  return table;
}

// The faces and material coordinates of the mirror image of a mesh, for WriteObj.
Mesh MirrorImage(Mesh mesh) {
  mesh.uv.row(1) *= -1.0;
  for (Face& face : mesh.faces) std::swap(face.vertex[1], face.vertex[2]);
  return mesh;
}

// The names of the files of a fitted drape: a picture of the outlines, but of an experiment, the
// mesh as the image shows it, and its state on the mesh of the fit as a start for other programs.
std::vector<std::string> ListDrapeFiles(const Observation& observation) {
  if (observation.experiment != nullptr)
    return {"drape_" + observation.name + ".obj", "start_" + observation.name + ".json"};
  return {"fit_" + observation.name + ".png", "drape_" + observation.name + ".obj",
          "start_" + observation.name + ".json"};
}

// Writes them, each atomically; nothing for a drape that has no outline. Throws InputError when one
// cannot be written.
void WriteDrape(const std::string& folder, const Mesh& mesh, const Observation& observation,
                const DrapeReport& drape) {
  if (drape.fitted.x.size() == 0) return;
  const std::vector<std::string> files = ListDrapeFiles(observation);
  const State at_rest{drape.fitted.x, Eigen::VectorXd::Zero(drape.fitted.x.size())};
  if (observation.experiment != nullptr) {
    WriteObj(folder + "/" + files[0], mesh, drape.fitted.x);
    return WriteState(folder + "/" + files[1], at_rest);
  }
  Outline image, fitted;
  if (ReadOutlines(mesh, observation, drape.fitted.x, &image, &fitted)) {
    WritePng(RenderOverlay(observation.image, image.radius, fitted.radius, observation.camera,
                           observation.discs),
             folder + "/" + files[0]);
  }
  WriteObj(folder + "/" + files[1], observation.pose.mirrored ? MirrorImage(mesh) : mesh,
           SeenFromNominalCamera(observation.InImage(drape.fitted.x), observation.camera),
           observation.discs);
  WriteState(folder + "/" + files[2], at_rest);
}

}  // namespace

bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& observation, const Eigen::VectorXd& x,
                 const EquilibriumOptions& rest, DrapeReport* report) {
  const ClothModel& model = backend.model();
  report->force_residual = ForceResidual(model, material, x);
  report->self_intersections = CountSelfIntersections(model.mesh, x);
  report->lowest_eigenvalues = LowestEigenvalues(solver, material, x, kReportedModes, rest.cancel);
  if (observation.experiment != nullptr) {
    report->fitted.x = x;
    return true;
  }
  const NudgedDrape nudged = Nudge(backend, material, x, rest);
  report->status = nudged.status;
  report->drift = nudged.drift;
  Outline outline;
  if (OutlineFromImage(observation.image, observation.camera, kReportAngles, &outline)) {
    report->image_radius = VerticalProfile(outline.radius, observation.camera, observation.discs);
    report->laboratory = MeasureLaboratoryDrape(report->image_radius, observation.discs);
  }
  return Measure(model.mesh, observation, x, &report->fitted) &&
         Measure(model.mesh, observation, nudged.x, &report->settled);
}

std::vector<MeasurementReport> ReportMeasurements(const FitProblem& problem,
                                                  const std::vector<Eigen::VectorXd>& shapes,
                                                  const MaterialField& material) {
  std::vector<MeasurementReport> reports;
  const auto add = [&](const Experiment& experiment, std::size_t i, const Sight& sight,
                       const Eigen::VectorXd& residual) {
    const int count = sight.num_telling;
    Eigen::VectorXd weighed = residual;
    const double squares = 2.0 * WeighByLoss(sight, weighed, nullptr);
    reports.push_back({.experiment = experiment.name,
                       .name = experiment.measurements[i].name,
                       .count = count,
                       .independent = CountIndependent(sight),
                       .misfit = std::sqrt(squares / count),
                       .largest = residual.cwiseAbs().maxCoeff(),
                       .mesh_factor = experiment.mesh_factor,
                       .step_factor = experiment.step_factor});
  };
  if (const Experiment* searched = FindExperiment(problem)) {
    const std::vector<Sight> sights = MakeSights(*searched, problem.fine->model());
    for (std::size_t i = 0; i < sights.size(); ++i)
      if (const auto residual = ReadResiduals(sights[i], material, shapes.front()))
        add(*searched, i, sights[i], *residual);
  }
  if (problem.further.empty()) return reports;
  const TableParametrisation fixed(material, ParameterTying::kScales);
  const RolloutResiduals residuals = EvaluateFurther(problem, fixed, nullptr);
  for (int i = 0; i < residuals.num_blocks(); ++i) {
    Eigen::Index row = 0;
    for (std::size_t k = 0; residuals.valid(i) && k < residuals.block(i).sights.size(); ++k) {
      const Sight& sight = residuals.block(i).sights[k];
      const Eigen::Index rows = sight.data.size();
      add(*problem.further[i].experiment, k, sight, residuals.residual(i).segment(row, rows));
      row += rows;
    }
  }
  return reports;
}

void WriteFitReport(const FitSpec& spec, const FitData& data, const FitFiles& files,
                    const FitProblem& problem, const StagedFitState& state, FitReport& report) {
  const Backend* backend = PartProblem(problem, state.parts_done).fine;
  const Mesh* mesh = backend == nullptr ? nullptr : &backend->model().mesh;
  for (std::size_t i = 0; i < report.drapes.size(); ++i)
    WriteDrape(files.out, *mesh, problem.observations[i], report.drapes[i]);
  const std::string source =
      std::string(", ") + ToString(spec.law) + " law, start " + report.start_name;
  const auto write_table = [&](const std::string& name, const MaterialField& table) {
    WriteMaterial(files.out + "/" + name, {.name = "fit",
                                           .field = table,
                                           .source_convention = "mechanical",
                                           .source = "drape_fit, model homogeneous" + source,
                                           .warnings = {},
                                           .warp_known = report.warp_known()});
  };
  if (report.fields || report.posterior)
    write_table("material_homogeneous.json", FittedMaterial(spec.stages, *Best(state)));
  if (report.posterior) {
    StoredPosterior posterior = MakeStoredPosterior(*report.posterior);
    posterior.warp_known = report.warp_known();
    if (posterior.kind == PosteriorKind::kHierarchy && SeesClothOverSupport(problem))
      CountBranches(kModelDeviation, posterior);
    WritePosterior(files.out, posterior,
                   std::string("drape_fit, model ") + ToString(spec.model) + source);
  }
  if (report.posterior && report.posterior->samples)
    WriteSamples(files.out, *report.posterior->samples);
  if (report.fields) {
    WriteFields(files.out, *mesh, *report.fields, report.warp_known(),
                "drape_fit, model heterogeneous" + source);
  } else if (report.fitted()) {
    write_table("material.json", report.material);
  }
  ordered_json summary = Summary(spec, data, problem, state, report);
  if (files.provenance) summary["provenance"] = files.provenance();
  WriteFileAtomically(files.out + "/summary.json", summary.dump(2) + "\n");
}

void WriteOutlines(const std::string& path, const FitProblem& problem,
                   const FitCandidate& candidate) {
  const std::vector<Observation> observations = LaidObservations(problem, candidate);
  ordered_json drapes = ordered_json::array();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    ordered_json drape =
        OutlinesJson(problem.fine->model().mesh, observations[i], candidate.shapes[i]);
    if (drape.is_null()) continue;
    drape["name"] = observations[i].name;
    drapes.push_back(std::move(drape));
  }
  WriteFileAtomically(path, drapes.dump() + "\n");
}

std::vector<std::string> ListResultFiles(const FitSpec& spec, const FitProblem& problem) {
  std::vector<std::string> names = {"summary.json", "material.json"};
  for (const Observation& observation : problem.observations)
    for (const std::string& name : ListDrapeFiles(observation)) names.push_back(name);
  if (spec.model != FitModel::kHomogeneous) names.emplace_back("material_homogeneous.json");
  if (HasPosterior(spec.model))
    names.insert(names.end(), {"posterior.json", "base.json", kSamplesFile});
  if (spec.model == FitModel::kHeterogeneous) names.emplace_back(kFieldsFile);
  return names;
}

std::vector<std::string> MainFiles(const FitProblem& problem, const FitReport& report) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < report.drapes.size(); ++i)
    if (report.drapes[i].fitted.x.size() > 0)
      names.push_back(ListDrapeFiles(problem.observations[i])[0]);
  names.emplace_back(report.posterior ? "posterior.json" : "material.json");
  return names;
}

std::string FitText(const FitProblem& problem, const FitReport& report) {
  return MeasurementTable(report) + ImageTable(problem, report) + StripTable(report.strips) +
         MaterialTable(report) + (report.fields ? FieldTable(*report.fields) : "") +
         (report.posterior ? PosteriorTable(*report.posterior, report.stiffness_weights) : "") +
         LaboratoryText(problem, report) +
         Format("  %d of %d directions are determined by the data\n", report.spectrum.determined,
                static_cast<int>(report.spectrum.values.size())) +
         VerdictText(problem, report);
}

}  // namespace drape
