// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "losses/dataset/dataset.h"
#include "losses/dataset/dataset_split.h"
#include "losses/dataset/published_mesh.h"
#include "losses/image/segmentation.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// Keeps the captures whose `number` is one of `wanted`. Throws InputError unless all of these
// occur.
void Keep(const char* what, int Capture::*number, const std::vector<int>& wanted,
          std::vector<Capture>* captures) {
  if (wanted.empty()) return;
  std::set<int> there;
  for (const Capture& capture : *captures) there.insert(capture.*number);
  for (const int value : wanted) {
    if (there.contains(value)) continue;
    throw InputError(what, "found " + std::to_string(value) + ", expected some of " +
                               IndexListText({there.begin(), there.end()}));
  }
  std::erase_if(*captures, [&](const Capture& capture) {
    return std::find(wanted.begin(), wanted.end(), capture.*number) == wanted.end();
  });
}

// Finds the quarter turn that brings the mesh onto the image.
void TurnMesh(Capture* capture) {
  const auto turn = FindQuarterTurn(ReadPublishedMesh(capture->mesh).surface,
                                    ReadSilhouette(capture->image).image, Camera());
  if (!turn) throw InputError(capture->mesh, "its outline or that of its image has gaps");
  if (turn->rms > kMaxMeshRms) {
    throw InputError(capture->mesh,
                     Format("misses its image by %.1f px, expected at most 3: it belongs to "
                            "another capture",
                            turn->rms));
  }
  capture->mesh_quarters = turn->quarters;
}

}  // namespace

std::vector<Capture> Select(const Dataset& dataset, const Selection& selection) {
  std::vector<Capture> captures = dataset.captures;
  Keep("fabric", &Capture::fabric, selection.fabrics, &captures);
  Keep("samples", &Capture::sample, selection.samples, &captures);
  Keep("captures", &Capture::capture, selection.captures, &captures);
  if (selection.face)
    std::erase_if(captures, [&](const Capture& c) { return c.face != *selection.face; });
  if (captures.empty()) {
    const std::string face = selection.face ? " with face " + ClothFaceName(*selection.face) : "";
    throw InputError("data", "no capture of the selection" + face + ", " +
                                 std::to_string(dataset.captures.size()) + " in all");
  }
  return captures;
}

std::vector<Capture> KeepUsable(std::vector<Capture> captures, std::vector<FileNote>* skipped) {
  const auto works = [&](const std::string& path, const auto& use) {
    try {
      use();
      return true;
    } catch (const InputError& error) {
      skipped->push_back({path, error.what()});
      return false;
    }
  };
  std::erase_if(captures, [&](const Capture& capture) {
    return !works(capture.image, [&] { ReadSilhouette(capture.image); });
  });
  for (Capture& capture : captures) {
    if (capture.mesh.empty()) continue;
    if (!works(capture.mesh, [&] { TurnMesh(&capture); })) capture.mesh.clear();
  }
  return captures;
}

}  // namespace drape
