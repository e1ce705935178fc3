// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "solver/prediction/prediction.h"

namespace drape {

// A fit to outlines finds the stiffness at which the drapes that were seen lie at rest. Drapes that
// fall from random starts also come to rest on other branches, and stiffness trades against the
// branch, so in the mean they may hang higher or lower than those seen; and the two faces of a
// fabric can differ more than its samples. For each face a factor b on all bend entries brings the
// distribution of falls to the drapes seen: the minimum over ln b of
//   n · S(b) + ln²b / (2σ²),
// S the mean energy score of drape coefficient and fold count, the two numbers that laboratories
// report of a Cusick test, in units of kFeatureScales, against the n drapes learnt from. The energy
// score is proper, so this is a minimum scoring rule estimate [Dawid 2016] with
// a log-normal prior about the fit. The band energies are left out: real folds are more regular
// than those of random starts, no factor makes up for it, and in trying the drape coefficient is
// lost (tests/bench/PREDICTIONS.md). A second factor, on stretch, foretells no better
// (tests/bench/COMPARISON.md).
//
// Drapes of one seed change branch as the factor does, so the objective has no useful derivative:
// compass search [Kolda 2003] on a lattice of factors 2^(i/4), all trials with
// the same random starts. Trials of another seed move the answer by a lattice step or two.
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
  // A face that nothing was learnt from has the factor of the other.
  BendFactors factors;
  int drapes = 0;                 // of all trials
  std::vector<BendTrial> trials;  // face by face, in their order; the first of each is no change
};

// `prediction`: how drapes fall; its factors and count of specimens are not used, its seed gives
// the trials' streams. `learnt`: at least one of the prediction's faces; where the face of one is
// not known, all have the same factor. progress: trials done. The same on each count of threads.
BendCalibration CalibrateBend(Backend& backend, const MaterialSource& materials,
                              const PredictionOptions& prediction,
                              const std::vector<ObservedCapture>& learnt,
                              const CalibrationOptions& options,
                              const std::function<void(int trials)>& progress = {});

}  // namespace drape
