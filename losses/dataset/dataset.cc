// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/dataset.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <tuple>

#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

std::optional<int> NumberIn(const std::smatch& match, int group) {
  if (!match[group].matched) return std::nullopt;
  return std::stoi(match[group].str());
}

// The name in lower case, with blanks and hyphens as underscores.
std::string PlainName(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name)
    plain += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(c));
  return plain;
}

// Parsers of the file names of the public data set. Each takes a name without its extension and
// returns std::nullopt when the name does not have the form.
struct CaptureName {
  std::optional<int> fabric;
  int sample = 0, capture = 0;
};

std::optional<CaptureName> ParseCaptureName(const std::string& stem) {
  static const std::regex pattern(
      "(?:fabric_?(\\d{1,4})_)?sample_?(\\d{1,4})"
      "(?:_(?:(?:obs|observation|capture)_?)?(\\d{1,4}))?(?:_circle_\\d+)?");
  const std::string plain = PlainName(stem);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return CaptureName{NumberIn(match, 1), *NumberIn(match, 2), NumberIn(match, 3).value_or(1)};
}

// "Fabric 7" → 7.
std::optional<int> ParseFabricFolder(const std::string& name) {
  static const std::regex pattern("fabric_?(\\d{1,4})");
  const std::string plain = PlainName(name);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return NumberIn(match, 1);
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

void CountTrainingImages(const fs::path& folder, Dataset* dataset) {
  static const std::regex pattern(
      "(?:.*_)?sample_?\\d{1,4}_(?:upward|downward)_drape_?\\d{1,4}"
      "(?:_(?:obs|observation)_?\\d{1,4})?");
  if (!fs::is_directory(folder)) return;
  for (const fs::path& file : FilesBelow(folder)) {
    if (std::regex_match(PlainName(file.stem().string()), pattern)) {
      ++dataset->training_images;
    } else {
      dataset->skipped.push_back({file.string(), "its name has no sample, face and drape"});
    }
  }
}

// Adds the numbers of one part of a list, "3" or "3-5".
void AddIndices(const std::string& part, const std::string& where, std::set<int>* numbers) {
  static const std::regex pattern("0*([1-9]\\d{0,3})(?:-0*([1-9]\\d{0,3}))?");
  const auto fail = [&](const char* expected) {
    throw InputError(where, "found '" + part + "', expected " + expected);
  };
  std::smatch match;
  if (!std::regex_match(part, match, pattern))
    fail("whole numbers from 1 to 9999 and ranges like 3-5, with commas between them");
  const int first = *NumberIn(match, 1), last = NumberIn(match, 2).value_or(first);
  if (last < first) fail("an ascending range");
  for (int number = first; number <= last; ++number) numbers->insert(number);
}

constexpr char kSplitFormat[] = "drapefit-split";

using Sample = std::pair<int, int>;  // fabric, sample
Sample MakeSample(const Capture& capture) { return {capture.fabric, capture.sample}; }

// Returns the first `count` items of a random order (shuffle of Fisher and Yates).
std::vector<int> SelectRandomly(std::vector<int> items, int count, std::mt19937_64& random) {
  for (int i = 0; i < count; ++i) {
    const double left = static_cast<double>(items.size()) - i;
    std::swap(items[i], items[i + static_cast<size_t>(left * SampleUniform(random))]);
  }
  items.resize(count);
  return items;
}

nlohmann::ordered_json SideJson(const std::vector<Capture>& captures) {
  auto side = nlohmann::ordered_json::array();
  for (const Capture& c : captures) side.push_back({c.fabric, c.sample, c.capture});
  return side;
}

std::vector<Capture> ReadSide(const JsonInput& side, const Dataset& dataset) {
  std::vector<Capture> captures;
  side.ExpectArray();
  for (int i = 0; i < side.Size(); ++i) {
    const JsonInput entry = side.At(i);
    entry.ExpectArray(3);
    const auto wanted =
        std::tuple(entry.At(0).Integer(), entry.At(1).Integer(), entry.At(2).Integer());
    const auto found = std::find_if(
        dataset.captures.begin(), dataset.captures.end(),
        [&](const Capture& c) { return std::tuple(c.fabric, c.sample, c.capture) == wanted; });
    if (found == dataset.captures.end())
      throw InputError(entry.Name(), "the data set lacks this fabric, sample, capture");
    captures.push_back(*found);
  }
  return captures;
}

void CheckDisjoint(const Split& split, const std::string& path) {
  std::set<Sample> train;
  for (const Capture& capture : split.train) train.insert(MakeSample(capture));
  for (const Capture& capture : split.held_out) {
    if (train.contains(MakeSample(capture)))
      throw InputError(path, "the sample of " + capture.Name() + " is on both sides");
  }
}

constexpr int kTurnAngles = 360, kTurnSupersample = 2;

bool HasFillerVt(const ObjContent& content) {
  return content.vt.size() == content.v.size() + 1 && content.vt[0].isZero(0);
}

std::optional<Eigen::VectorXd> CentredProfile(const GrayImage& image, Camera camera) {
  Outline outline;
  if (!CentreOnOutline(image, &camera) || !OutlineFromImage(image, camera, kTurnAngles, &outline))
    return {};
  return outline.radius;
}

// The profile r(θ) turned counter-clockwise by `shift` angles.
Eigen::VectorXd Shifted(const Eigen::VectorXd& radius, Eigen::Index shift) {
  Eigen::VectorXd turned(radius.size());
  turned << radius.tail(shift), radius.head(radius.size() - shift);
  return turned;
}

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
                     Format("misses its image by %s px, expected at most 3: it belongs to "
                            "another capture",
                            FormatBeyond(turn->rms, kMaxMeshRms, 1).c_str()));
  }
  capture->mesh_quarters = turn->quarters;
}

}  // namespace

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
    CountTrainingImages((has_data ? root : root / "..") / "bnn_image_gt", &dataset);
  } catch (const fs::filesystem_error& error) {
    throw IoError(folder, std::string("cannot be listed: ") + error.what());
  }
  return dataset;
}

