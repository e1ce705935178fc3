// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/dataset.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <tuple>

#include "physics/util/errors.h"

namespace drape {
namespace {

std::optional<int> NumberIn(const std::smatch& match, int group) {
  if (!match[group].matched) return std::nullopt;
  return std::stoi(match[group].str());
}

namespace fs = std::filesystem;

enum class FileKind { kImage, kMesh, kOther };

// Classifies a file by its extension and by the folders between the fabric's folder and the file.
FileKind FindKind(const fs::path& below_fabric) {
  bool in_silhouettes = false, in_meshes = false;
  for (const fs::path& part : below_fabric.parent_path()) {
    const std::string name = PlainName(part.string());
    in_silhouettes |= name == "silhouettes" || name == "silouettes";
    in_meshes |= name == "meshes";
  }
  const std::string extension = PlainName(below_fabric.extension().string());
  const bool is_image = extension == ".jpg" || extension == ".jpeg" || extension == ".png";
  if (is_image && in_silhouettes) return FileKind::kImage;
  return extension == ".obj" && in_meshes ? FileKind::kMesh : FileKind::kOther;
}

std::vector<fs::path> SortedEntries(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(folder)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

std::vector<fs::path> FilesBelow(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

ClothFace CaptureFace(int capture) {
  if (capture <= 2) return ClothFace::kUp;
  return capture <= 4 ? ClothFace::kDown : ClothFace::kUnknown;
}

// The capture number of the image of a mesh: fabrics 11–20 number the two faces the other way
// round.
int CaptureOfMesh(int fabric, int capture) {
  if (fabric < 11 || fabric > 20 || capture > 4) return capture;
  return capture <= 2 ? capture + 2 : capture - 2;
}

using Key = std::tuple<int, int, int>;  // fabric, sample, capture

// Collects the files of all fabrics; Finish joins images and meshes.
class CaptureList {
 public:
  explicit CaptureList(Dataset* dataset) : dataset_(*dataset) {}

  void AddFabric(int fabric, const fs::path& folder) {
    for (const fs::path& file : FilesBelow(folder)) {
      const FileKind kind = FindKind(file.lexically_relative(folder));
      const auto name = ParseCaptureName(file.stem().string());
      if (kind == FileKind::kOther) {
        Skip(file, "neither an image in 'silhouettes' nor an .obj in 'meshes'");
      } else if (!name) {
        Skip(file, "its name has no sample and capture");
      } else {
        Add(kind, fabric, *name, file);
      }
    }
  }

  void Finish() {
    for (const auto& [key, image] : images_) {
      const auto [fabric, sample, capture] = key;
      const auto mesh = meshes_.find(key);
      dataset_.captures.push_back({fabric, sample, capture, CaptureFace(capture), image,
                                   mesh == meshes_.end() ? "" : mesh->second});
    }
    for (const auto& [key, mesh] : meshes_)
      if (!images_.contains(key)) Skip(mesh, "a mesh without an image of its capture");
  }

 private:
  void Add(FileKind kind, int fabric, const CaptureName& name, const fs::path& file) {
    const bool is_mesh = kind == FileKind::kMesh;
    const int capture = is_mesh ? CaptureOfMesh(fabric, name.capture) : name.capture;
    auto& files = is_mesh ? meshes_ : images_;
    const auto [it, fresh] = files.try_emplace({fabric, name.sample, capture}, file.string());
    if (!fresh) return Skip(file, "the same capture as " + it->second);
    if (name.fabric.value_or(fabric) == fabric) return;
    dataset_.notes.push_back({file.string(), "named as fabric " + std::to_string(*name.fabric) +
                                                 ", used as that of its folder, " +
                                                 std::to_string(fabric)});
  }

  void Skip(const fs::path& file, const std::string& why) {
    dataset_.skipped.push_back({file.string(), why});
  }

  Dataset& dataset_;
  std::map<Key, std::string> images_, meshes_;
};

bool HasFabrics(const fs::path& folder) {
  if (!fs::is_directory(folder)) return false;
  const auto entries = SortedEntries(folder);
  return std::any_of(entries.begin(), entries.end(), [](const fs::path& entry) {
    return fs::is_directory(entry) && ParseFabricFolder(entry.filename().string());
  });
}

void ReadFabrics(const fs::path& folder, Dataset* dataset) {
  CaptureList list(dataset);
  for (const fs::path& entry : SortedEntries(folder)) {
    const auto fabric = ParseFabricFolder(entry.filename().string());
    if (fabric && fs::is_directory(entry)) {
      list.AddFabric(*fabric, entry);
    } else {
      dataset->skipped.push_back(
          {entry.string(), "not the folder of a fabric, expected 'Fabric N'"});
    }
  }
  list.Finish();
}

void ReadTrainingImages(const fs::path& folder, Dataset* dataset) {
  if (!fs::is_directory(folder)) return;
  for (const fs::path& file : FilesBelow(folder)) {
    auto image = ParseTrainingName(file.stem().string());
    if (!image) {
      dataset->skipped.push_back({file.string(), "its name has no sample, face and drape"});
      continue;
    }
    image->fabric = file.parent_path().filename().string();
    image->image = file.string();
    dataset->training_images.push_back(*image);
  }
  std::stable_sort(dataset->training_images.begin(), dataset->training_images.end(),
                   [](const TrainingImage& a, const TrainingImage& b) {
                     return std::tie(a.fabric, a.sample, a.face) <
                            std::tie(b.fabric, b.sample, b.face);
                   });
}

}  // namespace

std::string PlainName(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name)
    plain += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(c));
  return plain;
}

std::optional<CaptureName> ParseCaptureName(const std::string& stem) {
  static const std::regex pattern(
      "(?:fabric_?(\\d{1,4})_)?sample_?(\\d{1,4})"
      "(?:_(?:(?:obs|observation|capture)_?)?(\\d{1,4}))?(?:_circle_\\d+)?");
  const std::string plain = PlainName(stem);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return CaptureName{NumberIn(match, 1), *NumberIn(match, 2), NumberIn(match, 3).value_or(1)};
}

std::optional<TrainingImage> ParseTrainingName(const std::string& stem) {
  static const std::regex pattern(
      "(?:.*_)?sample_?(\\d{1,4})_(upward|downward)_drape_?(\\d{1,4})"
      "(?:_(?:obs|observation)_?(\\d{1,4}))?");
  const std::string plain = PlainName(stem);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  TrainingImage image;
  image.sample = *NumberIn(match, 1);
  image.face = match[2] == "upward" ? ClothFace::kUp : ClothFace::kDown;
  image.drape = *NumberIn(match, 3);
  image.observation = NumberIn(match, 4).value_or(0);
  return image;
}

std::optional<int> ParseFabricFolder(const std::string& name) {
  static const std::regex pattern("fabric_?(\\d{1,4})");
  const std::string plain = PlainName(name);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return NumberIn(match, 1);
}

std::optional<ClothFace> ParseClothFace(const std::string& name) {
  for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown})
    if (name == ClothFaceName(face)) return face;
  return {};
}

std::string ClothFaceName(ClothFace face) {
  if (face == ClothFace::kUnknown) return "unknown";
  return face == ClothFace::kUp ? "up" : "down";
}

std::string Capture::Name() const {
  return "fabric " + std::to_string(fabric) + ", sample " + std::to_string(sample) + ", capture " +
         std::to_string(capture);
}

Dataset ReadDataset(const std::string& folder) {
  const fs::path root = folder, data = root / "data";
  Dataset dataset;
  try {
    const bool has_data = HasFabrics(data);
    if (!has_data && !HasFabrics(root)) {
      throw InputError(folder,
                       std::string(fs::is_directory(root) ? "has no fabric" : "is not a folder") +
                           ", expected data/Fabric N/silhouettes");
    }
    ReadFabrics(has_data ? data : root, &dataset);
    ReadTrainingImages((has_data ? root : root / "..") / "bnn_image_gt", &dataset);
  } catch (const fs::filesystem_error& error) {
    throw InputError(folder, std::string("cannot be listed: ") + error.what());
  }
  return dataset;
}

}  // namespace drape
