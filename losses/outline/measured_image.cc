// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/measured_image.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using std::numbers::pi;

// The mirrored outline r(−θ).
Eigen::VectorXd Mirrored(const Eigen::VectorXd& outline) {
  Eigen::VectorXd result = outline;
  std::reverse(result.begin() + 1, result.end());
  return result;
}

double SquaredDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index shift) {
  const Eigen::Index rest = a.size() - shift;
  return (a.tail(rest) - b.head(rest)).squaredNorm() +
         (a.head(shift) - b.tail(shift)).squaredNorm();
}

constexpr int kAngles = 360;
constexpr double kMillimetre = 1e-3;
constexpr double kNotedSlack = 0.0015;  // [m] one pixel of a published image
constexpr double kNotedError = 0.003;   // [m] of a centre that is not searched for
constexpr double kNotedOffset = 0.2;    // of the support's radius

std::string ScaleRemedy(const Camera& camera, const ImageQuality& quality) {
  return Format("is the scale of %.1f px/m (%s) right? Give camera_scale or image_width_mm",
                camera.pixels_per_metre(),
                quality.scale_given ? "given" : "of the published images");
}

// Throws InputError for what is no drape of those discs.
void CheckBounds(const Camera& camera, const ImageQuality& quality, const HemLength& hem,
                 const DrapeDiscs& discs, const std::string& where) {
  const double least_radius = kLeastRadius * discs.support;
  const double largest_radius = kLargestRadius * discs.specimen;
  const double least = quality.radius_min / kMillimetre, largest = quality.radius_max / kMillimetre;
  if (quality.overhanging > kLargestOverhang)
    throw InputError(
        where, Format("%s %% of the rays from the centre cross the outline more than once, "
                      "expected at most %.0f %%: not the outline of one drape",
                      FormatBeyond(100 * quality.overhanging, 100 * kLargestOverhang, 0).c_str(),
                      100 * kLargestOverhang));
  if (hem.usual > 0 && quality.overhanging > kNotedOverhang) throw InputError(where, kJagged);
  if (hem.usual > 0) throw InputError(where, SizeText(hem, discs));
  if (quality.radius_max > largest_radius)
    throw InputError(where, Format("the outline reaches %s mm, expected at most %.0f of a cloth "
                                   "of %.0f mm; ",
                                   FormatBeyond(largest, largest_radius / kMillimetre, 0).c_str(),
                                   largest_radius / kMillimetre, discs.specimen / kMillimetre) +
                                ScaleRemedy(camera, quality));
  if (quality.radius_min < least_radius)
    throw InputError(where, Format("the outline comes to %s mm of the centre, expected at least "
                                   "%.0f with a support of %.0f mm; ",
                                   FormatBeyond(least, least_radius / kMillimetre, 0).c_str(),
                                   least_radius / kMillimetre, discs.support / kMillimetre) +
                                ScaleRemedy(camera, quality));
  if (quality.drape_coefficient < kLeastDrapeCoefficient)
    throw InputError(where,
                     "the outline is that of the support: is the cloth of the colour of the "
                     "ground, or the scale wrong?");
  if (quality.drape_coefficient > kLargestDrapeCoefficient)
    throw InputError(where, Format("the drape coefficient is %.3f, expected 0 … 1; ",
                                   quality.drape_coefficient) +
                                ScaleRemedy(camera, quality));
}

double RelativeHem(const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  const Eigen::Index n = radius.size();
  const auto at = [&](Eigen::Index k) {
    const Eigen::Vector2d flat = radius[k] * RayDirection(static_cast<int>(k), static_cast<int>(n));
    return Eigen::Vector3d(flat.x(), flat.y(), EstimatedHemHeight(radius[k], discs));
  };
  double length = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) length += (at((k + 1) % n) - at(k)).norm();
  return length / (2 * pi * discs.specimen);
}

// The camera; a photograph needs a scale or a camera.
Camera FindCamera(const CameraInput& input, const Silhouette& silhouette, const DrapeDiscs& discs,
                  const std::string& where) {
  const Camera usual = CameraAbove(discs);
  const bool has_usual_size =
      silhouette.image.width == usual.width && silhouette.image.height == usual.height;
  if (silhouette.segmentation.photograph && !has_usual_size && !input.gives_scale() &&
      !input.gives_camera())
    throw InputError(where,
                     "is a photograph without a scale: drape_photo makes a silhouette and its "
                     "camera of it; image_width_mm or camera_scale is for parallel light");
  return MakeCamera(input, silhouette.image, discs, where);
}

