// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// What a result says of the machine that it was computed on; empty where the system does not tell.
std::string HostName();
std::string ProcessorName();  // "AMD EPYC 7B13"

}  // namespace drape
