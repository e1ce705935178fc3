// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/photo.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/cloth_mask.h"
#include "losses/image/disc.h"
#include "losses/image/image.h"
#include "losses/image/photo_planes.h"
#include "losses/image/segmentation.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "losses/photo/camera_pose.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

struct PhotoMarks {
  std::vector<cv::Point> outline;
  std::optional<cv::RotatedRect> disc;
  std::optional<std::array<Eigen::Vector2d, 4>> tag;
  std::vector<cv::Point> flat;                 // outline of the flat specimen
  std::vector<std::vector<cv::Point>> faults;  // where something is wrong
  std::string text;                            // below the picture, wrapped
  bool refused = false;
};

struct Rectified {
  GrayImage silhouette;
  Camera camera;
};

constexpr int kSide = 1400;  // [px] of the longer side of the picture

const cv::Scalar kOutline(20, 110, 230), kDisc(40, 160, 60), kFlat(200, 150, 40),
    kFault(220, 40, 30), kTag(170, 40, 170), kInk(40, 40, 40);

std::vector<std::string> Wrapped(const std::string& text, int width, double size) {
  std::vector<std::string> lines = {""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    int base = 0;
    const cv::Size box = cv::getTextSize(longer, cv::FONT_HERSHEY_SIMPLEX, size, 2, &base);
    if (box.width > width && !lines.back().empty())
      lines.push_back(word);
    else
      lines.back() = longer;
  }
  return lines;
}

class Canvas {
 public:
  Canvas(const PhotoPlanes& planes)
      : scale_(double(kSide) / std::max(planes.rgb.cols, planes.rgb.rows)) {
    cv::resize(planes.rgb, picture_, {}, scale_, scale_,
               scale_ < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  }

  void Curve(const std::vector<cv::Point>& points, const cv::Scalar& color, int width) {
    std::vector<cv::Point> scaled;
    for (const cv::Point& p : points) scaled.push_back(Place(p.x, p.y));
    if (scaled.size() == 1) {
      cv::circle(picture_, scaled[0], width, color, cv::FILLED, cv::LINE_AA);
    } else if (!scaled.empty()) {
      cv::polylines(picture_, scaled, true, color, width, cv::LINE_AA);
    }
  }
  void Ellipse(cv::RotatedRect ellipse) {
    ellipse.center = {float((ellipse.center.x + 0.5) * scale_ - 0.5),
                      float((ellipse.center.y + 0.5) * scale_ - 0.5)};
    ellipse.size.width *= float(scale_);
    ellipse.size.height *= float(scale_);
    cv::ellipse(picture_, ellipse, kDisc, 2, cv::LINE_AA);
    cv::drawMarker(picture_, ellipse.center, kDisc, cv::MARKER_CROSS, 24, 2, cv::LINE_AA);
  }
  // Below the picture.
  void Text(const std::string& text, const cv::Scalar& color) {
    constexpr double kSize = 0.9;
    constexpr int kLine = 38, kMargin = 20;
    const auto lines = Wrapped(text, picture_.cols - 2 * kMargin, kSize);
    const int top = picture_.rows;
    cv::copyMakeBorder(picture_, picture_, 0, kLine * int(lines.size()) + kMargin, 0, 0,
                       cv::BORDER_CONSTANT, cv::Scalar::all(255));
    for (size_t i = 0; i < lines.size(); ++i)
      cv::putText(picture_, lines[i], {kMargin, top + kLine * (int(i) + 1) - 6},
                  cv::FONT_HERSHEY_SIMPLEX, kSize, color, 2, cv::LINE_AA);
  }
  RgbImage Image() const {
    return {picture_.cols, picture_.rows, {picture_.datastart, picture_.dataend}};
  }

 private:
  cv::Point Place(double column, double row) const {
    return {cvRound((column + 0.5) * scale_ - 0.5), cvRound((row + 0.5) * scale_ - 0.5)};
  }

  double scale_;
  cv::Mat3b picture_;
};

constexpr double kMostScale = 2000;  // [px/m] more shows nothing of a drape

RgbImage RenderMarks(const PhotoPlanes& planes, const PhotoMarks& marks) {
  Canvas canvas(planes);
  canvas.Curve(marks.flat, kFlat, 1);
  if (marks.disc) canvas.Ellipse(*marks.disc);
  if (marks.tag) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& p : *marks.tag)
      corners.emplace_back(cvRound(p.x()), cvRound(p.y()));
    canvas.Curve(corners, kTag, 3);
  }
  canvas.Curve(marks.outline, kOutline, 2);
  for (const auto& fault : marks.faults) canvas.Curve(fault, kFault, 4);
  canvas.Text(marks.text, marks.refused ? kFault : kInk);
  return canvas.Image();
}

