// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/laws/law.h"
#include "physics/material/material_io.h"
#include "physics/util/options/field.h"

namespace drape {

// The laws that a user can choose, each for stretch and bend alike.
enum class LawKind { kReference, kSmooth };
constexpr auto EnumNames(LawKind) {
  return MakeNames<LawKind>({{LawKind::kReference, "reference"}, {LawKind::kSmooth, "smooth"}});
}
inline Law MakeLaw(LawKind kind) { return MakeLaw(std::string(ToString(kind))); }

}  // namespace drape
