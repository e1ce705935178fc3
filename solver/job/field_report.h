// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/fit/protocol/field_fit.h"

namespace drape {

// How the stiffness of a fitted cloth varies: numbers, files and pictures of a FieldFit.

// The maps of WriteFields.
inline constexpr const char* kFieldPictures[] = {"field_stretch.png", "field_bend.png",
                                                 "posterior_ratio_stretch.png",
                                                 "posterior_ratio_bend.png"};

// For summary.json.
nlohmann::ordered_json FieldJson(const FieldFit& fit, const FieldOptions& options);

// For a person, two lines: stretch and bend, mean and scatter over the cloth.
std::string FieldTable(const FieldFit& fit);

// Writes material.json (WriteMaterialField) and the maps field_stretch.png (membrane stiffness,
// mean over rows of c11 and c22 [N/m]), field_bend.png (plate rigidity D, mean over the table
// [µN m]), posterior_ratio_stretch.png and posterior_ratio_bend.png (posterior over prior standard
// deviation of the log factor: 1 where the image contains no information). Returns why there are no
// maps if gnuplot is missing, else an empty text. Throws InputError when a file cannot be
// written.
std::string WriteFields(const std::string& folder, const Mesh& mesh, const FieldFit& fit,
                        const std::string& source);

}  // namespace drape