// What a pinhole at the same place sees that looks straight down: the homography K R K⁻¹ of the
// coverage, cut to the cloth and a margin.
Rectified Rectify(const cv::Mat1f& coverage, const PhotoPose& pose) {
  constexpr double kMargin = 0.1;  // of the cloth's extent
  const double focal = std::min(pose.focal, kMostScale * pose.eye.z());
  const Eigen::Matrix3d turn = pose.WorldFromCamera();
  const Eigen::Vector3d flip(1, -1, -1);  // x right, y up, z back → x right, y down, z forward
  Eigen::Matrix3d from_image, to_image;
  from_image << 1 / pose.focal, 0, -pose.principal.x() / pose.focal, 0, 1 / pose.focal,
      -pose.principal.y() / pose.focal, 0, 0, 1;
  to_image << focal, 0, 0, 0, focal, 0, 0, 0, 1;
  const Eigen::Matrix3d homography =
      to_image * flip.asDiagonal() * turn * flip.asDiagonal() * from_image;
  Eigen::Vector2d least(HUGE_VAL, HUGE_VAL), most = -least;
  for (int row = 0; row < coverage.rows; ++row)
    for (int col = 0; col < coverage.cols; ++col)
      if (coverage(row, col) > 0.5f) {
        const Eigen::Vector2d p = (homography * Eigen::Vector3d(col, row, 1)).hnormalized();
        least = least.cwiseMin(p);
        most = most.cwiseMax(p);
      }
  const double margin = kMargin * (most - least).maxCoeff();
  const Eigen::Vector2d origin =
      (least.array() - margin).floor().matrix();  // of the cut, from the optical axis
  Rectified result;
  Camera& camera = result.camera;
  camera.kind = CameraKind::kPinhole;
  camera.width = static_cast<int>(std::ceil(most.x() + margin - origin.x()));
  camera.height = static_cast<int>(std::ceil(most.y() + margin - origin.y()));
  camera.eye_height = pose.eye.z();
  camera.eye_x = pose.eye.x();
  camera.eye_y = pose.eye.y();
  camera.field_of_view = 2 * std::atan(0.5 * camera.height / focal);
  camera.cx = -focal * pose.eye.x() / pose.eye.z() - origin.x();
  camera.cy = focal * pose.eye.y() / pose.eye.z() - origin.y();
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = -origin;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> matrix = shift * homography;
  result.silhouette = GrayImage(camera.width, camera.height);
  cv::Mat1f turned = CoveragePlane(result.silhouette);
  cv::warpPerspective(coverage, turned, cv::Matx33d(matrix.data()), turned.size());
  cv::min(turned, 1.0, turned);
  cv::max(turned, 0.0, turned);
  return result;
}

// The image of a profile [m] that the published camera sees, black on white.
GrayImage RenderProfile(const Eigen::VectorXd& radius) {
  constexpr int kSamples = 4, kFraction = 4;  // bits of a coordinate below the pixel
  const Camera camera;
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius * camera.scale);
  std::vector<cv::Point> points;
  for (Eigen::Index i = 0; i < polygon.cols(); ++i) {
    const double column = (camera.cx + polygon(0, i) + 0.5) * kSamples - 0.5;
    const double row = (camera.cy - polygon(1, i) + 0.5) * kSamples - 0.5;
    points.emplace_back(cvRound(column * (1 << kFraction)), cvRound(row * (1 << kFraction)));
  }
  cv::Mat1b fine = cv::Mat1b::zeros(camera.height * kSamples, camera.width * kSamples);
  cv::fillPoly(fine, std::vector<std::vector<cv::Point>>{points}, 255, cv::LINE_8, kFraction);
  cv::Mat1b coarse;
  cv::resize(fine, coarse, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  GrayImage image(camera.width, camera.height);
  coarse.convertTo(CoveragePlane(image), CV_32F, 1 / 255.0);
  return image;
}

