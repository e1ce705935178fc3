// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The program drape_bench.
int BenchMain(int argc, char** argv);

}  // namespace drape
