// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "losses/outline/outline.h"
#include "physics/mesh/disc.h"

namespace drape {

// The motions allowed for the second outline before the comparison.
enum class OutlineFreedom { kFixed, kRotation, kRotationAndMirror };

struct OutlineMatch {
  double rms = 0.0;       // smallest root mean square difference, in the unit of the outlines
  double rotation = 0.0;  // of b, counter-clockwise, a multiple of 2π/n [rad]
  bool mirrored = false;  // b(−θ) before the rotation
};
// Finds the motion of b with the smallest root mean square difference to a [MODEL, M50]. Both have
// the same non-zero size n.
OutlineMatch MatchOutlines(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                           OutlineFreedom freedom = OutlineFreedom::kFixed);

// Returns the match with its rotation refined between the angles: the minimum of the parabola
// through the squared differences at the best multiple of 2π/n and its two neighbours. rms remains
// the sampled one. n ≥ 3.
OutlineMatch RefineRotation(const Eigen::VectorXd& a, const Eigen::VectorXd& b, OutlineMatch match);

// How far the silhouette of an image can be trusted.
struct ImageQuality {
  Segmentation segmentation;  // what was made of the picture
  bool scale_given = false;   // by the user; otherwise the scale of the published images
  CentreMode centre = CentreMode::kNominal;
  double centre_offset = 0.0;                 // of the camera's centre from the image's centre [px]
  double centre_error = 0.0;                  // from the outline's centre to the camera's [px]
  double drape_coefficient = 0.0;             // about the outline's centre, as the radii
  double radius_min = 0.0, radius_max = 0.0;  // in the support plane [m]
  double overhanging = 0.0;        // share of the rays that leave the cloth and enter it again
  std::vector<std::string> notes;  // one sentence for each thing that a user should know
  bool doubtful = false;           // a note says that scale, centre or outline may be off
};

struct MeasuredImage {
  GrayImage image;
  Camera camera;  // its centre is the support's centre in this image
  ImageQuality quality;
};

// Bounds beyond which an image shows no drape, about the outline's centre: shares of the radii of
// support and specimen. The 494 published images of 17 fabrics that were measured (15 cm on 9 cm)
// have radii of 87.9 … 156.2 mm (22 go below 90 mm, 131 above 150 mm), drape coefficients of .125 …
// .961 and at most one ray of 360 that crosses the outline more than once.
inline constexpr double kLeastRadius = 0.086 / 0.09, kLargestRadius = 0.160 / 0.15;
inline constexpr double kLeastDrapeCoefficient = 0.03, kLargestDrapeCoefficient = 1.02;
inline constexpr double kLargestOverhang = 0.1;

// The hem of an outline against that of the flat cloth. Cloth hardly stretches: the hem, at its
// estimated heights (EstimatedHemHeight), is as long as the edge of the flat specimen, to 2 % in 36
// simulated drapes of DC 8 to 99 % and to 19 % in published images, whose heights differ. With a
// specimen of 24 cm for 30, or 30 for 36, it is 15 to 50 % too long or too short.
struct HemLength {
  double relative = 1.0;  // to the circumference of the flat specimen
  double usual = 0.0;     // diameter of the specimen, 24, 30 or 36 cm, that fits where the given
                          // one does not [m]; 0: the given one fits, or none does
};
// vertical_profile: VerticalProfile of the outline with such discs.
HemLength MeasureHem(
    const std::function<Eigen::VectorXd(const DrapeDiscs& discs)>& vertical_profile,
    const DrapeDiscs& discs);
// "this looks like a specimen of 24 cm: …"; where no usual size fits, asks for scale and size.
std::string SizeText(const HemLength& hem, const DrapeDiscs& discs);
inline constexpr double kNotedHem = 0.35;  // of the logarithm of HemLength::relative
// The share of the rays, as many as the outline has, on which the cloth of the image ends by 2 mm
// or more before its outermost end.
double ComputeOverhang(const GrayImage& image, const Camera& camera, const Outline& outline);
inline constexpr double kNotedOverhang = 0.01;
// The message for an outline with such rays and a hem that no cloth has.
inline constexpr const char* kJagged =
    "the outline is jagged, and its hem is too long for the cloth: is the cloth in places of the "
    "colour of the ground, or does something lie on it?";

// Finds the camera of a silhouette of a drape of those discs and measures its outline, in the
// vertical projection (VerticalProfile). A camera file says where the centre is, whatever `centre`
// asks for. The outline's centre is searched for from the camera's centre, or from the centroid of
// a cloth that is far from it where the user gave no centre. Throws InputError (prefix `where`)
// when the camera is not known (MakeCamera), the outline is not closed about the support's centre,
// a specimen of another size fits (MeasureHem), or one of the bounds does not hold; the message
// names the likely remedy.
MeasuredImage MeasureImage(Silhouette silhouette, const CameraInput& input, CentreMode centre,
                           const DrapeDiscs& discs, const std::string& where);

// "orthographic camera, 1200x900 px, 2500.0 px/m (given), centre (603.1, 455.0) found from the
// outline": what the measures of an image rest on.
std::string CameraText(const Camera& camera, const ImageQuality& quality);

using Color = std::array<uint8_t, 3>;

// The colours of the lines of a picture.
inline constexpr Color kFittedColor = {220, 40, 30}, kMeasuredColor = {20, 110, 230},
                       kSupportColor = {90, 150, 90}, kFlatColor = {150, 120, 60};

// Renders a fit: the image in pale grey, a small one enlarged, and on it the measured and the
// fitted outline (profiles [px], any number of angles ≥ 3) and the circle of the support in its
// plane. The page of drape_report shows the same as layers, with a key.
RgbImage RenderOverlay(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                       const Eigen::VectorXd& fitted_radius, const Camera& camera,
                       const DrapeDiscs& discs);

// Renders how an image was measured, over the silhouette or over the picture that it was made from:
// as above, with the measured outline [px], and the circles of the flat cloth and the support.
RgbImage RenderMeasurement(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                           const Camera& camera, const DrapeDiscs& discs);

}  // namespace drape
