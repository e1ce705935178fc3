// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "physics/mesh/mesh.h"
#include "solver/fit/protocol/field_fit.h"

namespace drape {

// The fields of a fit for the summary: [N/m] and [N m] over the cloth, and what the data determine.
nlohmann::ordered_json FieldJson(const FieldFit& fit, const FieldOptions& options);

// Lines for a person: stretch and bend, mean and scatter over the cloth.
std::string FieldTable(const FieldFit& fit);

inline constexpr char kFieldsFile[] = "fields.json";

// Writes material.json and kFieldsFile, which the page of the fit draws over the plane of the
// cloth: on faces the membrane stiffness (mean of c11 and c22), on hinges the plate rigidity, and
// the posterior over the prior standard deviation of the log factors (1 where the image contains no
// information). A hinge is two vertices and two faces. Throws IoError when a file cannot be
// written.
void WriteFields(const std::string& folder, const Mesh& mesh, const FieldFit& fit, bool warp_known,
                 const std::string& source);

}  // namespace drape
