// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "physics/util/run_control.h"

namespace drape {

// What a time step costs, forward and backward, beside published figures: rollouts from the flat
// cloth at rest, and the gradient of a scalar of their end by the 39 numbers of one table, on
// several meshes [MODEL, M20].

// A row of figures of others, one number a mesh; figures that are not known are empty lists.
struct PublishedSpeed {
  std::string name, machine, source;
  std::vector<double> forward, backward;  // [s a step]
};
struct PublishedSpeeds {
  std::vector<int> vertices;  // of the meshes, ascending
  std::vector<PublishedSpeed> rows;
};
// {"vertices": [297, …], "rows": [{"name", "machine", "source", "forward_s": […],
// "backward_s": […]}]}. Throws InputError.
PublishedSpeeds ReadPublishedSpeeds(const std::string& path);

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
};

// One mesh and batch. Memory is that of the host, less that of a process that does nothing.
struct MeasuredSpeed {
  std::string mesh = {}, device = {};
  int vertices = 0, batch = 1, repeats = 0;
  double forward = 0.0;   // wall clock [s a step and drape], median
  double gradient = 0.0;  // the same of a step with the gradient, forward included
  double forward_spread = 0.0, gradient_spread = 0.0;  // slowest − fastest
  double forward_mb = 0.0, gradient_mb = 0.0;          // peak [MB]

  double backward() const { return gradient - forward; }
};

struct SpeedTable {
  bool cancelled = false;
  std::string cpu = {};  // the processor's name, empty where the system does not tell
  std::vector<MeasuredSpeed> rows = {};
};

// Measures each mesh and batch in processes of their own, forward apart from the gradient. Throws
// InputError, also where a rollout fails.
SpeedTable MeasureSpeeds(const SpeedJob& job, const RunControl& control);

}  // namespace drape
