// SPDX-License-Identifier: Apache-2.0
// A library that starts a thread before main, as OpenBLAS does. That thread blocks no signals.
#include <unistd.h>

#include <thread>

namespace {

[[gnu::constructor]] void Start() {
  std::thread([] {
    for (;;) pause();
  }).detach();
}

}  // namespace
