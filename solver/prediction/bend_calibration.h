// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "solver/prediction/prediction.h"

namespace drape {

// A fit to outlines finds the stiffness at which the observed drapes are equilibria. Drapes
// simulated from random starts also settle on other branches, and stiffness trades off against the
// branch, so in the mean they may hang higher or lower than the observed ones; and the two faces of
// a fabric can differ more than its samples. For each face a factor b on all bend entries matches
// the distribution of simulated drapes to the observed ones: the minimum over ln b of
//   n · S(b) + ln²b / (2σ²),
// S the mean energy score of drape coefficient and fold count, the two numbers that laboratories
// report of a Cusick test, in units of kFeatureScales, against the n drapes of the training set.
// The energy score is proper, so this is a minimum scoring rule estimate [Dawid 2016] with a
// log-normal prior about the fit. The band energies are left out: real folds are more regular than
// those of random starts, no factor corrects that, and the attempt costs accuracy of the drape
// coefficient (tests/bench/PREDICTIONS.md). A second factor, on stretch, does not improve
// predictions (tests/bench/COMPARISON.md).
//
// Drapes of one random seed change branch as the factor does, so the objective has no useful
// derivative: compass search [Kolda 2003] on a lattice of factors 2^(i/4), all trials with the same
// random starts. Trials with another random seed move the result by one or two lattice steps.
struct CalibrationOptions {
  double sigma = 1.0;  // of ln b, > 0
  int specimens = 16;  // of each trial, ≥ 2
};

struct BendTrial {
  ClothFace face = ClothFace::kUnknown;  // that lies up; kUnknown: all faces of the prediction
  double factor = 1.0;
  int at_rest = 0;         // of its drapes
  double objective = 0.0;  // infinite: a face has fewer than two drapes at rest
};

struct BendCalibration {
  bool cancelled = false;  // then the factors are the best so far
  // A face without a training drape has the factor of the other.
  BendFactors factors;
  int drapes = 0;                 // of all trials
  std::vector<BendTrial> trials;  // face by face, in their order; the first of each is no change
};

// `prediction`: how drapes are simulated; its factors and count of specimens are replaced, its seed
// gives the trials' streams. `training`: at least one drape of the prediction's faces; if the face
// of one is not known, all have the same factor. progress: trials done. The result does not depend
// on the number of threads.
BendCalibration CalibrateBend(Backend& backend, const MaterialSource& materials,
                              const PredictionOptions& prediction,
                              const std::vector<ObservedCapture>& training,
                              const CalibrationOptions& options,
                              const std::function<void(int trials)>& progress = {});

}  // namespace drape
