// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// The public Cusick drapes [Gong 2024] in their published layout, irregularities included:
// data/Fabric N/silhouettes/*.jpg, data/Fabric N/meshes/*.obj, bnn_image_gt/<fabric>/*.jpg.

// The face of the cloth that lies up. Captures 1 and 2 show one face, 3 and 4 the other; for
// further captures it is not documented.
enum class ClothFace { kUp, kDown, kUnknown };
std::string ClothFaceName(ClothFace face);
// "up" or "down"; none of other texts.
std::optional<ClothFace> ParseClothFace(const std::string& name);

// One drape of one sample; all numbers count from 1.
struct Capture {
  int fabric = 0, sample = 0, capture = 0;
  ClothFace face = ClothFace::kUnknown;
  std::string image = {};  // path of the silhouette
  std::string mesh = {};   // path of the reconstructed mesh; empty when there is none
  int mesh_quarters = 0;   // counter-clockwise quarter turns onto the image (KeepUsable)

  std::string Name() const;  // "fabric 1, sample 2, capture 3"
};

struct FileNote {
  std::string path, text;
};

struct Dataset {
  std::vector<Capture> captures;  // by fabric, sample, capture
  size_t training_images = 0;     // of the published experiments, which are counted alone
  std::vector<FileNote> skipped;  // files that were not used, and why
  std::vector<FileNote> notes;    // files that are used as something other than their name says
};

// Lists the files below `folder`, which is the data set or its folder `data` [MODEL, M52]. It uses
// names alone; KeepUsable opens the files. A name is accepted in any case, with blanks or
// underscores, with "Sample 1 Capture 2", Obs, Observation, only the number, or no number (then it
// is capture 1), and with or without "_circle_3" at its end. The folder names the fabric.
// Meshes of fabrics 11–20 carry the capture numbers of the other face and are assigned to their
// images accordingly. Throws InputError when there is no fabric.
Dataset ReadDataset(const std::string& folder);

// The captures that a user selects; an empty list means all.
struct Selection {
  std::vector<int> fabrics = {}, samples = {}, captures = {};
  std::optional<ClothFace> face = {};
};

// Returns the captures that match. Throws InputError, which lists the available values, when a
// number does not occur among the captures that satisfy the preceding criteria, or when nothing
// matches.
std::vector<Capture> Select(const Dataset& dataset, const Selection& selection);

// Opens the files of `captures`. A capture whose silhouette cannot be read is dropped. A mesh that
// cannot be read, or that does not fit its image to kMaxMeshRms after any quarter turn, is removed
// from its capture; the quarter turn of every other mesh is found. `skipped` gets an entry for each
// file that is left out.
inline constexpr double kMaxMeshRms = 3;  // [px]; of fabrics 1–5, 39 meshes fit to 2 and one to 6
std::vector<Capture> KeepUsable(std::vector<Capture> captures, std::vector<FileNote>* skipped);

// "1,3-5" → {1, 3, 4, 5}: parses whole numbers from 1 to 9999 and ranges of them into an ascending
// list without repetition. An empty text is an empty list. Throws InputError (prefix `where`) that
// names the wrong part.
std::vector<int> ParseIndexList(const std::string& text, const std::string& where);

// The inverse, for messages and reports: {1, 3, 4, 5} → "1,3-5". `numbers` must ascend.
std::string IndexListText(const std::vector<int>& numbers);

// Training samples and held-out samples. All captures of a sample are on one side, because captures
// of one sample repeat each other.
struct Split {
  uint64_t seed = 0;
  std::vector<Capture> train, held_out;  // in the order of the data set
};

// Selects `train_samples` samples of each fabric of `captures` at random, with the same result for
// the same seed on every platform. Throws InputError unless each fabric has more samples than that.
// train_samples ≥ 1.
Split SplitBySample(const std::vector<Capture>& captures, int train_samples, uint64_t seed);

// Write and read the split as JSON: the numbers of the captures on both sides, without paths.
// Writing is atomic. Reading looks the captures up in `dataset`, so that a split can be used on
// another machine. Throws InputError for a file that is not a split, a capture that the data set
// lacks, and a sample on both sides.
void WriteSplit(const std::string& path, const Split& split);
Split ReadSplit(const std::string& path, const Dataset& dataset);

// The areal density [kg/m²] of a fabric of the public data set, as published with it [Gong 2024],
// for fabrics 1–25; std::nullopt for any other number.
std::optional<double> PublishedDensity(int fabric);

// A reconstructed drape of the public data set. Its surface joins the support to the outline by
// straight flaps, so that z carries no information about the cloth [MODEL, M52].
struct PublishedMesh {
  ObjSurface surface;         // as in the file [m]
  std::optional<Mesh> cloth;  // the flat cloth of the same vertices, where the file has vt
};

// Reads a published mesh. Files with vt begin them with a dummy line, which is recognised by their
// number (one more than v) and by its zeros. Files of another topology have no vt. Throws
// InputError for a malformed file.
PublishedMesh ReadPublishedMesh(const std::string& path);

// The rotation by quarters·90° counter-clockwise that brings a mesh onto an image.
struct QuarterTurn {
  int quarters = 0;  // 0 … 3
  double rms = 0;    // of the outlines after it, each about its own centre [px]
};

// Some published meshes are turned by 90° against their images: four of the 40 meshes of fabrics
// 1–5, which fit to 1.2–1.9 px after the turn, as the others do without one (the next best turn
// leaves 2.2 px or more). One mesh fits at no turn: it belongs to another capture. std::nullopt
// when an outline has gaps.
std::optional<QuarterTurn> FindQuarterTurn(const ObjSurface& surface, const GrayImage& image,
                                           const Camera& camera);

}  // namespace drape