// Throws InputError for options that contradict one another.
void CheckOptions(const PhotoOptions& options) {
  if (options.support >= options.specimen)
    throw InputError("option 'support'", Format("found %g, expected less than specimen = %g m",
                                                options.support, options.specimen));
  if (options.marker == PhotoMarker::kTag && options.tag <= 0)
    throw InputError("option 'tag'",
                     "not given, expected the side of the tag's black square [m] "
                     "with marker = tag");
  if (options.marker == PhotoMarker::kNone && options.px_per_m <= 0)
    throw InputError("option 'px_per_m'",
                     "not given, expected the scale of the picture with "
                     "marker = none");
}

// The focal length [px of the photograph], which is by the diagonal: that of the options, or that
// of the file. Throws PhotoFailure where there is none, and for a file that was cropped.
double FocalLength(const Photograph& photo, const PhotoOptions& options) {
  constexpr double kFilmDiagonal = 43.2666;  // [mm]
  constexpr double kSameShape = 0.01;
  const double width = photo.image.width, height = photo.image.height;
  double focal = options.focal_35mm;
  if (focal <= 0) {
    focal = photo.exif.focal_35mm;
    if (focal <= 0)
      throw PhotoFailure{PhotoFault::kNoFocalLength,
                         "the file does not tell the focal length, expected EXIF data (send the "
                         "original file) or focal_35mm"};
    if (photo.exif.width > 0 && photo.exif.height > 0) {
      const double taken = double(std::max(photo.exif.width, photo.exif.height)) /
                           std::min(photo.exif.width, photo.exif.height);
      const double shown = std::max(width, height) / std::min(width, height);
      if (std::abs(taken / shown - 1) > kSameShape)
        throw PhotoFailure{PhotoFault::kCroppedPhoto,
                           Format("the photograph was cropped: it is %.0fx%.0f px and was taken "
                                  "with %dx%d, expected the whole photograph or focal_35mm",
                                  width, height, photo.exif.width, photo.exif.height)};
    }
  }
  return focal * std::hypot(width, height) / kFilmDiagonal;
}

// Throws PhotoFailure for an outline whose blur is a standard deviation [m] of too much.
void CheckBlur(double blur) {
  constexpr double kMost = 2.5e-3;  // [m]
  if (blur <= kMost) return;
  throw PhotoFailure{PhotoFault::kBlur,
                     Format("the outline is blurred over %.1f mm (standard deviation), expected at "
                            "most %.1f: hold the camera still and focus on the cloth",
                            1e3 * blur, 1e3 * kMost)};
}

constexpr int kAngles = 360;
constexpr double kDegree = M_PI / 180;

// The work on one photograph, step by step; what was found by then is in the overlay of a failure.
class Development {
 public:
  Development(const Photograph& photo, const PhotoOptions& options)
      : photo_(photo), options_(options), discs_(MakeDiscs(options)) {}

  PhotoResult Run() {
    try {
      CatchOpenCv([&] { Develop(); });
    } catch (const PhotoFailure& failure) {
      return Refuse(failure);
    }
    AddText();
    result_.overlay = RenderMarks(planes_, marks_);
    const cv::Rect flat = cv::boundingRect(marks_.flat);
    const double scale = double(result_.overlay.width) / planes_.rgb.cols;
    result_.specimen_box = scale * Eigen::Vector4d(flat.x, flat.y, flat.width, flat.height);
    return std::move(result_);
  }

 private:
  void Develop() {
    planes_ = MakePlanes(photo_.image);
    if (options_.marker != PhotoMarker::kNone) result_.focal = FocalLength(photo_, options_);
    Segment();
    if (options_.marker == PhotoMarker::kNone) {
      PlaceWithoutMarker();
    } else {
      Place();
    }
    Measure();
  }

