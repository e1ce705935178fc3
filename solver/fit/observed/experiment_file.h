// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/fit/observed/experiment.h"
#include "solver/fit/parametrisation.h"

namespace drape {

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
//      "search_mesh": "strip:0.3x0.3x10", "random_starts": 2, "measurements": […, …],
//      "motion": {"steps": 60, "time_step": 0.02, "velocity": [0, 0, 0],
//                 "mass_damping": 0, "stiffness_damping": 0, "air_drag": 0, "wind": [0, 0, 0]}},
//      …]}
// "search_mesh": a coarser mesh of the cloth, on which its branch is sought; by default that of
// half the edges for a strip of 300 vertices and more, where all can be read of it, else none.
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
