// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera_input.h"
#include "losses/dataset/trivial_predictors.h"
#include "tools/cli/option_table.h"

namespace drape {

// Silhouettes of a user's own to learn a fabric from.
struct TrainingImages {
  std::vector<std::string> images;  // files, folders, patterns (ExpandImages)
  std::vector<int> samples;         // of each image, from 1; empty: each shows its own
  std::vector<std::string> faces;   // of each, "up" or "down"; empty: all up
};

std::vector<Option> TrainingImageOptions(TrainingImages& training);

// Reads them through the camera of each. Throws InputError, also where samples or faces are not as
// many as the images.
std::vector<ObservedCapture> ObserveTrainingImages(const TrainingImages& training,
                                                   const CameraInput& camera,
                                                   const DrapeDiscs& discs);

}  // namespace drape