  PhotoResult Refuse(const PhotoFailure& failure) {
    PhotoResult refused;
    refused.fault = failure.fault;
    refused.reason = failure.reason;
    refused.warnings = result_.warnings;
    marks_.faults = failure.marks;
    marks_.refused = true;
    marks_.text = std::string("Refused, ") + ToString(failure.fault) + ": " + failure.reason;
    refused.overlay = planes_.rgb.empty() ? photo_.image : RenderMarks(planes_, marks_);
    return refused;
  }

  void Segment() {
    if (options_.marker == PhotoMarker::kNone && TakeSilhouette()) return;
    FoundCloth found;
    const auto take = [&] {
      result_.warnings = found.seen;
      result_.warnings.insert(result_.warnings.end(), found.doubts.begin(), found.doubts.end());
      marks_.outline = found.outline;
      if (options_.marker == PhotoMarker::kDisc) rim_ = found.rim;
      if (rim_) marks_.disc = rim_->ellipse;
    };
    try {
      FindSilhouette(photo_.image, planes_,
                     {.threshold = options_.threshold,
                      .mask = options_.mask,
                      .cloth_points = options_.cloth_points,
                      .ground_points = options_.ground_points},
                     &found);
    } catch (const PhotoFailure&) {
      take();
      throw;
    }
    take();
    cloth_ = found.cloth;
    result_.contrast = cloth_.contrast;
  }

  // A mask or a silhouette is taken as it is. Returns whether the picture is one.
  bool TakeSilhouette() {
    GrayImage grey(photo_.image.width, photo_.image.height);
    for (size_t i = 0; i < grey.coverage.size(); ++i) {
      const uint8_t* rgb = &photo_.image.rgb[3 * i];
      grey.coverage[i] = 1.0f - float(rgb[0] + rgb[1] + rgb[2]) / (3 * 255.0f);
    }
    if (!options_.mask.empty() || !IsSilhouette(grey)) return false;
    const Silhouette silhouette = SegmentSilhouette(std::move(grey), "silhouette");
    if (silhouette.segmentation.photograph) return false;
    result_.warnings = silhouette.segmentation.Notes();
    const GrayImage& image = silhouette.image;
    cv::resize(CoveragePlane(image), cloth_.coverage, planes_.rgb.size(), 0, 0, cv::INTER_AREA);
    cloth_.mask = (cloth_.coverage >= 0.5f) / 255;
    cloth_.blur = 2.0;  // pixels may be black or white as a whole
    marks_.outline = LongestOutline(cloth_.mask);
    return true;
  }

  // Without a scale [m]: the height of a cloth that hangs straight down, the largest possible.
  double LeastBlur() const {
    const double radius = std::sqrt(cv::contourArea(marks_.outline) / M_PI);
    return cloth_.blur * discs_.support / radius;
  }

  void RequireMarker() {
    if (options_.marker == PhotoMarker::kTag) {
      marks_.tag = FindTag(planes_);
      if (!marks_.tag)
        throw PhotoFailure{PhotoFault::kNoTag,
                           "no AprilTag of family 36h11 is seen, expected one that lies flat and "
                           "is not covered"};
    } else if (!rim_) {
      CheckBlur(LeastBlur());  // which may be why
      throw PhotoFailure{PhotoFault::kNoDisc,
                         "the rim of the disc on the cloth is not seen, expected a disc of another "
                         "colour than the cloth, a printed tag (marker = tag), or a known scale "
                         "(marker = none)"};
    } else {
      result_.marker_share = rim_->share;
      if (rim_->is_line)
        Warn("the disc's rim is a line, as of a clear disc: the scale is uncertain by its width");
      if (rim_->share < 0.8)
        Warn(Format("the disc's rim is seen on %.0f %% of its length", 100 * rim_->share));
    }
  }

