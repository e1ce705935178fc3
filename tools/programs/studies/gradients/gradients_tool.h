// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The program drape_gradients.
int GradientsMain(int argc, char** argv);

}  // namespace drape
