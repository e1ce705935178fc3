// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/dataset_input.h"

namespace drape {

std::vector<Option> DatasetOptions(DatasetInput& input, const std::string& seed_key) {
  return {
      {.key = "hard_edged",
       .value = &input.hard_edged,
       .doc = "cut images at half grey, for JPEGs of pictures without grey edges"},
      {.key = "data",
       .value = &input.folder,
       .doc = "folder of the published data set: lists it and evaluates its trivial predictors",
       .is_path = true},
      {.key = "fabric", .value = &input.fabric, .doc = "of the data set, like 1,3-5; none: all"},
      {.key = "samples", .value = &input.samples, .doc = "like 1,3-5; none: all"},
      {.key = "captures", .value = &input.captures, .doc = "like 1,3-5; none: all"},
      {.key = "face",
       .value = &input.face,
       .doc = "which face lies up: captures 1 and 2 are up, 3 and 4 down",
       .choices = {"up", "down", "both"}},
      {.key = "train",
       .value = &input.train,
       .doc = "samples of each fabric to learn from, the others are held out; 0: each sample is "
              "held out in turn",
       .least = 0,
       .most = 9999},
      {.key = seed_key, .value = &input.seed, .doc = "of the draw of these samples", .least = 0},
      {.key = "split",
       .value = &input.split,
       .doc = "a stored split, in place of --train and --" + seed_key,
       .is_path = true},
      {.key = "save_split",
       .value = &input.save_split,
       .doc = "file to store the split in",
       .is_path = true},
  };
}

}  // namespace drape
