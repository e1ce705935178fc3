// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/predict/training_images.h"

#include "losses/image/segmentation.h"
#include "physics/util/errors.h"
#include "solver/job/fit_input.h"

namespace drape {
namespace {

void CheckCount(const char* option, std::size_t found, std::size_t images) {
  if (found != 0 && found != images)
    throw InputError(std::string("option '") + option + "'",
                     "found " + std::to_string(found) + " values, expected " +
                         std::to_string(images) + ", one for each image");
}

ClothFace FaceOfImage(const std::string& name) {
  if (const auto face = ParseClothFace(name)) return *face;
  throw InputError("option 'image_faces'", "found \"" + name + "\", expected up or down");
}

}  // namespace

std::vector<Option> TrainingImageOptions(TrainingImages& training) {
  return {
      {.key = "images",
       .value = &training.images,
       .doc = "with learn: silhouettes of the fabric to learn from in place of data (JPEG or PNG): "
              "files, folders, patterns; the camera is then theirs",
       .is_path = true},
      {.key = "image_samples",
       .value = &training.samples,
       .doc = "the sample of each image, from 1; none: each shows its own",
       .least = 1,
       .most = 1000},
      {.key = "image_faces",
       .value = &training.faces,
       .doc = "the face of each image that lies up: up or down; none: all up"},
  };
}

std::vector<ObservedCapture> ObserveTrainingImages(const TrainingImages& training,
                                                   const CameraInput& camera,
                                                   const DrapeDiscs& discs) {
  std::vector<std::string> files;
  for (const std::string& text : training.images)
    for (std::string& file : ExpandImages(text)) files.push_back(std::move(file));
  CheckCount("image_samples", training.samples.size(), files.size());
  CheckCount("image_faces", training.faces.size(), files.size());
  std::vector<ObservedCapture> seen;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    const Capture capture{
        .fabric = 1,
        .sample = training.samples.empty() ? number : training.samples[i],
        .capture = number,
        .face = training.faces.empty() ? ClothFace::kUp : FaceOfImage(training.faces[i]),
        .image = files[i]};
    const GrayImage image = ReadSilhouette(files[i]).image;
    seen.push_back({capture, ObserveImage(image, MakeCamera(camera, image, discs, files[i]), discs,
                                          files[i])});
  }
  return seen;
}

}  // namespace drape
