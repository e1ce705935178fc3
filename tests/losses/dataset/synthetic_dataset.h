// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "tests/losses/image/encode.h"
#include "tests/losses/temp_folder.h"

namespace drape {

// Files in the layout of the public data set, in a temporary folder.
class SyntheticDataset {
 public:
  const std::string& path() const { return folder_.path(); }

  // A silhouette r(θ) = radius·(1 + 0.1·cos(folds·θ − phase)) [px] in a 256×256 JPEG.
  std::string AddImage(const std::string& name, double radius = 85, int folds = 5,
                       double phase = 0) const {
    std::vector<uint8_t> pixels(256 * 256);
    for (int i = 0; i < 256 * 256; ++i) {
      const int row = i / 256;
      const double x = i % 256 - 127.5, y = 127.5 - row;
      const double edge = radius * (1 + 0.1 * std::cos(folds * std::atan2(y, x) - phase));
      pixels[i] = std::hypot(x, y) < edge ? 0 : 255;
    }
    std::string path = Prepare(name);
    WriteAll(path, EncodeJpeg(pixels, 256, 256, 1));
    return path;
  }

  std::string AddFile(const std::string& name, const std::string& content) const {
    std::string path = Prepare(name);
    std::ofstream(path) << content;
    return path;
  }

  // Adds a fan of triangles with that outline [m], turned by quarters·90° counter-clockwise. With
  // vt it has a dummy line and the flat disc; without vt it is of another topology.
  std::string AddMesh(const std::string& name, bool with_vt, double radius = 85 / 719.5,
                      int folds = 5, double phase = 0, int quarters = 0) const {
    const int n = with_vt ? 120 : 90;
    std::string v = "v 0 0 0\n", vt = "vt 0 0\nvt 0 0\n", f;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * M_PI * k / n;
      const double r = radius * (1 + 0.1 * std::cos(folds * angle - phase));
      const double turned = angle + quarters * M_PI / 2;
      v += Line("v", r * std::cos(turned), r * std::sin(turned)) + " -0.05\n";
      vt += Line("vt", 0.15 * std::cos(angle), 0.15 * std::sin(angle)) + "\n";
      f += "f" + Corner(1, with_vt) + Corner(2 + k, with_vt) + Corner(2 + (k + 1) % n, with_vt) +
           "\n";
    }
    return AddFile(name, v + (with_vt ? vt : "") + f);
  }

 private:
  std::string Prepare(const std::string& name) const {
    std::string path = folder_ / name;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    return path;
  }
  static std::string Line(const char* key, double x, double y) {
    return std::string(key) + " " + std::to_string(x) + " " + std::to_string(y);
  }
  static std::string Corner(int index, bool with_vt) {
    const std::string text = std::to_string(index);
    return " " + (with_vt ? text + "/" + text : text);
  }

  TempFolder folder_;
};

}  // namespace drape
