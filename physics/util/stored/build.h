// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// The version, such as "0.1.0".
std::string BuildVersion();

// The source that the library was built from: its short commit, with "-dirty" after it where files
// differ from that; empty where it was built outside a checkout.
std::string BuildCommit();

// "Release".
std::string BuildType();

// What a result says of the machine that it was computed on; empty where the system does not tell.
std::string HostName();
std::string ProcessorName();  // "AMD EPYC 7B13"

}  // namespace drape
