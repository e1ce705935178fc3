// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/util/options/field.h"

namespace drape {

// Specimen and support as a user sets them: diameters [m].
struct DiscsInput {
  static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

  double specimen = kNotGiven;  // not given: what the files say that the drapes are from, or that
  double support = kNotGiven;   // of the published drapes
};

template <MutableOrConst<DiscsInput> Input, class Visitor>
void VisitFields(Input& input, Visitor&& visit) {
  auto& [specimen, support] = input;
  visit(specimen, Field{.key = "specimen",
                        .doc = "diameter of the flat specimen; none: as the files of this drape "
                               "say that drapefit made, or 0.30",
                        .unit = "m",
                        .least = 0.01,
                        .most = 10});
  visit(support, Field{.key = "support",
                       .doc = "diameter of the support; none: as those files say, or 0.18",
                       .unit = "m",
                       .least = 0.005,
                       .most = 10});
}

// What a file says of the discs of its drape: a PNG of WritePng, an OBJ of WriteObj, or a JSON file
// with DiscsJson, as drape_photo and drape_fit write it. None in any other file, or where there is
// no file.
std::optional<DrapeDiscs> StoredDiscs(const std::string& file);

// The discs of drapes in `files`, which may be of any kind. Throws InputError where a file
// contradicts the user or another file, since drapes of different discs cannot be compared, and for
// a support that is not smaller than the specimen.
DrapeDiscs FindDiscs(const DiscsInput& input, const std::vector<std::string>& files = {});

// As a user would set them.
DiscsInput GivenDiscs(const DrapeDiscs& discs);

// {"specimen_diameter_m", "support_diameter_m"}.
nlohmann::ordered_json DiscsJson(const DrapeDiscs& discs);

}  // namespace drape
