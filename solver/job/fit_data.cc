// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_data.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> Expand(const std::string& text, const std::string& what,
                                const std::set<std::string>& extensions,
                                const std::string& expected) {
  std::vector<std::string> files;
  for (const std::string& item : SplitPaths(text)) {
    std::vector<std::string> found;
    if (fs::is_regular_file(item)) {  // its name may look like a pattern
      found.push_back(item);
    } else if (fs::is_directory(item)) {
      for (const fs::directory_entry& entry : fs::directory_iterator(item))
        if (extensions.contains(entry.path().extension())) found.push_back(entry.path());
      std::sort(found.begin(), found.end());
    } else {
      glob_t matches = {};
      if (glob(item.c_str(), 0, nullptr, &matches) == 0)
        found.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
      globfree(&matches);
    }
    if (found.empty())
      throw InputError(what, "'" + item + "' matches nothing, expected " + expected);
    files.insert(files.end(), found.begin(), found.end());
  }
  for (const std::string& file : files)
    if (!IsUtf8(file)) throw InputError(what, "found '" + file + "', expected a name in UTF-8");
  return files;
}

Selection MakeSelection(const FitSelection& chosen) {
  return {.fabrics = {chosen.fabric},
          .samples = ParseIndexList(chosen.samples, "option 'samples'"),
          .captures = ParseIndexList(chosen.captures, "option 'captures'"),
          .face = ParseClothFace(chosen.face)};
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

std::vector<std::string> ExpandImages(const std::string& text) {
  return Expand(text, "images", {".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG"},
                "an image, a folder with .jpg or .png files, or a pattern");
}

std::vector<std::string> ExpandLabMeasurements(const std::string& text) {
  return Expand(text, "lab_tests", {".json", ".JSON"},
                "a measurement file, a folder with .json files, or a pattern");
}

void SelectCaptures(const FitSelection& selection, FitData* data) {
  if (selection.fabric == 0)
    throw InputError("option 'data_fabric'", "not given, expected the fabric of --data to fit");
  const Dataset dataset = ReadDataset(selection.folder);
  for (const FileNote& note : dataset.notes) data->log_lines.push_back(MakeLine("note: ", note));
  for (const FileNote& note : dataset.skipped)
    data->log_lines.push_back(MakeLine("skipped: ", note));
  std::vector<FileNote> skipped;
  const std::vector<Capture> usable =
      KeepUsable(Select(dataset, MakeSelection(selection)), &skipped);
  for (const FileNote& note : skipped) data->notes.push_back(MakeLine("skipped: ", note));
  UseCaptures(usable, data);
}

void UseCaptures(const std::vector<Capture>& captures, FitData* data) {
  data->captures.clear();
  for (const Capture& capture : captures) {
    if (data->source == ObservationSource::kMeshes && capture.mesh.empty())
      data->notes.push_back("skipped: " + capture.Name() + " has no mesh of its own");
    else
      data->captures.push_back(capture);
  }
  if (data->captures.empty())
    throw InputError("data", std::string("no usable capture to fit, expected some with ") +
                                 ToString(data->source));
  const int fabric = data->captures[0].fabric;
  if (data->density == 0.0) {
    const auto density = PublishedDensity(fabric);
    if (!density)
      throw InputError("option 'density'", "not given, and none is published for fabric " +
                                               std::to_string(fabric) +
                                               ", expected the density as weighed");
    data->density = *density;
  }
  if (data->specimens.empty()) data->specimens = ListSpecimens(data->captures);
}

}  // namespace drape
