// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/dataset_input.h"

namespace drape {

std::vector<Option> DatasetOptions(DatasetQuery& query) {
  return {
      {.key = "hard_edged",
       .value = &query.hard_edged,
       .doc = "threshold images at half grey, for JPEG files of images without antialiasing"},
      {.key = "data",
       .value = &query.folder,
       .doc = "folder of the published data set: lists it and evaluates predictors without a model",
       .is_path = true},
      {.key = "data_fabric",
       .value = &query.fabric,
       .doc = "fabrics of the data set, as in 1,3-5; none: all"},
      {.key = "samples",
       .value = &query.samples,
       .doc = "samples of each fabric, as in 1,3-5; none: all"},
      {.key = "captures",
       .value = &query.captures,
       .doc = "captures of each sample, as in 1,3-5; none: all"},
      {.key = "face",
       .value = &query.face,
       .doc = "face of the cloth that lies up: captures 1 and 2 show it up, 3 and 4 down",
       .choices = {"up", "down", "both"}},
      {.key = "train",
       .value = &query.train,
       .doc = "number of training samples of each fabric, the others are held out; 0: each sample "
              "is held out in turn",
       .least = 0,
       .most = 9999},
      {.key = "split_seed",
       .value = &query.seed,
       .doc =
           "random seed of the split alone, so that it stays the same in other programs and runs",
       .least = 0},
      {.key = "split",
       .value = &query.split,
       .doc = "file of a stored split, used instead of a random one",
       .is_path = true},
      {.key = "save_split",
       .value = &query.save_split,
       .doc = "file to store the split in",
       .is_path = true},
  };
}

}  // namespace drape
