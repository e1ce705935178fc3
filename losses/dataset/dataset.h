// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace drape {

// The public Cusick drapes [Gong 2024] in their published layout, irregularities included:
// data/Fabric N/silhouettes/*.jpg, data/Fabric N/meshes/*.obj, bnn_image_gt/<fabric>/*.jpg.

// Which face of the cloth lies up. Captures 1 and 2 show one, 3 and 4 the other; of further
// captures the data do not say.
enum class ClothFace { kUp, kDown, kUnknown };
std::string ClothFaceName(ClothFace face);

// One drape of one sample; all numbers count from 1.
struct Capture {
  int fabric = 0, sample = 0, capture = 0;
  ClothFace face = ClothFace::kUnknown;
  std::string image = {};  // path of the silhouette
  std::string mesh = {};   // path of the reconstructed mesh; empty: none
  int mesh_quarters = 0;   // its turn against the image [90° counter-clockwise], by KeepUsable

  std::string Name() const;  // "fabric 1, sample 2, capture 3"
};

// A training image of the published experiments.
struct TrainingImage {
  std::string fabric;  // the folder's name
  int sample = 0;
  ClothFace face = ClothFace::kUnknown;
  int drape = 0;        // the n-th drape of this face
  int observation = 0;  // 0: its name has none
  std::string image;
};

struct FileNote {
  std::string path, text;
};

struct Dataset {
  std::vector<Capture> captures;               // by fabric, sample, capture
  std::vector<TrainingImage> training_images;  // by folder, sample, face
  std::vector<FileNote> skipped;               // files that were not taken, and why
  std::vector<FileNote> notes;  // files that were taken as something else than they say
};

// Lists what lies below `folder`: the data set, or its folder `data`. By names alone; KeepUsable
// opens the files. A name counts in any case, with blanks or underscores, as "Sample 1 Capture 2",
// Obs, Observation, only the number, or no number (then it is capture 1), with or without
// "_circle_3" at its end. The fabric is the folder's. Meshes of fabrics 11–20 carry the numbers of
// the other face and are given to their images. Throws InputError when there is no fabric.
Dataset ReadDataset(const std::string& folder);

// What a user wants of it; an empty list means all.
struct Selection {
  std::vector<int> fabrics = {}, samples = {}, captures = {};
  std::optional<ClothFace> face = {};
};

// Captures that match. Throws InputError when a number occurs nowhere in what is left after the
// criteria before it, or nothing matches, and says what is there.
std::vector<Capture> Select(const Dataset& dataset, const Selection& selection);

// Opens the files of `captures`: one whose silhouette cannot be read is dropped; a mesh that cannot
// be read or does not fit its image within kMostMeshRms after any quarter turn is taken away from
// its capture, and the turn of the others is found. `skipped` gets a line for each file left out.
inline constexpr double kMostMeshRms = 3;  // [px]; of fabrics 1–5 39 meshes fit to 2, one to 6
std::vector<Capture> KeepUsable(std::vector<Capture> captures, std::vector<FileNote>* skipped);

}  // namespace drape