void AddNotes(const Camera& camera, const DrapeDiscs& discs, ImageQuality* quality) {
  const Segmentation& segmentation = quality->segmentation;
  quality->notes = segmentation.Notes();
  quality->doubtful = !segmentation.doubts.empty();
  const auto add_doubt = [&](const std::string& note) {
    quality->notes.push_back(note);
    quality->doubtful = true;
  };
  if (segmentation.focal_35mm > 0 && camera.kind == CameraKind::kOrthographic)
    add_doubt(
        "the file tells a focal length: in perspective a hem below the support looks too small; "
        "drape_photo measures such photographs");
  if (quality->overhanging > kNotedOverhang)
    add_doubt(Format(
        "%.1f %% of the rays cross the outline more than once; the outermost crossing counts",
        100 * quality->overhanging));
  if (quality->radius_max > discs.specimen + kNotedSlack)
    add_doubt(
        Format("the outline reaches %.1f mm, more than the cloth's %.0f mm: "
               "the scale or the centre is slightly off",
               quality->radius_max / kMillimetre, discs.specimen / kMillimetre));
  if (quality->radius_min < discs.support - kNotedSlack)
    add_doubt(
        Format("the outline comes to %.1f mm of the centre, less than the "
               "support's %.0f mm: the scale or the centre is slightly off",
               quality->radius_min / kMillimetre, discs.support / kMillimetre));
  if (quality->centre_error > kNotedError * camera.pixels_per_metre())
    add_doubt(
        Format("the outline's centre is %.1f px from the centre used", quality->centre_error));
  if (quality->centre_offset > kNotedOffset * discs.support * camera.pixels_per_metre())
    quality->notes.push_back(
        Format("the support's centre is %.0f px from the image's centre", quality->centre_offset));
}

using Eigen::Vector2d;

constexpr double kClothGray = 150, kBackgroundGray = 255;
constexpr int kCircleAngles = 360;

void Blend(RgbImage* picture, int column, int row, const Color& color, double alpha) {
  if (column < 0 || row < 0 || column >= picture->width || row >= picture->height) return;
  uint8_t* rgb = &picture->rgb[3 * (size_t(row) * picture->width + column)];
  for (int c = 0; c < 3; ++c) {
    rgb[c] = static_cast<uint8_t>(std::lround(rgb[c] + alpha * (color[c] - rgb[c])));
  }
}

// Draws an anti-aliased closed polygon. The opacity is collected over all segments first, so that
// joints are not painted twice.
void RenderPolygon(const Eigen::Matrix2Xd& points, double line_width, const Color& color,
                   RgbImage* picture) {
  std::vector<float> alpha(size_t(picture->width) * picture->height, 0);
  const double reach = 0.5 * line_width + 0.5;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Vector2d a = points.col(i), b = points.col((i + 1) % points.cols());
    const Vector2d min = (a.cwiseMin(b).array() - reach).cwiseMax(0.0);
    const Vector2d size(picture->width - 1, picture->height - 1);
    const Vector2d max = (a.cwiseMax(b).array() + reach).min(size.array());
    for (int row = static_cast<int>(std::ceil(min.y())); row <= max.y(); ++row) {
      for (int col = static_cast<int>(std::ceil(min.x())); col <= max.x(); ++col) {
        const double cover = std::clamp(reach - DistanceToSegment({col, row}, a, b), 0.0, 1.0);
        float& pixel = alpha[size_t(row) * picture->width + col];
        pixel = std::max(pixel, static_cast<float>(cover));
      }
    }
  }
  for (size_t i = 0; i < alpha.size(); ++i) {
    if (alpha[i] > 0) Blend(picture, i % picture->width, i / picture->width, color, alpha[i]);
  }
}

void RenderProfile(const Eigen::VectorXd& radius, const Camera& camera, int upscale,
                   double line_width, const Color& color, RgbImage* picture) {
  CHECK_GE(radius.size(), 3);
  CHECK(radius.allFinite());
  Eigen::Matrix2Xd points = ProfilePolygon(radius);
  points.row(0) = ((camera.cx + points.row(0).array() + 0.5) * upscale - 0.5).matrix();
  points.row(1) = ((camera.cy - points.row(1).array() + 0.5) * upscale - 0.5).matrix();
  RenderPolygon(points, line_width, color, picture);
}

