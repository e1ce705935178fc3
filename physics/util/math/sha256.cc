// SPDX-License-Identifier: Apache-2.0
#include "physics/util/math/sha256.h"

#include <nettle/sha2.h>

#include <array>

namespace drape {

std::string Sha256(std::string_view bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  sha256_ctx state;
  sha256_init(&state);
  sha256_update(&state, bytes.size(), reinterpret_cast<const uint8_t*>(bytes.data()));
  std::array<uint8_t, SHA256_DIGEST_SIZE> digest;
  sha256_digest(&state, digest.size(), digest.data());
  std::string text;
  for (const uint8_t byte : digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace drape
