// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/posterior/space/material_space.h"
#include "solver/studies/recognition/recognition.h"
#include "solver/studies/recognition/sample_model.h"

namespace drape {

// A sample with its posterior in common coordinates.
struct FittedSample {
  const FitCell* cell = nullptr;
  int fabric = 0, sample = 0;  // from 0 among the fabrics; number in the data set
  FabricBelief belief;
};

struct FittedSamples {
  SpaceFrame frame;
  std::vector<int> fabrics;  // numbers in the data set
  std::vector<FittedSample> fitted;
  DeterminedDirections leading;  // of all samples
  Eigen::VectorXd centre;        // mean of all posteriors, in z
};

// Of fabrics with at least two samples; a fabric with one cannot be recognised by the others.
// `done`: names of the cells that have a posterior. Throws InputError where fewer than two fabrics
// are left, or the fits determine no direction.
FittedSamples CollectSamples(const RecognitionJob& job, const std::vector<std::string>& done);

// without: of the fitted samples; −1: none is left out.
SampleModel ModelOfPosteriors(const FittedSamples& samples, int without);

// In units of kFeatureScales, shape [kNumFeatures].
Eigen::VectorXd ScaledFeatures(const ObservedDrape& drape);

}  // namespace drape
