// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/job/plot/chart.h"

namespace drape {

// The description of a picture for a page that draws it (drape_report): the fields of Picture and
// Chart by name, without the places that only a picture of a fixed size has. Numbers have six
// digits; one that is not finite is null. Empty texts and lists are left out.
nlohmann::ordered_json PictureJson(const Picture& picture);

// Its text in one line; bytes of a text that are not UTF-8 are replaced.
std::string PictureText(const Picture& picture);

// The file that has it, beside a picture: "out/map.png" → "out/map.chart.json".
std::string ChartPath(const std::string& picture_path);

}  // namespace drape