  void Place() {
    RequireMarker();
    PoseInput input{.focal = result_.focal * planes_.scale,
                    .principal = {0.5 * (planes_.rgb.cols - 1), 0.5 * (planes_.rgb.rows - 1)},
                    .rim = rim_ ? rim_->points : std::vector<Eigen::Vector2d>(),
                    .rim_radius = 0.5 * (options_.disc > 0 ? options_.disc : options_.support),
                    .rim_height = options_.disc_height,
                    .tag = marks_.tag,
                    .tag_side = options_.tag,
                    .tag_height = options_.tag_height,
                    .outline = {},
                    .discs = discs_};
    constexpr size_t kPoints = 120;
    for (size_t i = 0; i < kPoints; ++i) {
      const cv::Point p = marks_.outline[i * marks_.outline.size() / kPoints];
      input.outline.emplace_back(p.x, p.y);
    }
    const auto found = FindPose(input);
    CheckPose(found);
    scale_sd_ = found->height_sd;
    const Rectified rectified = Rectify(cloth_.coverage, found->pose);
    result_.silhouette = rectified.silhouette;
    result_.camera = rectified.camera;
    AddFlat([&](const Eigen::Vector3d& x) { return found->pose.ImageFromWorld(x); });
  }

  void CheckPose(const std::optional<FoundPose>& found) {
    constexpr double kMostTilt = 20 * kDegree, kNotedTilt = 12 * kDegree;
    constexpr double kLeastHeight = 2.0;                      // specimen diameters
    constexpr double kNotedHeight = 5.0, kMostHeight = 20.0;  // [m]
    constexpr double kNotedFocal = 0.03;                      // of the logarithm
    constexpr double kMostMarkerError = 2;                    // [px]
    if (!found || found->rms > kMostMarkerError)
      throw PhotoFailure{
          options_.marker == PhotoMarker::kTag ? PhotoFault::kNoTag : PhotoFault::kNoDisc,
          "no camera fits the marker that was found, expected a flat, horizontal "
          "one"};
    result_.tilt = found->pose.tilt;
    const double tilt = result_.tilt.norm();
    result_.marker_rms = found->rms / planes_.scale;
    const double height = found->pose.eye.z();
    if (tilt > kMostTilt)
      throw PhotoFailure{
          PhotoFault::kTilted,
          Format("the camera is tilted by %.0f degrees, expected at most 20: hold it "
                 "level above the support",
                 tilt / kDegree)};
    if (height < kLeastHeight * options_.specimen)
      throw PhotoFailure{PhotoFault::kTooClose,
                         Format("the camera is %.2f m above the support, expected at least %.2f m",
                                height, kLeastHeight * options_.specimen)};
    if (height > kMostHeight)
      throw PhotoFailure{PhotoFault::kWrongSize,
                         Format("the camera would be %.0f m above the support, expected at most "
                                "%.0f: are the focal length and the marker's size right?",
                                height, kMostHeight)};
    CheckCentre(found->first_harmonic);
    const double told = photo_.exif.focal_35mm, given = options_.focal_35mm;
    if (told > 0 && given > 0 && std::abs(std::log(given / told)) > kNotedFocal)
      Warn(Format("the file tells a focal length of %g mm; %g mm was given and used", told, given));
    if (height > kNotedHeight)
      Warn(
          Format("the camera seems to be %.1f m above the support, more than a stand or a hand "
                 "reaches: are the focal length and the marker's size right?",
                 height));
    if (tilt > kNotedTilt) Warn(Format("the camera is tilted by %.0f degrees", tilt / kDegree));
    if (found->tilt_sd > 1.5 * kDegree)
      Warn(Format("the tilt is known to %.1f degrees only", found->tilt_sd / kDegree));
  }

  void CheckCentre(double off) {
    constexpr double kMost = 6e-3, kNoted = 3e-3;  // [m]
    if (off <= kNoted) return;
    const std::string text = Format(
        "the outline is %.0f mm off the centre of the disc, expected at most %.0f: does the "
        "disc lie over the support, and the cloth in its middle?",
        1e3 * off, 1e3 * kNoted);
    if (off > kMost) throw PhotoFailure{PhotoFault::kWrongSize, text};
    Warn(text);
  }