RgbImage PaleUpscaled(const GrayImage& image, int upscale) {
  RgbImage picture{image.width * upscale, image.height * upscale, {}};
  picture.rgb.reserve(size_t(3) * picture.width * picture.height);
  for (int row = 0; row < picture.height; ++row) {
    for (int col = 0; col < picture.width; ++col) {
      const double c = image.at(col / upscale, row / upscale);
      const double gray = kBackgroundGray + c * (kClothGray - kBackgroundGray);
      picture.rgb.insert(picture.rgb.end(), 3, static_cast<uint8_t>(std::lround(gray)));
    }
  }
  return picture;
}

struct Line {
  Eigen::VectorXd radius;  // [px]
  Color color;
  double relative_width;
};

Line Circle(double radius, const Camera& camera, const Color& color) {
  return {Eigen::VectorXd::Constant(kCircleAngles, radius * camera.pixels_per_metre()), color, 0.5};
}

// The first line is drawn last, over the others.
RgbImage RenderLines(const GrayImage& image, const Camera& camera, const std::vector<Line>& lines) {
  constexpr int kSize = 1000;         // [px] of a picture that needs no enlargement
  constexpr double kLineShare = 500;  // a line is this part of the width of a larger picture
  const int upscale = std::clamp(kSize / std::max(image.width, image.height), 1, 3);
  const double line_width = std::max(2.0, image.width * upscale / kLineShare);
  RgbImage picture = PaleUpscaled(image, upscale);
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    RenderProfile(line->radius, camera, upscale, line->relative_width * line_width, line->color,
                  &picture);
  return picture;
}

}  // namespace

OutlineMatch MatchOutlines(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                           OutlineFreedom freedom) {
  OutlineMatch match{ProfileRms(a, b), 0.0, false};
  if (freedom == OutlineFreedom::kFixed) return match;
  const auto n = static_cast<double>(a.size());
  for (const bool mirrored : {false, true}) {
    if (mirrored && freedom != OutlineFreedom::kRotationAndMirror) break;
    const Eigen::VectorXd other = mirrored ? Mirrored(b) : b;
    for (Eigen::Index shift = 0; shift < a.size(); ++shift) {
      const double rms = std::sqrt(SquaredDistance(a, other, shift) / n);
      if (rms < match.rms) match = {rms, 2 * pi * static_cast<double>(shift) / n, mirrored};
    }
  }
  return match;
}

OutlineMatch RefineRotation(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                            OutlineMatch match) {
  CHECK_EQ(a.size(), b.size());
  CHECK_GE(a.size(), 3);
  const Eigen::VectorXd other = match.mirrored ? Mirrored(b) : b;
  const Eigen::Index n = a.size();
  const double spacing = 2 * pi / static_cast<double>(n);
  const auto shift = static_cast<Eigen::Index>(std::lround(match.rotation / spacing));
  const double before = SquaredDistance(a, other, (shift + n - 1) % n);
  const double best = SquaredDistance(a, other, shift % n);
  const double after = SquaredDistance(a, other, (shift + 1) % n);
  const double curvature = before - 2 * best + after;
  if (curvature > 0) match.rotation += spacing * 0.5 * (before - after) / curvature;
  return match;
}

HemLength MeasureHem(
    const std::function<Eigen::VectorXd(const DrapeDiscs& discs)>& vertical_profile,
    const DrapeDiscs& discs) {
  constexpr double kUsual[] = {0.12, 0.15, 0.18};             // radii [m]
  constexpr double kOff = 0.12, kFits = 0.10, kBetter = 0.6;  // of the logarithm; of that of given
  HemLength hem{RelativeHem(vertical_profile(discs), discs), 0.0};
  double least = std::abs(std::log(hem.relative));
  if (least < kOff) return hem;
  least = std::min(kFits, kBetter * least);
  for (const double radius : kUsual) {
    const DrapeDiscs other{radius, discs.support};
    if (radius <= discs.support) continue;
    const Eigen::VectorXd profile = vertical_profile(other);
    if (profile.maxCoeff() > kLargestRadius * radius) continue;
    const double off = std::abs(std::log(RelativeHem(profile, other)));
    if (off >= least) continue;
    least = off;
    hem.usual = 2 * radius;
  }
  return hem;
}

