// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_captures.h"

#include <iterator>
#include <set>

#include "losses/dataset/index_list.h"
#include "losses/dataset/published_density.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

Selection MakeSelection(const FitSelection& chosen) {
  Selection selection{.fabrics = {chosen.fabric},
                      .samples = ParseIndexList(chosen.samples, "option 'samples'"),
                      .captures = ParseIndexList(chosen.captures, "option 'captures'")};
  if (chosen.face == "up") selection.face = ClothFace::kUp;
  if (chosen.face == "down") selection.face = ClothFace::kDown;
  return selection;
}

std::string MakeLine(const char* what, const FileNote& note) {
  const bool named = note.text.starts_with(note.path);
  return std::string(what) + (named ? "" : note.path + ": ") + note.text;
}

// The number of each capture's sample among the samples, from 1.
std::vector<int> ListSpecimens(const std::vector<Capture>& captures) {
  std::set<int> samples;
  for (const Capture& capture : captures) samples.insert(capture.sample);
  std::vector<int> specimens;
  for (const Capture& capture : captures)
    specimens.push_back(
        1 + static_cast<int>(std::distance(samples.begin(), samples.find(capture.sample))));
  return specimens;
}

}  // namespace

void SelectCaptures(const FitSelection& selection, FitJob* job) {
  if (selection.fabric == 0)
    throw InputError("option 'fabric'", "none, expected the fabric of --data to fit");
  const Dataset dataset = ReadDataset(selection.folder);
  for (const FileNote& note : dataset.notes) job->log_lines.push_back(MakeLine("note: ", note));
  for (const FileNote& note : dataset.skipped)
    job->log_lines.push_back(MakeLine("skipped: ", note));
  std::vector<FileNote> skipped;
  const std::vector<Capture> usable =
      KeepUsable(Select(dataset, MakeSelection(selection)), &skipped);
  for (const FileNote& note : skipped) job->notes.push_back(MakeLine("skipped: ", note));
  UseCaptures(usable, job);
}

void UseCaptures(const std::vector<Capture>& captures, FitJob* job) {
  job->captures.clear();
  for (const Capture& capture : captures) {
    if (job->targets == ObservationSource::kMeshes && capture.mesh.empty())
      job->notes.push_back("skipped: " + capture.Name() + " has no mesh of its own");
    else
      job->captures.push_back(capture);
  }
  if (job->captures.empty())
    throw InputError("data", std::string("no usable capture to fit, expected some with ") +
                                 ToString(job->targets));
  const int fabric = job->captures[0].fabric;
  if (job->density == 0.0) {
    const auto density = PublishedDensity(fabric);
    if (!density)
      throw InputError("option 'density'", "none, and none is published for fabric " +
                                               std::to_string(fabric) +
                                               ", expected the density as weighed");
    job->density = *density;
  }
  if (job->posterior.specimen.empty()) job->posterior.specimen = ListSpecimens(job->captures);
}

}  // namespace drape