  // The flat specimen, as the camera would see it.
  template <class Project>
  void AddFlat(const Project& image_from_world) {
    for (int k = 0; k < kAngles; ++k) {
      const double angle = 2 * M_PI * k / kAngles;
      const Eigen::Vector2d p = image_from_world(
          Eigen::Vector3d(discs_.specimen * std::cos(angle), discs_.specimen * std::sin(angle), 0));
      marks_.flat.emplace_back(cvRound(p.x()), cvRound(p.y()));
    }
  }

  void PlaceWithoutMarker() {
    const cv::Mat1f& coverage = cloth_.coverage;
    result_.silhouette = GrayImage(coverage.cols, coverage.rows);
    std::copy(coverage.begin(), coverage.end(), result_.silhouette.coverage.begin());
    Camera& camera = result_.camera;
    camera.width = coverage.cols;
    camera.height = coverage.rows;
    camera.scale = options_.px_per_m * planes_.scale;
    camera.cx = 0.5 * (camera.width - 1);
    camera.cy = 0.5 * (camera.height - 1);
    CentreOnFarCloth(result_.silhouette, &camera);
    if (!CentreOnOutline(result_.silhouette, &camera))
      throw PhotoFailure{PhotoFault::kNotADrape, "the outline does not close about its centre"};
    AddFlat([&](const Eigen::Vector3d& x) {
      Eigen::Vector2d image;
      camera.Project(x.data(), image.data());
      return image;
    });
  }

  void Measure() {
    constexpr double kNotedSd = 0.005;
    const Camera& camera = result_.camera;
    const double px_per_mm = 1e-3 * camera.pixels_per_metre();
    constexpr double kLeastScale = 0.5;  // [px/mm]
    if (px_per_mm < kLeastScale)
      throw PhotoFailure{PhotoFault::kTooSmall,
                         Format("the cloth is too small in the picture: %.2f px/mm, expected at "
                                "least %.1f",
                                px_per_mm, kLeastScale)};
    result_.blur = 1e-3 * cloth_.blur / px_per_mm;
    CheckBlur(result_.blur);
    Outline outline;
    if (!OutlineFromImage(result_.silhouette, camera, kAngles, &outline))
      throw PhotoFailure{PhotoFault::kNotADrape, "the outline does not close about the support"};
    const Eigen::VectorXd radius = VerticalProfile(outline.radius, camera, discs_);
    CheckOutline(outline, radius);
    result_.shape = MeasureShape(radius, discs_);
    result_.plane_coefficient =
        DrapeCoefficient(ProfileArea(MetresFromPixels(outline.radius, camera)), discs_);
    result_.coefficient_sd = CoefficientSd(result_.shape.drape_coefficient, radius);
    if (result_.coefficient_sd > kNotedSd)
      Warn(
          Format("the drape coefficient is known to %.1f points only: a sharper picture or one of "
                 "more pixels tells more",
                 100 * result_.coefficient_sd));
    result_.projected = RenderProfile(radius);
    result_.radius = radius;
  }

  // Adds the errors of the scale, the blurred edge of the outline, the estimated heights of the hem
  // and the focal length, which files tell to 1 mm.
  double CoefficientSd(double coefficient, const Eigen::VectorXd& radius) const {
    constexpr double kHem = 0.02;    // of the correction for the hem's heights
    constexpr double kEdge = 0.1;    // of the blur
    constexpr double kFocal = 0.29;  // [mm]
    const double ring =
        M_PI * (discs_.specimen * discs_.specimen - discs_.support * discs_.support);  // [m²]
    const Eigen::Matrix2Xd polygon = ProfilePolygon(radius);
    double length = (polygon.col(0) - polygon.col(polygon.cols() - 1)).norm();
    for (Eigen::Index i = 1; i < polygon.cols(); ++i)
      length += (polygon.col(i) - polygon.col(i - 1)).norm();
    const double correction = std::abs(coefficient - result_.plane_coefficient);
    const double focal = options_.focal_35mm > 0 ? options_.focal_35mm : photo_.exif.focal_35mm;
    const double edge =
        std::hypot(kEdge * result_.blur, cloth_.mixed_sd / result_.camera.pixels_per_metre());
    return std::hypot(2 * ProfileArea(radius) / ring * scale_sd_, length / ring * edge,
                      correction * std::hypot(kHem, focal > 0 ? kFocal / focal : 0.0));
  }

