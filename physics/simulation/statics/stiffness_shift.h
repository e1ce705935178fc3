// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>

namespace drape {

// A positive shift of a stiffness, μ·(M + ℓ²·L) with the lumped mass M and L = ∫ρ·∇φ·∇φ
// [MODEL, M35]: ‖u‖² and ℓ²·‖∇u‖² weighted by density. ℓ > 0 suppresses wrinkles, which are the
// usual instability of a falling cloth, and leaves its soft wide motions free; an equally large
// mass shift (ℓ = 0) would stop these too.
struct StiffnessShift {
  double length = 0.0;  // ℓ [m]
  double first = 25.0;  // smallest μ > 0; it grows by factors of 4 [s⁻²]
  double most = 1e8;    // largest μ [s⁻²]

  bool operator==(const StiffnessShift&) const = default;
  // The μ to try after `mu` did not make the stiffness positive definite; std::nullopt above
  // `most`.
  std::optional<double> After(double mu) const {
    const double next = std::max(4.0 * mu, first);
    return next > most ? std::nullopt : std::optional(next);
  }
};

}  // namespace drape
