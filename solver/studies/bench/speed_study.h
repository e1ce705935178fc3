// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "solver/studies/runner/study.h"

namespace drape {

// What a time step costs, forward and backward, beside published figures: rollouts from the flat
// cloth at rest, and the gradient of a scalar of their end by the 39 numbers of one table, on
// several meshes [MODEL, M20].

// Figures of others, one number a mesh: {"vertices": [297, …], "rows": [{"name", "machine",
// "source", "forward_s": […], "backward_s": […]}]}, seconds a step on meshes of ascending numbers
// of vertices; a list that is not known is left out. Throws InputError.
nlohmann::json ReadPublishedSpeeds(const std::string& path);

struct SpeedJob {
  std::string material = kBuiltInName;  // ReadMaterial
  std::string law = "reference";        // MakeLaw
  std::vector<std::string> meshes;      // ParseMeshSpec
  double h = 0.05;                      // [s]
  int steps = 100;
  std::string backend = "auto";  // MakeBackend
  int threads = 1;
  std::vector<int> batches = {1};  // equal drapes at once; times are for one of them
  int repeats = 3;                 // at most
  double seconds = 10.0;           // and no more once so much wall clock is spent
  nlohmann::json settings = {};    // Study::settings
};

// The cells measure each mesh and batch, forward apart from the gradient, forward included; they
// are to run in processes of their own (StudyOptions::processes). A result has "seconds" (wall
// clock a step and drape, the median), "spread" (slowest − fastest), "repeats", "vertices",
// "device" and "processor", its name. Reads and checks all input. Throws InputError, a run also
// where a rollout fails.
Study MakeSpeedStudy(const SpeedJob& job);

}  // namespace drape
