// SPDX-License-Identifier: Apache-2.0
// Rendered photographs of known drapes, measured: a table for tests/bench/PHOTOS.md.
// usage: bench_photos [first] [count] [width=4032] [distortion=k1] [tone=0.5] [focal=mm that the
//        file tells too much] [overlays=folder]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

struct Errors {
  std::vector<double> values;

  double sum = 0.0;

  void Add(double value) {
    values.push_back(std::abs(value));
    sum += value;
  }
  double Quantile(double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  }
  void Print(const char* name) {
    std::printf("%-32s median %.2f, 95 %% %.2f, largest %.2f, mean %+.2f\n", name, Quantile(0.5),
                Quantile(0.95), Quantile(1),
                sum / std::max(1.0, static_cast<double>(values.size())));
  }
};

void Run(unsigned first, unsigned count, std::map<std::string, std::string> settings) {
  constexpr double kDegree = M_PI / 180;
  const auto number_of = [&](const char* key) { return std::atof(settings[key].c_str()); };
  const std::string overlays = settings["overlays"];
  const std::string folder = std::filesystem::temp_directory_path().string();
  std::map<unsigned, KnownDrape> drapes;
  std::printf("%4s %-16s %5s %5s %5s | %6s %5s %7s %6s %7s %6s | %5s %6s %6s %6s\n", "no", "drape",
              "DC", "tilt", "found", "estim", "sd", "outline", "camera", "heights", "plane", "px",
              "bias", "blur", "eye %");
  int good = 0, refused = 0;
  Errors of_coefficient, by_outline, by_camera, by_heights, of_plane, of_outline;
  const unsigned step = std::max(1u, static_cast<unsigned>(number_of("step")));
  for (unsigned number = first; number < first + count; number += step) {
    PhotoScene scene = RandomScene(number);
    if (settings.count("width") != 0) {
      scene.width = static_cast<int>(number_of("width"));
      scene.height = scene.width * 3 / 4;
    }
    scene.distortion = number_of("distortion");
    scene.tone = number_of("tone");
    PhotoOptions options;
    if (settings.count("focal") != 0) options.focal_35mm = scene.focal_35mm + number_of("focal");
    const unsigned kind = number % kNumDrapes;
    if (drapes.count(kind) == 0) drapes[kind] = SimulateDrapeOfSix(kind);
    const KnownDrape& drape = drapes[kind];
    const PhotoTrial trial = TryPhoto(scene, drape, options, folder);
    const PhotoResult& result = trial.result;
    std::printf("%4u %-16s %5.1f %5.2f ", number, drape.name.c_str(), 100 * drape.coefficient,
                scene.tilt.norm() / kDegree);
    if (!overlays.empty())
      WritePng(result.overlay, overlays + "/overlay_" + std::to_string(number) + ".png");
    if (result.fault != PhotoFault::kNone) {
      ++refused;
      std::printf("refused: %s\n", result.reason.c_str());
      continue;
    }
    const bool is_good = std::abs(trial.error_of_estimate) <= 0.5 && trial.outline_rms <= 2;
    good += is_good;
    of_coefficient.Add(trial.error_of_estimate);
    by_outline.Add(trial.error_by_outline);
    by_camera.Add(trial.error_by_camera);
    by_heights.Add(trial.error_by_heights);
    of_plane.Add(trial.error_of_plane);
    of_outline.Add(trial.outline_rms);
    std::printf("%5.2f | %+6.2f %5.2f %+7.2f %+6.2f %+7.2f %+6.2f | %5.2f %+6.2f %6.2f %+6.2f %s\n",
                result.tilt.norm() / kDegree, trial.error_of_estimate, 100 * result.coefficient_sd,
                trial.error_by_outline, trial.error_by_camera, trial.error_by_heights,
                trial.error_of_plane, trial.outline_rms, trial.outline_bias, 1e3 * result.blur,
                100 * trial.height_error, is_good ? "" : "MISSED");
    std::fflush(stdout);
  }
  std::printf("%d good, %d refused, of %u\n", good, refused, count);
  of_coefficient.Print("error of the coefficient [points]");
  by_outline.Print("by the outline");
  by_camera.Print("by the camera");
  by_heights.Print("by the hem's heights");
  of_plane.Print("without a model of the camera");
  of_outline.Print("error of the outline [px rms]");
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  std::map<std::string, std::string> settings;
  unsigned numbers[] = {0, 24};
  int place = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const size_t equals = argument.find('=');
    if (equals != std::string::npos)
      settings[argument.substr(0, equals)] = argument.substr(equals + 1);
    else if (place < 2)
      numbers[place++] = static_cast<unsigned>(std::strtoul(argv[i], nullptr, 10));
  }
  drape::Run(numbers[0], numbers[1], settings);
}