  void CheckOutline(const Outline& outline, const Eigen::VectorXd& radius) {
    constexpr double kSlack = 0.04, kNoted = 0.015;  // of the radius
    const double most = radius.maxCoeff() / discs_.specimen;
    const double least = radius.minCoeff() / discs_.support;
    const double overhang = ComputeOverhang(result_.silhouette, result_.camera, outline);
    if (overhang > kLargestOverhang)
      throw PhotoFailure{PhotoFault::kNotADrape,
                         Format("%.0f %% of the rays from the axis cross the outline more than "
                                "once, expected the outline of one drape",
                                100 * overhang)};
    const HemLength hem = MeasureHem(
        [&](const DrapeDiscs& other) {
          return VerticalProfile(outline.radius, result_.camera, other);
        },
        discs_);
    if (hem.usual > 0 && overhang > kNotedOverhang)
      throw PhotoFailure{PhotoFault::kNotADrape, kJagged};
    if (hem.usual > 0) throw PhotoFailure{PhotoFault::kWrongSize, SizeText(hem, discs_)};
    if (std::abs(std::log(hem.relative)) > kNotedHem) Warn(SizeText(hem, discs_));
    if (overhang > kNotedOverhang)
      Warn(
          Format("%.1f %% of the rays from the axis cross the outline more than once; the "
                 "outermost crossing counts",
                 100 * overhang));
    if (most > 1 + kSlack)
      throw PhotoFailure{PhotoFault::kWrongSize,
                         Format("the outline reaches %.0f mm from the axis, expected at most %.0f: "
                                "are specimen, support, disc and focal length right, and is "
                                "nothing beside the cloth?",
                                1e3 * radius.maxCoeff(), 1e3 * discs_.specimen)};
    if (least < 1 - kSlack)
      throw PhotoFailure{PhotoFault::kWrongSize,
                         Format("the outline comes to %.0f mm of the axis, expected at least %.0f: "
                                "are specimen, support and disc right, and is the cloth whole?",
                                1e3 * radius.minCoeff(), 1e3 * discs_.support)};
    if (DrapeCoefficient(ProfileArea(radius), discs_) < kLeastDrapeCoefficient)
      throw PhotoFailure{PhotoFault::kNoCloth,
                         "the outline is that of the disc: cloth and ground are too alike"};
    if (most > 1 + kNoted)
      Warn(Format("the outline reaches %.1f mm from the axis, more than the specimen's %.0f mm",
                  1e3 * radius.maxCoeff(), 1e3 * discs_.specimen));
  }

  void Warn(const std::string& text) { result_.warnings.push_back(text); }

  void AddText() {
    marks_.text = Format("Drape coefficient %.1f +- %.1f %% (estimate), %d folds. ",
                         100 * result_.shape.drape_coefficient, 100 * result_.coefficient_sd,
                         result_.shape.folds);
    if (result_.camera.kind == CameraKind::kPinhole)
      marks_.text += Format("Camera %.2f m above the support, tilted by %.1f degrees. ",
                            result_.camera.eye_height, result_.tilt.norm() / kDegree);
    marks_.text += "Blue: outline, green: disc, ochre: flat specimen.";
    for (const std::string& warning : result_.warnings) marks_.text += " Note: " + warning + ".";
  }

  const Photograph& photo_;
  const PhotoOptions& options_;
  const DrapeDiscs discs_;
  PhotoPlanes planes_;
  std::optional<DiscRim> rim_;
  double scale_sd_ = 0.0;  // relative
  RefinedCloth cloth_;
  PhotoMarks marks_;
  PhotoResult result_;
};

}  // namespace

PhotoResult MeasurePhoto(const Photograph& photo, const PhotoOptions& options) {
  CheckOptions(options);
  return Development(photo, options).Run();
}

}  // namespace drape
