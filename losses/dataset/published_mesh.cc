// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/published_mesh.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/raster.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kAngles = 360, kSupersample = 2;

bool HasFillerVt(const ObjContent& content) {
  return content.vt.size() == content.v.size() + 1 && content.vt[0].isZero(0);
}

std::optional<Eigen::VectorXd> CentredProfile(const GrayImage& image, Camera camera) {
  Outline outline;
  if (!CentreOnOutline(image, &camera) || !OutlineFromImage(image, camera, kAngles, &outline))
    return {};
  return outline.radius;
}

// The profile r(θ) turned counter-clockwise by `shift` angles.
Eigen::VectorXd Shifted(const Eigen::VectorXd& radius, Eigen::Index shift) {
  Eigen::VectorXd turned(radius.size());
  turned << radius.tail(shift), radius.head(radius.size() - shift);
  return turned;
}

}  // namespace

std::optional<double> PublishedDensity(int fabric) {
  static constexpr std::array kDensities = {.059, .192, .213, .114, .274, .183, .100, .230, .249,
                                            .204, .148, .313, .107, .139, .211, .191, .278, .154,
                                            .282, .259, .186, .231, .163, .104, .060};
  if (fabric < 1 || fabric > static_cast<int>(kDensities.size())) return {};
  return kDensities[fabric - 1];
}

PublishedMesh ReadPublishedMesh(const std::string& path) {
  const ObjContent content = ParseObj(ReadWholeFile(path), path, false);
  PublishedMesh mesh;
  mesh.surface = ReadObjSurface(path);
  if (content.vt.empty()) return mesh;
  if (content.vt.size() != content.v.size() && !HasFillerVt(content)) {
    throw InputError(path,
                     "found " + std::to_string(content.vt.size()) + " vt for " +
                         std::to_string(content.v.size()) +
                         " v, expected no vt, as many as v, or one more with a first line 0 0");
  }
  mesh.cloth = ReadObj(path, {.first_vt_is_dummy = HasFillerVt(content)});
  return mesh;
}

std::optional<QuarterTurn> FindQuarterTurn(const ObjSurface& surface, const GrayImage& image,
                                           const Camera& camera) {
  const auto measured = CentredProfile(image, camera);
  const auto seen = CentredProfile(Rasterize(surface, camera, kSupersample), camera);
  if (!measured || !seen) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  QuarterTurn best{0, kInfinity, kInfinity};
  for (int quarters = 0; quarters < 4; ++quarters) {
    const double rms = ProfileRms(*measured, Shifted(*seen, quarters * kAngles / 4));
    if (rms < best.rms) {
      best = {quarters, rms, best.rms};
    } else {
      best.second_rms = std::min(best.second_rms, rms);
    }
  }
  return best;
}

}  // namespace drape
