// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>

namespace drape {

// A positive shift of a stiffness, μ·(M + ℓ²·L) with the lumped mass M and L = ∫ρ·∇φ·∇φ: ‖u‖² and
// ℓ²·‖∇u‖² weighed by density. ℓ > 0 holds wrinkles, which are what is mostly unstable in a falling
// cloth, and leaves its soft wide motions free, which a mass shift (ℓ = 0) as large would stop.
struct StiffnessShift {
  double length = 0.0;  // ℓ [m]
  double first = 25.0;  // smallest μ > 0; it grows by factors of 4 [s⁻²]
  double most = 1e8;    // gives up above

  bool operator==(const StiffnessShift&) const = default;
  // The μ to try when `mu` did not make the stiffness positive definite.
  std::optional<double> After(double mu) const {
    const double next = std::max(4.0 * mu, first);
    return next > most ? std::nullopt : std::optional(next);
  }
};

}  // namespace drape
