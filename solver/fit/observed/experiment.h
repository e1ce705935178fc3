// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/loss_function.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "losses/outline/measured_image.h"
#include "losses/readout/readout.h"
#include "physics/cloth/assembly/dynamics.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "physics/simulation/rollout.h"

namespace drape {

// Pulls of measurements on a cloth that falls [s⁻²] [METHODS, P58]: what sees shapes leads it, what
// sees contours alone would shake it.
inline constexpr double kPullOfShapes = 3e4, kPullOfContours = 1e3;

// Numbers that were measured of a cloth, whatever mesh simulates it.
struct Measurement {
  std::string name;  // "markers of corners.csv"
  // Makes the readout of a cloth, which outlives it.
  std::function<std::shared_ptr<const Readout>(const ClothModel& model)> readout;
  Eigen::VectorXd data = {};  // in the unit of the readout, shape [K]; empty: all are zero
  double sigma = 1.0;         // standard deviation of a number, in that unit
  // Takes the squared norm of each group of residuals (Readout::group); none: its square counts.
  std::shared_ptr<ceres::LossFunction> loss = {};
  int step = 0;  // of a moving cloth: after so many time steps
  // Numbers that differ from drape to drape; 0: as many as are independent (Readout).
  int num_telling = 0;
  bool by_vertex_numbers = false;  // the readout is of the experiment's own mesh alone
  // An outline or a silhouette: its numbers are not independent nearer than its folds.
  bool is_contour = false;
  // What ever finer meshes and time steps add to the readings of a motion, in their unit, shape
  // [K]; empty: nothing. Found by the fit [METHODS, P75].
  Eigen::VectorXd grid_error = {};
  Eigen::VectorXd start = {};  // a shape of the cloth near what was measured [m]; empty: none
  ImageQuality quality = {};   // of a picture: how far it can be trusted
};

// One cloth on its scene, at rest or as it moves, and what was measured of it.
struct Experiment {
  std::string name;
  Mesh mesh;
  Scene scene;
  std::vector<Measurement> measurements;
  // Shapes from which its branch is sought: the given one, of a file by default that of the first
  // measurement that has one, or flat, is number 0; the others are flat with random waves.
  Eigen::VectorXd start = {};  // [m], shape [3V]; empty: flat
  int random_starts = -1;      // negative: 2, over a support 8 (CompleteExperiments)
  // Makes the start shape [m], shape [3V], of a lift of 0 … 1, in place of these; empty: these.
  std::function<Eigen::VectorXd(const ClothModel& model, double lift)> start_at = {};
  // Another mesh of the cloth, at rest, on which the branch is sought before the fit ends on
  // `mesh`; without vertices: none.
  Mesh search_mesh = {};
  // Time steps of a moving cloth, with the steps that are seen as frames; it begins at its start
  // with this velocity [m/s], shape [3V]. None: the cloth is at rest.
  std::optional<RolloutOptions> motion = {};
  Eigen::VectorXd velocity = {};  // empty: none
  Dynamics dynamics = {};         // damping and air; where fitted, before the fit
  bool in_newtons = false;        // a force is measured, or known: a load
  // What Measurement::grid_error leaves of the errors of mesh and time step, which all numbers of a
  // motion have in common, each as a factor on their sigma for intervals [METHODS, P75].
  double mesh_factor = 1.0, step_factor = 1.0;
};

// Start `number` of an experiment, at rest: 0 … random_starts.
State MakeStart(const Experiment& experiment, const ClothModel& model, int number);
// The starts as InitialGuessOptions::lifts: (number + 1)/(random_starts + 1).
std::vector<double> ListStarts(const Experiment& experiment);
// The start of such a lift, or that of Experiment::start_at.
State StartAt(const Experiment& experiment, const ClothModel& model, double lift);

// Readings of simulated cloths beside what was measured. Residuals: (read − data)/sigma.
struct Sight {
  // One for each run of a block, on its mesh.
  std::vector<std::shared_ptr<const Readout>> readouts;
  Eigen::VectorXd data;  // shape [K]
  double sigma = 1.0;
  std::shared_ptr<ceres::LossFunction> loss = {};  // as Measurement::loss
  int frame = -1;                                  // of the run's frames; −1: its end
  int num_telling = 0;                             // as Measurement, of an experiment
  bool is_contour = false;                         // as Measurement
};
std::vector<Sight> MakeSights(const Experiment& experiment, const ClothModel& model);

// Residuals of one sight of one shape, shape [K]; nothing where it cannot be read.
std::optional<Eigen::VectorXd> ReadResiduals(const Sight& sight, const MaterialField& material,
                                             const Eigen::VectorXd& x);
// Scales each group r of the residuals of a sight by √(ρ(s)/s), s = |r|², so that their squares are
// ρ of its loss, and their Jacobian, if not null, with them. Returns ½ Σ ρ.
double WeighByLoss(const Sight& sight, Eigen::Ref<Eigen::VectorXd> residual,
                   Eigen::Ref<Eigen::MatrixXd>* jacobian);

// The distance of a shape at rest from what was measured: √(Σ ρ/N) of N telling residuals, 1
// where they are as large as their standard deviations. Nothing where the shape cannot be read.
std::optional<double> Misfit(const Experiment& experiment, const ClothModel& model,
                             const MaterialField& material, const Eigen::VectorXd& x);
// Contours tell no more than so many independent numbers.
inline constexpr int kContourNumbers = 36;
// The telling numbers of a sight that are independent.
int CountIndependent(const Sight& sight);
// The experiment for intervals: σ is as much larger as the errors of mesh and time step say, and σ
// of contours as they have more telling numbers than independent ones.
Experiment ForIntervals(Experiment experiment);
// The factor on the standard deviations of `count` telling residuals whose misfit it is. Beyond
// chance a misfit is an error of the model or another branch, which the residuals have in common
// [METHODS, P75].
double EnlargeSigma(double misfit, int count);
// The factor where `count` numbers have an error in common, root mean square in σ, whose squares
// these are [METHODS, P75].
double EnlargeByCommon(double squares, int count);
// N of all its measurements.
int CountResiduals(const Experiment& experiment, const ClothModel& model);

}  // namespace drape
