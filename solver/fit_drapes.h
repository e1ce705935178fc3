// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/cloth/cloth_model.h"
#include "physics/mesh/mesh_spec.h"  // for experiments
#include "physics/util/run_control.h"
#include "solver/fit/observed/experiment_file.h"
#include "solver/fit/observed/observation.h"
#include "solver/job/fit_data.h"
#include "solver/job/fit_spec.h"
#include "solver/job/fit_verdict.h"

namespace drape {

struct FitInput;
class MaterialParametrisation;
class RolloutResiduals;

// Fits and posteriors in memory: the whole protocol of drape_fit [METHODS, P18] without files.

// What a fit has found.
struct DrapeFit {
  MaterialField material;          // fitted tables; of kBayes and kBdp the posterior's median
  LaboratorySheet sheet;           // the fabric as laboratories report it
  FitVerdict verdict;              // what to trust
  std::vector<std::string> notes;  // what a reader of the numbers must know
  std::shared_ptr<const ClothModel> cloth = {};  // of the fitted drapes
  // Positions for each observation in the cloth's frame (Observation::InImage) [m], shape [3V].
  std::vector<Eigen::VectorXd> drapes = {};
  bool cancelled = false;  // this is the best so far
  // Everything that the fit has found, in solver/job/fit_report.h, which may change.
  std::shared_ptr<const FitReport> report = {};

  bool fitted() const { return !material.stretch.empty(); }
};

// Fits one fabric to what cameras have seen of its drapes. `spec` says how: the model, the meshes,
// the backend. Its defaults are the defaults of drape_fit. fitted() is false where no drape could
// be fitted. Throws InputError for a mesh, a table or an option that contradicts the drapes, such
// as outlines of other than spec.observation.angles angles.
//
// folder: an existing one that takes the results of drape_fit too, such as summary.json, as
// drape_report, drape_predict and drape_export read them; empty: none. Throws IoError where it
// cannot.
DrapeFit FitDrapes(const FitSpec& spec, ObservedFabric fabric, const RunControl& control = {},
                   const std::string& folder = "");

// Fits experiments with readouts of any kind, for one your own: starts, branches, posterior and
// verdict are those of experiments from files. A stopped fit cannot be continued, since a readout
// has no content by which stored work could know it. Throws InputError that names the experiment
// and its measurement.
DrapeFit FitDrapes(const FitSpec& spec, ExperimentFile experiments, const RunControl& control = {},
                   const std::string& folder = "");

// Fits what `data` names in files, an experiment too: drape_fit without its files of results.
// `drapes` are then the first cloth at rest alone; FitReport::measurements says how far each
// measurement is off. Throws InputError for a file, a name or a combination that cannot be fitted.
DrapeFit FitDrapes(const FitSpec& spec, const FitData& data, const RunControl& control = {},
                   const std::string& folder = "");

// The residuals of an experiment file as a function of log factors on its start tables and of the
// numbers that the file fits beside them, for an optimiser or a sampler of one's own. The branch of
// the first cloth at rest is that on which it falls from its start under the start tables, pulled
// by its measurements [METHODS, P58]; evaluations with a Jacobian follow it. The prior of θ is up
// to the caller.
class FitResiduals {
 public:
  // spec.stages.parameters says which log factors are free. Throws InputError as FitDrapes does,
  // and where a cloth is not at rest under the start tables.
  FitResiduals(const FitSpec& spec, const FitData& data, const RunControl& control = {});
  ~FitResiduals();

  int num_parameters() const;
  // False where a cloth is not found at θ, shape [P], or has left its branch. Else the residuals,
  // scaled by their losses, shape [N], and, if not null, their Jacobian, shape [N, P]: half the
  // squares are the cost.
  bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual, Eigen::MatrixXd* jacobian);
  // Makes the cloths of the last evaluation those from which the next ones start.
  void StartFromLast();

 private:
  std::unique_ptr<FitInput> input_;
  std::unique_ptr<MaterialParametrisation> parametrisation_;
  std::unique_ptr<RolloutResiduals> residuals_;
};

// A quantity of a fabric in a posterior: a row of DrapeFit::sheet. Its interval contains the error
// of the model too, which the samples do not.
struct PosteriorQuantity : LaboratoryRow {
  std::vector<double> samples;  // its value for each fabric; all equal where the fit holds it

  double Quantile(double share) const;  // of the samples; share: 0 to 1
};

// The posterior of a fabric.
struct Posterior {
  std::vector<MaterialField> fabrics;  // independent samples
  std::vector<PosteriorQuantity> quantities;
  double pareto_k = 0.0;  // k̂ [METHODS, P30]: below 0.7 the samples are reliable

  // The quantity of that key, such as "bending_overall_un_m". Throws InputError that lists the
  // keys.
  const PosteriorQuantity& of(const std::string& key) const;
};

// Samples the posterior of a fit by model bayes; a function of the seed alone. Throws InputError
// for a fit without such a posterior and for a count below 1.
Posterior SamplePosterior(const DrapeFit& fit, int count, uint64_t seed);

}  // namespace drape
