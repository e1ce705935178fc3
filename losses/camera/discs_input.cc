// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/discs_input.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

constexpr const char* kSpecimen = "specimen_diameter_m";
constexpr const char* kSupport = "support_diameter_m";

std::optional<DrapeDiscs> DiscsOfJson(const std::string& path) {
  const nlohmann::json json = ReadJsonFile(path);
  if (!json.is_object() || !json.contains(kSpecimen)) return std::nullopt;
  const JsonInput input(json, path);
  const DrapeDiscs discs{input.At(kSpecimen).Number() / 2, input.At(kSupport).Number() / 2};
  if (!(discs.support > 0.0 && discs.support < discs.specimen))
    throw InputError(path, "found " + ToString(discs) +
                               ", expected a support that is smaller than the specimen");
  return discs;
}

DrapeDiscs WithGiven(const DiscsInput& input, DrapeDiscs discs) {
  if (!std::isnan(input.specimen)) discs.specimen = input.specimen / 2;
  if (!std::isnan(input.support)) discs.support = input.support / 2;
  return discs;
}

}  // namespace

std::optional<DrapeDiscs> StoredDiscs(const std::string& file) {
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const std::string extension = std::filesystem::path(file).extension();
  if (extension == ".obj") return ReadObjDiscs(file);
  if (extension == ".json") return DiscsOfJson(file);
  return ReadPngDiscs(file);
}

DrapeDiscs FindDiscs(const DiscsInput& input, const std::vector<std::string>& files) {
  std::optional<DrapeDiscs> found;
  std::string first;
  for (const std::string& file : files) {
    const std::optional<DrapeDiscs> stored = StoredDiscs(file);
    if (!stored) continue;
    if (WithGiven(input, *stored) != *stored)
      throw InputError(file, "is of a specimen of " + ToString(*stored) + ", expected " +
                                 ToString(WithGiven(input, *stored)) +
                                 " as options 'specimen' and 'support' say");
    if (found && *found != *stored)
      throw InputError(file, "is of a specimen of " + ToString(*stored) + ", expected " +
                                 ToString(*found) + " as " + first +
                                 ": drapes of different sizes cannot be compared");
    if (!found) first = file;
    found = stored;
  }
  const DrapeDiscs discs = WithGiven(input, found.value_or(DrapeDiscs()));
  if (!(discs.support < discs.specimen))
    throw InputError("option 'support'", "found " + ToString(discs) +
                                             ", expected a support that is smaller than the "
                                             "specimen");
  return discs;
}

DiscsInput GivenDiscs(const DrapeDiscs& discs) { return {2 * discs.specimen, 2 * discs.support}; }

nlohmann::ordered_json DiscsJson(const DrapeDiscs& discs) {
  return {{kSpecimen, 2 * discs.specimen}, {kSupport, 2 * discs.support}};
}

}  // namespace drape