std::string SizeText(const HemLength& hem, const DrapeDiscs& discs) {
  const std::string length =
      Format("the hem of this outline is %.0f %% of that of a flat cloth of %.0f cm",
             100 * hem.relative, 200 * discs.specimen);
  if (hem.usual == 0) return length + ": are the scale and the size of the cloth right?";
  return Format("this looks like a specimen of %.0f cm: ", 100 * hem.usual) + length +
         Format("; expected specimen = %.2f, or another scale", hem.usual);
}

double ComputeOverhang(const GrayImage& image, const Camera& camera, const Outline& outline) {
  constexpr double kOverhang = 0.002;  // [m] by which a ray must enter the cloth again to count
  const double least = kOverhang * camera.pixels_per_metre();
  int overhanging = 0;
  for (int k = 0; k < outline.num_angles(); ++k) {
    const double reach = FirstExit(image, camera, RayDirection(k, outline.num_angles()));
    overhanging += outline.radius[k] - reach > least;
  }
  return static_cast<double>(overhanging) / outline.num_angles();
}

MeasuredImage MeasureImage(Silhouette silhouette, const CameraInput& input, CentreMode centre,
                           const DrapeDiscs& discs, const std::string& where) {
  const Camera known = FindCamera(input, silhouette, discs, where);
  MeasuredImage measured{std::move(silhouette.image), known, {}};
  const GrayImage& image = measured.image;
  Camera& camera = measured.camera;
  ImageQuality& quality = measured.quality;
  quality.segmentation = std::move(silhouette.segmentation);
  const bool centre_known = input.gives_camera();  // a pinhole's outline is not about the centre
  quality.scale_given = input.gives_scale() || input.gives_camera();
  quality.centre = centre_known ? CentreMode::kNominal : centre;
  Camera centred = camera;
  if (!input.gives_centre() && !centre_known) CentreOnFarCloth(image, &centred);
  const bool found = centre_known || CentreOnOutline(image, &centred);
  if (quality.centre == CentreMode::kOutline) camera = centred;
  quality.centre_error = std::hypot(camera.cx - centred.cx, camera.cy - centred.cy);
  quality.centre_offset =
      std::hypot(camera.cx - 0.5 * (image.width - 1), camera.cy - 0.5 * (image.height - 1));
  Outline outline;
  if (!found || !OutlineFromImage(image, camera, kAngles, &outline) ||
      !OutlineFromImage(image, centred, kAngles, &outline))
    throw InputError(where,
                     "no closed outline around the support's centre, expected the silhouette of a "
                     "drape");
  const ShapeFeatures shape = MeasureShape(VerticalProfile(outline.radius, camera, discs), discs);
  quality.drape_coefficient = shape.drape_coefficient;
  quality.radius_min = shape.radius_min;
  quality.radius_max = shape.radius_max;
  quality.overhanging = ComputeOverhang(image, centred, outline);
  const HemLength hem = MeasureHem(
      [&](const DrapeDiscs& other) { return VerticalProfile(outline.radius, camera, other); },
      discs);
  CheckBounds(camera, quality, hem, discs, where);
  AddNotes(camera, discs, &quality);
  if (std::abs(std::log(hem.relative)) > kNotedHem) {
    quality.doubtful = true;
    quality.notes.push_back(SizeText(hem, discs));
  }
  return measured;
}

std::string CameraText(const Camera& camera, const ImageQuality& quality) {
  return Format("%s camera, %dx%d px, %.1f px/m (%s), centre (%.1f, %.1f) %s",
                ToString(camera.kind), camera.width, camera.height, camera.pixels_per_metre(),
                quality.scale_given ? "given" : "of the published images", camera.cx, camera.cy,
                quality.centre == CentreMode::kOutline ? "found from the outline" : "(nominal)");
}

RgbImage RenderOverlay(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                       const Eigen::VectorXd& fitted_radius, const Camera& camera,
                       const DrapeDiscs& discs) {
  return RenderLines(image, camera,
                     {{fitted_radius, kFittedColor, 1.0},
                      {measured_radius, kMeasuredColor, 1.0},
                      Circle(discs.support, camera, kSupportColor)});
}

RgbImage RenderMeasurement(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                           const Camera& camera, const DrapeDiscs& discs) {
  return RenderLines(image, camera,
                     {{measured_radius, kMeasuredColor, 1.0},
                      Circle(discs.specimen, camera, kFlatColor),
                      Circle(discs.support, camera, kSupportColor)});
}

}  // namespace drape
