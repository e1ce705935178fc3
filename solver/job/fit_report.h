// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "physics/simulation/backend.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/fit.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/fit/observed/observation.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/settle.h"
#include "solver/job/fit_data.h"
#include "solver/job/fit_spec.h"
#include "solver/job/fit_verdict.h"

namespace drape {

// A shape and how far it is from the image.
struct MeasuredDrape {
  Eigen::VectorXd x;  // [m], shape [3V]
  SilhouetteMetrics metrics;
  Eigen::VectorXd radius = {};  // of its vertical projection [m], shape [kReportAngles]
};

// A fitted drape against its image, and whether it is an equilibrium: a transient shape that
// matches the image is no fit.
struct DrapeReport {
  MeasuredDrape fitted;
  double force_residual = 0.0;         // ‖f‖ / weight
  int self_intersections = 0;          // of the fitted drape (CountSelfIntersections)
  Eigen::VectorXd lowest_eigenvalues;  // of K by mass [s⁻²], ascending (LowestEigenvalues); the
                                       // drape is stable when they are positive
  // Where the fitted drape comes to rest when it is nudged, as in NudgedDrape.
  MeasuredDrape settled;
  double drift = 0.0;  // [m]
  EquilibriumStatus status = EquilibriumStatus::kStable;
  LaboratoryDrape laboratory;         // of the image
  Eigen::VectorXd image_radius = {};  // as MeasuredDrape::radius; empty where it is not closed
};

// Angles of the profiles that are compared.
inline constexpr int kReportAngles = 360;

// Reports the drape x of an observation. False when x has no outline. `solver` works on the
// backend's model. When *rest.cancel turns true, what a report tells beyond the fitted drape is
// left out: no nudges (status kCancelled) and no eigenvalues.
bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& observation, const Eigen::VectorXd& x,
                 const EquilibriumOptions& rest, DrapeReport* report);

// A measurement of an experiment beside the fitted cloth.
struct MeasurementReport {
  std::string experiment, name;
  int count = 0;        // of its numbers
  int independent = 0;  // of them (CountIndependent)
  // Root mean square of their residuals, as their loss counts them, and the largest [sigma].
  double misfit = 0.0, largest = 0.0;
  double mesh_factor = 1.0, step_factor = 1.0;  // of its experiment
};
// Reports all experiments, also those whose branch was not searched. shapes: of the observations.
// Left out is what cannot be read.
std::vector<MeasurementReport> ReportMeasurements(const FitProblem& problem,
                                                  const std::vector<Eigen::VectorXd>& shapes,
                                                  const MaterialField& material);

// A number that was fitted beside the tables, and the standard deviation of its logarithm, or of
// the coordinates of a vector [m/s].
struct DynamicsReport {
  FreeNumber number = FreeNumber::kDensity;
  std::vector<double> values, sd;  // shape [1], or [3] of a vector
};

// All results of a fit, before they are written.
struct FitReport {
  std::vector<DrapeReport> drapes;    // of the observations
  std::optional<FitSummary> lab_fit;  // of the laboratory measurements alone, where there are some
  std::vector<StripReport> strips;    // with the fitted material
  std::vector<MeasurementReport> measurements = {};  // with it
  std::vector<LaboratorySheet> at_once = {};         // before the fit (AnswerAtOnce)
  std::vector<DynamicsReport> dynamics = {};
  // No tables when nothing could be fitted; of kHeterogeneous those of the fields, of kBayes and
  // kBdp the posterior's median.
  MaterialField material;
  std::optional<MaterialField> start;     // the start tables of its one table
  std::string start_name;                 // FitInput
  std::optional<FieldFit> fields;         // kHeterogeneous
  std::optional<PosteriorFit> posterior;  // kBayes, kBdp
  Spectrum spectrum;                      // empty when the drapes are not stable
  Eigen::VectorXd stiffness_weights = EqualStiffnessWeights();  // of the fitted drapes
  std::optional<LaboratorySheet> fabric_sheet, linear_sheet;    // of `material`
  std::optional<LaboratorySheet> reference_sheet;               // of `ground_truth`
  std::optional<MeshError> mesh_error;  // of its one table; none for a fit on one mesh
  DirectionNames directions;
  bool density_is_given = false;                // else it is that of the start tables
  const MaterialField* ground_truth = nullptr;  // that the images were made with, if known
  FitVerdict verdict;
  std::vector<std::string> notes;  // what a reader of the figures must know
  double report_seconds = 0.0;
  bool cancelled = false;

  bool fitted() const { return !material.stretch.empty(); }
  bool warp_known() const { return directions.warp == "warp"; }
};

// `problem`: of the whole fit, whose last part `state` is at.
// Writes summary.json, material.json and for each observation fit_<name>.png, drape_<name>.obj and
// start_<name>.json, each atomically. Without observations the fit is that of the laboratory
// measurements alone. kHeterogeneous: also fields.json and material_homogeneous.json. kBayes and
// kBdp: also material_homogeneous.json, posterior.json and base.json, the tables that its log
// factors are on. Throws InputError when a file cannot be written.
void WriteFitReport(const FitSpec& spec, const FitData& data, const FitFiles& files,
                    const FitProblem& problem, const StagedFitState& state, FitReport& report);

// Writes the outlines of a candidate's drapes beside those of their images, for whoever watches the
// fit: [{"name", "px_per_m", "image_px", "fit_px"}, …] as in summary.json; atomically.
void WriteOutlines(const std::string& path, const FitProblem& problem,
                   const FitCandidate& candidate);

// The names of all files that it may write.
std::vector<std::string> ListResultFiles(const FitSpec& spec, const FitProblem& problem);

// The names of the files that a person looks at first: pictures of the outlines, and the material.
std::vector<std::string> MainFiles(const FitProblem& problem, const FitReport& report);

// For a person: one line per image, the means, the material beside `ground_truth` when given, and
// the verdict.
std::string FitText(const FitProblem& problem, const FitReport& report);

}  // namespace drape
