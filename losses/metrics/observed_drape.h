// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/shape_features.h"
#include "physics/mesh/obj_io.h"

namespace drape {

inline constexpr int kObservedAngles = 360;

// A drape as a camera sees it: the input of all metrics of drapes and of their distributions.
struct ObservedDrape {
  GrayImage image;
  Eigen::VectorXd radius;  // r(θ) of the outline [m], shape [kObservedAngles] (VerticalProfile)
  ShapeFeatures shape;     // of that profile
  DrapeDiscs discs;
};

// Observes an image of the size of the camera, or the image of a surface. Throws InputError (prefix
// `where`) when the sizes differ, the surface is not in front of the camera, or the outline has
// gaps.
ObservedDrape ObserveImage(const GrayImage& image, const Camera& camera, const DrapeDiscs& discs,
                           const std::string& where);
ObservedDrape ObserveSurface(const ObjSurface& surface, const Camera& camera,
                             const DrapeDiscs& discs, const std::string& where);

// Observes a flat disc of that radius [m] about the camera centre, as a drape of the discs.
ObservedDrape ObserveDisc(double radius, const Camera& camera, const DrapeDiscs& discs);

// Returns the image mirrored (y → −y) if requested and then turned counter-clockwise about the
// camera centre by `rotation` [rad]; bilinear between pixels, white outside the image.
GrayImage TurnedImage(const GrayImage& image, const Camera& camera, double rotation, bool mirrored);

// Returns the image moved so that the centre of camera `from` is at the centre of `to`; bilinear
// between pixels, white outside the image.
GrayImage MovedImage(const GrayImage& image, const Camera& from, const Camera& to);

// The pixel-wise mean of at least one image; all images have equal sizes.
class MeanImage {
 public:
  void Add(const GrayImage& image);
  GrayImage Mean() const;

 private:
  GrayImage first_;  // for its size
  Eigen::VectorXd sum_;
  int count_ = 0;
};

}  // namespace drape
