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
#include "solver/fit/parametrisation.h"

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
  double pull = kPullOfShapes;
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
  // Time steps of a moving cloth, with the steps that are seen as frames; it begins at its start
  // with this velocity [m/s], shape [3V]. None: the cloth is at rest.
  std::optional<RolloutOptions> motion = {};
  Eigen::VectorXd velocity = {};  // empty: none
  Dynamics dynamics = {};         // damping and air; where fitted, before the fit
  bool in_newtons = false;        // a force is measured, or known: a load
};

// Start `number` of an experiment, at rest: 0 … random_starts.
State MakeStart(const Experiment& experiment, const ClothModel& model, int number);
// The starts as InitialGuessOptions::lifts: (number + 1)/(random_starts + 1).
std::vector<double> ListStarts(const Experiment& experiment);
int StartNumber(const Experiment& experiment, double lift);

// Readings of simulated cloths beside what was measured. Residuals: (read − data)/sigma.
struct Sight {
  // One for each run of a block, on its mesh; the mean of their readings counts.
  std::vector<std::shared_ptr<const Readout>> readouts;
  Eigen::VectorXd data;  // shape [K]
  double sigma = 1.0;
  std::shared_ptr<ceres::LossFunction> loss = {};  // as Measurement::loss
  int frame = -1;                                  // of the run's frames; −1: its end
  int num_telling = 0;                             // as Measurement, of an experiment
  double pull = kPullOfContours;                   // as Measurement
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
// The factor on the standard deviations of `count` telling residuals whose misfit it is. Beyond
// chance a misfit is an error of the model or another branch, which the residuals have in common
// [METHODS, P75].
double EnlargeSigma(double misfit, int count);
// N of all its measurements.
int CountResiduals(const Experiment& experiment, const ClothModel& model);

// Experiments with one fabric, from a file or made in memory.
struct ExperimentFile {
  std::string material;                            // start tables (ReadMaterial); empty: not given
  double density = 0.0;                            // [kg/m²]; 0: that of `material`
  std::vector<Experiment> experiments;             // at least one
  std::vector<std::string> lab_measurements = {};  // files (ReadLabMeasurements)
  std::vector<FreeNumber> fitted = {};             // beside the tables
};
// Checks experiments and completes them: names where there are none, the frames that are seen, and
// in_newtons under a load. Readouts are built once. Throws InputError that begins with `where`, the
// file or what else a user knows them by.
void CompleteExperiments(ExperimentFile& file, const std::string& where);
// Reads and completes them. Paths are relative to the folder of the file. Throws InputError (file,
// key, value, what was expected):
//   {"material": "fabric.json", "density": 0.12, "lab_tests": ["warp.json"],
//    "fit": ["density", "air_drag", …] (FreeNumber, with its tables),
//    "experiments": [{"name": "square", "mesh": "strip:0.3x0.3x20" (ParseMeshSpec),
//      "scene": "two_corners.json" or the object (ReadScene), "start": "state.json" (ReadStart),
//      "random_starts": 2, "measurements": […, …],
//      "motion": {"steps": 60, "time_step": 0.02, "velocity": [0, 0, 0],
//                 "mass_damping": 0, "stiffness_damping": 0, "air_drag": 0, "wind": [0, 0, 0]}},
//      …]}
// "motion": a cloth that moves from its start [s, m/s, Dynamics]; each of its measurements has a
// "step". Its branch is not searched: where all experiments move, the fit begins at the start
// tables. Fitted wind and velocity are those of all motions. Where the density is fitted no branch
// is searched, and some number must be in newtons: a force, a load, a drag that is not fitted, or a
// tensile test. Without one a cloth shows only its stiffnesses by its density.
// A measurement is one of
//   {"markers": "markers.csv", "sigma": 0.002}                  [m] (ReadMarkers)
//   {"shape": "registered.obj", "sigma": 0.002}                 [m], a vertex of it for each of
//   ours
//   {"points": "scan.ply", "sigma": 0.002, "spacing": 0.005, "max_distance": 0.02}
//       [m] (ReadPointCloud); spacing: also how far cloth is from the points (UncoveredReadout)
//   {"depth": "depth.png", "metres_per_count": 1e-4, "background": 1.5, "view": …, "sigma": 0.002}
//       [m] (ReadDepthMap, DepthReadout)
//   {"silhouette": "side.png", "view": …, "half_width": 1, "sigma": 0.3}   coverage
//   {"outline": "drape.png", "camera_file": "camera.json", "sigma": 0.0007}
//       [m] from above over a support, weft to the right (MeasureImage); default: its own camera
//   {"angle": 41.5, "tip": [3, 4], "clamp": [0, 0, 0], "along": [1, 0, 0], "sigma": 1}   [°]
//   {"force": [0, 0, 0.2], "vertices": [0, 20], "sigma": 0.001}
//   {"force": 0.2, "along": [0, 0, 1], "sigma": 0.001}
//       [N] of these handles, by default of all, on the cloth (HandleForceReadout)
//   {"frequencies": [2.1, 5.3], "modes": [1, 3], "sigma": 0.05}
//       [Hz] at rest (FrequencyReadout); modes: by default 1, 2, …
// each with an optional "loss": {"huber": 2}, {"cauchy": 2} or {"tukey": 4}, in units of sigma. A
// view is a camera (CameraJson) or {"camera": …, "position": [m], "target": [m], "up": [0, 0, 1]}
// (LookAt); a camera may be the path of its file.
ExperimentFile ReadExperiments(const std::string& path);

}  // namespace drape
