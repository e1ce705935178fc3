// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace drape {

// The SHA-256 of bytes, 64 hexadecimal digits [FIPS 180-4].
std::string Sha256(std::string_view bytes);

}  // namespace drape
