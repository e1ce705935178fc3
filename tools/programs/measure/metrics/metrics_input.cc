// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/measure/metrics/metrics_input.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>

#include "losses/image/segmentation.h"
#include "losses/outline/outline.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool IsMesh(const fs::path& path) { return LowerExtension(path) == ".obj"; }

bool IsImage(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

template <class Wanted>
std::vector<std::string> FilesIn(const std::string& folder, const Wanted& wanted) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (wanted(entry.path())) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> DrapesOfRun(const std::string& run) {
  const auto files = FilesIn(run, [](const fs::path& path) {
    return IsMesh(path) && path.filename().string().starts_with("drape");
  });
  if (files.empty()) throw InputError(run, "the run has no drape.obj or drape_<name>.obj");
  return files;
}

}  // namespace

OperandKind KindOfOperand(const std::string& path) {
  if (!fs::exists(path)) throw InputError(path, "no such file or folder");
  if (!fs::is_directory(path)) return OperandKind::kFile;
  return fs::exists(fs::path(path) / "summary.json") ? OperandKind::kRun : OperandKind::kFolder;
}

ViewedFile ViewFile(const std::string& path, const View& view) {
  if (IsMesh(path)) {
    const Camera camera = MakeCamera(view.camera, view.discs);
    const ObjSurface surface = ReadObjSurface(path);
    return {path, ObserveSurface(surface, camera, view.discs, path), camera, {}, surface};
  }
  MeasuredImage measured =
      MeasureImage(ReadSilhouette(path), view.camera, view.centre, view.discs, path);
  if (view.hard_edged) measured.image = HardEdged(measured.image);
  return {path,
          ObserveImage(measured.image, measured.camera, view.discs, path),
          measured.camera,
          std::move(measured.quality),
          {}};
}

ViewedFile ViewFileBeside(const std::string& path, const View& view, const Camera& camera) {
  View same = view;
  same.camera.width = camera.width;
  same.camera.height = camera.height;
  ViewedFile file = ViewFile(path, same);
  if (view.centre == CentreMode::kNominal) return file;
  if (file.surface && !CentreOnOutline(file.seen.image, &file.camera))
    throw InputError(path, "no closed outline around the support's centre");
  file.seen =
      ObserveImage(MovedImage(file.seen.image, file.camera, camera), camera, view.discs, path);
  return file;
}

Camera FindCamera(const CameraInput& input, const DrapeDiscs& discs,
                  const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (!IsMesh(file)) return MakeCamera(input, ReadImage(file), discs, file);
  return MakeCamera(input, discs);
}

std::vector<std::pair<std::string, std::string>> PairDrapes(const std::string& run_a,
                                                            const std::string& run_b,
                                                            std::vector<std::string>* alone) {
  const auto of_a = DrapesOfRun(run_a), of_b = DrapesOfRun(run_b);
  if (of_a.size() == 1 && of_b.size() == 1) return {{of_a[0], of_b[0]}};
  std::map<std::string, std::string> by_name;
  for (const std::string& path : of_b) by_name[fs::path(path).filename().string()] = path;
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& path : of_a) {
    const auto match = by_name.find(fs::path(path).filename().string());
    if (match == by_name.end()) {
      alone->push_back(path);
    } else {
      pairs.emplace_back(path, match->second);
      by_name.erase(match);
    }
  }
  for (const auto& [name, path] : by_name) alone->push_back(path);
  if (pairs.empty()) throw InputError(run_b, "has no drape of the same name as " + run_a);
  return pairs;
}

std::vector<std::string> DrapesIn(const std::string& folder, size_t least) {
  const auto files =
      FilesIn(folder, [](const fs::path& path) { return IsMesh(path) || IsImage(path); });
  if (files.size() < least) {
    throw InputError(folder, "found " + std::to_string(files.size()) +
                                 " images and meshes, expected at least " + std::to_string(least));
  }
  return files;
}

}  // namespace drape
