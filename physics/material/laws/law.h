// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>

#include "physics/material/laws/laws.h"
#include "physics/material/material_io.h"

namespace drape {

// How stiffness depends on strain and on curvature: two independent choices.
struct Law {
  std::variant<SmoothStretch, ReferenceStretch> stretch;
  std::variant<SmoothBend, ReferenceBend> bend;

  bool rejects_negative_entries() const {
    return std::holds_alternative<SmoothStretch>(stretch) ||
           std::holds_alternative<SmoothBend>(bend);
  }
  bool held_wing_bends() const {
    return std::visit([](const auto& law) { return law.kHeldWingBends; }, bend);
  }
};

// Makes the law of that name, "reference" or "smooth" (both parts). Throws InputError for any other
// name.
Law MakeLaw(const std::string& name);

// How the fabrics of a law are read: the reference law takes negative entries.
MaterialPolicy ReadingPolicy(const Law& law, double min_relative_stiffness = 0.0);

}  // namespace drape