std::vector<int> ParseIndexList(const std::string& text, const std::string& where) {
  std::set<int> numbers;
  for (size_t begin = 0; !text.empty();) {
    const size_t comma = text.find(',', begin);
    AddIndices(text.substr(begin, comma - begin), where, &numbers);
    if (comma == std::string::npos) break;
    begin = comma + 1;
  }
  return {numbers.begin(), numbers.end()};
}

std::string IndexListText(const std::vector<int>& numbers) {
  std::ostringstream text;
  for (size_t i = 0; i < numbers.size();) {
    size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text << (i == 0 ? "" : ",") << numbers[i];
    if (last > i) text << '-' << numbers[last];
    i = last + 1;
  }
  return text.str();
}

Split SplitBySample(const std::vector<Capture>& captures, int train_samples, uint64_t seed) {
  CHECK_GE(train_samples, 1);
  std::map<int, std::set<int>> samples;  // of each fabric
  for (const Capture& capture : captures) samples[capture.fabric].insert(capture.sample);
  std::mt19937_64 random(seed);
  std::set<Sample> train;
  for (const auto& [fabric, all] : samples) {
    if (static_cast<int>(all.size()) <= train_samples) {
      throw InputError("train", "found " + std::to_string(train_samples) +
                                    " training samples, expected fewer than the " +
                                    std::to_string(all.size()) + " of fabric " +
                                    std::to_string(fabric));
    }
    for (const int sample : SelectRandomly({all.begin(), all.end()}, train_samples, random))
      train.insert({fabric, sample});
  }
  Split split{seed, {}, {}};
  for (const Capture& capture : captures)
    (train.contains(MakeSample(capture)) ? split.train : split.held_out).push_back(capture);
  return split;
}

void WriteSplit(const std::string& path, const Split& split) {
  const nlohmann::ordered_json json = {{"format", kSplitFormat},
                                       {"seed", split.seed},
                                       {"train", SideJson(split.train)},
                                       {"held_out", SideJson(split.held_out)}};
  WriteFileAtomically(path, json.dump() + "\n");
}

Split ReadSplit(const std::string& path, const Dataset& dataset) {
  const nlohmann::json json = ReadJsonFile(path);
  const JsonInput input(json, path);
  input.ExpectKeys({"format", "seed", "train", "held_out"});
  if (input.At("format").String() != kSplitFormat) input.At("format").Fail(kSplitFormat);
  if (!input.At("seed").value().is_number_unsigned())
    input.At("seed").Fail("a whole number that is not negative");
  Split split{input.At("seed").value().get<uint64_t>(), ReadSide(input.At("train"), dataset),
              ReadSide(input.At("held_out"), dataset)};
  CheckDisjoint(split, path);
  return split;
}

std::optional<double> PublishedDensity(int fabric) {
  static constexpr std::array kDensities = {.059, .192, .213, .114, .274, .183, .100, .230, .249,
                                            .204, .148, .313, .107, .139, .211, .191, .278, .154,
                                            .282, .259, .186, .231, .163, .104, .060};
  if (fabric < 1 || fabric > static_cast<int>(kDensities.size())) return {};
  return kDensities[fabric - 1];
}

PublishedMesh ReadPublishedMesh(const std::string& path) {
  const ObjContent content = ParseObj(ReadWholeFile(path), path, false);
  PublishedMesh mesh;
  mesh.surface = ReadObjSurface(path);
  if (content.vt.empty()) return mesh;
  if (content.vt.size() != content.v.size() && !HasFillerVt(content)) {
    throw InputError(path,
                     "found " + std::to_string(content.vt.size()) + " vt for " +
                         std::to_string(content.v.size()) +
                         " v, expected no vt, as many as v, or one more with a first line 0 0");
  }
  mesh.cloth = ReadObj(path, {.first_vt_is_dummy = HasFillerVt(content)});
  return mesh;
}

std::optional<QuarterTurn> FindQuarterTurn(const ObjSurface& surface, const GrayImage& image,
                                           const Camera& camera) {
  const auto measured = CentredProfile(image, camera);
  const auto seen = CentredProfile(Rasterize(surface, camera, kTurnSupersample), camera);
  if (!measured || !seen) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  QuarterTurn best{0, kInfinity};
  for (int quarters = 0; quarters < 4; ++quarters) {
    const double rms = ProfileRms(*measured, Shifted(*seen, quarters * kTurnAngles / 4));
    if (rms < best.rms) best = {quarters, rms};
  }
  return best;
}

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
