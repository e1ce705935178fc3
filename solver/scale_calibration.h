// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "solver/prediction.h"

namespace drape {

// A fit to outlines finds the stiffness at which the drapes that were seen lie at rest. Drapes that
// fall from random starts also come to rest on other branches, and stiffness trades against the
// branch, so in the mean they may hang higher or lower than those seen; and the two faces of a
// fabric can differ more than its samples. For each face two factors, s on all stretch and b on all
// bend entries, bring the distribution of falls to the drapes seen: the minimum over ln s and ln b
// of
//   n · S(s, b) + (ln²s + ln²b) / (2σ²),
// S the mean energy score of drape coefficient and fold count, the two numbers that laboratories
// report of a Cusick test, in units of kFeatureScales, against the n drapes learnt from. The energy
// score is proper, so this is a minimum scoring rule estimate (Dawid, Musio and Ventura 2016) with
// a log-normal prior about the fit. The band energies are left out: real folds are more regular
// than those of random starts, no factor makes up for it, and in trying the drape coefficient is
// lost (tests/bench/PREDICTIONS.md).
//
// Drapes of one seed change branch as the factors do, so the objective has no useful derivative:
// compass search (Kolda, Lewis and Torczon 2003) on a lattice of factors 2^(i/4), all trials with
// the same random starts. Trials of another seed move the answer by a lattice step or two.
struct CalibrationOptions {
  double sigma = 1.0;  // of each log factor, > 0
  int specimens = 16;  // of each trial, ≥ 2
};

struct ScaleTrial {
  ClothFace face = ClothFace::kUnknown;  // that lies up; kUnknown: all faces of the prediction
  ScaleFactors factors;
  int at_rest = 0;         // of its drapes
  double objective = 0.0;  // infinite: a face has fewer than two drapes at rest
};

struct ScaleCalibration {
  bool cancelled = false;  // then the factors are the best so far
  // A face that nothing was learnt from has the factors of the other.
  ScaleFactors up, down;
  int drapes = 0;                  // of all trials
  std::vector<ScaleTrial> trials;  // face by face, in their order; the first of each is no change
};

// `prediction`: how drapes fall; its factors and count of specimens are not used, its seed gives
// the trials' streams. `learnt`: at least one of the prediction's faces; where the face of one is
// not known, all have the same factors. progress: trials done. The same on each count of threads.
ScaleCalibration CalibrateScales(Backend& backend, const MaterialSource& materials,
                                 const PredictionOptions& prediction,
                                 const std::vector<SeenCapture>& learnt,
                                 const CalibrationOptions& options,
                                 const std::function<void(int trials)>& progress = {});

}  // namespace drape
