// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glog/logging.h>

#include "losses/outline/outline.h"
#include "physics/material/material_scaling.h"
#include "solver/fit/protocol/staged_fit.h"
#include "tests/solver/fake_backend.h"

namespace drape::test {

// The outline of a material's drape without physics, as an observation.
inline Observation ObserveDrape(const FakeBackend& backend, const MaterialField& material,
                                int angles) {
  Observation observation;
  Outline outline;
  CHECK(OutlineFromMesh(backend.model().mesh, backend.Shape(material), observation.camera, angles,
                        &outline));
  observation.radius = outline.radius;
  return observation;
}

// The fit of one observation of a known drape, by two numbers in three rounds, in some of which
// drapes fail. It takes milliseconds.
struct FakeFit {
  FakeBackend backend, coarse;
  FitProblem problem;
  StagedFitOptions options;

  FakeFit() {
    problem.fine = &backend;
    problem.coarse = &coarse;
    problem.material = TestMaterial();
    problem.observations = {ObserveDrape(backend, Scaled(problem.material, 3.0, 1.5), 45)};
    options.residuals.solve_mode = SolveMode::kDynamic;
    options.parameters = ParameterTying::kScales;
    options.candidates_per_round = {3, 2, 1};
    options.iterations = {2, 3, 4};
    backend.fails = [](double s, double b) { return s > 1.0 && b < 0.0; };
  }
};

}  // namespace drape::test
