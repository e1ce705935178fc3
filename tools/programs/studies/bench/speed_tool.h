// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The program drape_speed.
int SpeedMain(int argc, char** argv);

}  // namespace drape
