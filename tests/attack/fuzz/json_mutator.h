// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <random>

namespace drape::attack {

// Changes one random value of a document: to another type, an extreme number, a copy of another
// value of the document, one element or member fewer, or one element twice.
void MutateJson(nlohmann::json* document, std::mt19937& random);

}  // namespace drape::attack
