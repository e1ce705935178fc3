// SPDX-License-Identifier: Apache-2.0
// Rendered photographs of known drapes, measured: a table for tests/bench/PHOTOS.md.
// usage: bench_photos [first] [count] [folder for overlays]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "tests/losses/camera/photo/photo_trial.h"

int main(int argc, char** argv) {
  using namespace drape;
  const unsigned first = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 0;
  const unsigned count = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 40;
  const std::string folder = argc > 3 ? argv[3] : std::filesystem::temp_directory_path().string();
  constexpr double kDegree = M_PI / 180;
  const std::vector<KnownDrape> drapes = SimulateDrapes();
  std::printf("%4s %-16s %5s %6s %6s | %7s %7s %7s %6s %6s %6s %6s\n", "no", "drape", "DC", "tilt",
              "found", "heights", "estim", "plane", "px", "mm", "blur", "eye %");
  int good = 0, refused = 0;
  for (unsigned number = first; number < first + count; ++number) {
    const PhotoScene scene = RandomScene(number);
    const KnownDrape& drape = drapes[number % drapes.size()];
    const PhotoTrial trial = TryPhoto(scene, drape, {}, folder);
    const PhotoResult& result = trial.result;
    std::printf("%4u %-16s %5.1f %6.2f ", number, drape.name.c_str(), 100 * drape.coefficient,
                scene.tilt.norm() / kDegree);
    if (argc > 3) WritePng(result.overlay, folder + "/overlay_" + std::to_string(number) + ".png");
    if (result.fault != PhotoFault::kNone) {
      ++refused;
      std::printf("refused: %s\n", result.reason.c_str());
      continue;
    }
    const bool is_good = std::abs(trial.error_of_estimate) <= 0.5 && trial.outline_rms <= 2;
    good += is_good;
    std::printf("%6.2f | %+7.2f %+7.2f %+7.2f %6.2f %6.2f %6.2f %6.2f %s\n", result.tilt / kDegree,
                trial.error_with_heights, trial.error_of_estimate, trial.error_of_plane,
                trial.outline_rms, trial.outline_rms_mm, 1e3 * result.blur,
                100 * trial.height_error, is_good ? "" : "MISSED");
    std::fflush(stdout);
  }
  std::printf("%d good, %d refused, of %u\n", good, refused, count);
}
