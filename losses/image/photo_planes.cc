// SPDX-License-Identifier: Apache-2.0
#include "losses/image/photo_planes.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kPlaceStep = 0.1;  // [px] between the places that are tried

constexpr int kWorkingSide = 2000;     // [px]
constexpr double kBorderShare = 0.04;  // of the shorter side
constexpr double kSaturated = 250;     // grey level without detail
constexpr double kSmoothing = 0.7;     // [px]

}  // namespace

double LightFromStored(double stored) {
  return stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4);
}

double StoredFromLight(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

const std::array<float, 256>& LightOfStored() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> light{};
    for (size_t i = 0; i < light.size(); ++i)
      light[i] = static_cast<float>(LightFromStored(static_cast<double>(i) / 255));
    return light;
  }();
  return table;
}

float LumaLight(const Eigen::Vector3f& stored) {
  return static_cast<float>(LightFromStored(stored.dot(Eigen::Vector3f(0.299f, 0.587f, 0.114f))));
}

float ShareOfMixture(const Eigen::Vector4f& seen, const Eigen::Vector3f& from,
                     const Eigen::Vector3f& across) {
  constexpr float kLeastContrast = 0.2f;  // of luma, of that of all colours
  constexpr int kRounds = 4;
  const auto luma_at = [&](float share) {
    return LumaLight((from + share * across).unaryExpr([](float light) {
      return static_cast<float>(StoredFromLight(std::max(light, 0.0f)));
    }));
  };
  const float first = luma_at(0), contrast = luma_at(1) - first;
  if (std::abs(contrast) <= kLeastContrast * across.norm())
    return (seen.head<3>() - from).dot(across) / std::max(across.squaredNorm(), 1e-8f);
  float share = (seen.w() - first) / contrast;
  if (share <= 0 || share >= 1) return share;
  for (int round = 0; round < kRounds; ++round) share += (seen.w() - luma_at(share)) / contrast;
  return share;
}

Eigen::Vector4f LightAt(const RgbImage& image, const Eigen::Vector2d& place) {
  const std::array<float, 256>& light = LightOfStored();
  const double column = std::clamp(place.x(), 0.0, image.width - 1.001);
  const double row = std::clamp(place.y(), 0.0, image.height - 1.001);
  const int c = static_cast<int>(column), r = static_cast<int>(row);
  const auto u = static_cast<float>(column - c), v = static_cast<float>(row - r);
  const auto pixel = [&](int dc, int dr) {
    const uint8_t* p = &image.rgb[3 * (size_t(r + dr) * image.width + c + dc)];
    return Eigen::Vector4f(light[p[0]], light[p[1]], light[p[2]],
                           LumaLight(Eigen::Vector3f(p[0], p[1], p[2]) / 255));
  };
  return (1 - v) * ((1 - u) * pixel(0, 0) + u * pixel(1, 0)) +
         v * ((1 - u) * pixel(0, 1) + u * pixel(1, 1));
}

Eigen::Index StepFinder::CountSamples(double reach, double step) {
  return 2 * static_cast<Eigen::Index>(std::floor(reach / step)) + 1;
}

StepFinder::StepFinder(double reach, double step, double sigma) : first_place_(-0.5 * reach) {
  const Eigen::Index samples = CountSamples(reach, step);
  for (double place = first_place_; place <= 0.5 * reach; place += kPlaceStep) {
    Basis model(samples, 4);
    for (Eigen::Index i = 0; i < samples; ++i) {
      const double t = (static_cast<double>(i) - 0.5 * static_cast<double>(samples - 1)) * step;
      const double after = 0.5 * std::erfc(-(t - place) / (std::sqrt(2.0) * sigma));
      model.row(i) << 1 - after, (1 - after) * t, after, after * t;
    }
    const Eigen::HouseholderQR<Basis> qr(model);
    bases_.emplace_back(qr.householderQ() * Basis::Identity(samples, 4));
  }
}

StepFinder::Step StepFinder::Find(const Eigen::VectorXd& samples) const {
  const double all = samples.squaredNorm();
  std::vector<double> misfit;
  for (const Basis& basis : bases_)
    misfit.push_back(all - (basis.transpose() * samples).squaredNorm());
  const auto least = std::min_element(misfit.begin(), misfit.end());
  const auto i = static_cast<size_t>(least - misfit.begin());
  Step found{first_place_ + kPlaceStep * static_cast<double>(i),
             std::sqrt(std::max(*least, 0.0) / static_cast<double>(samples.size())),
             i == 0 || i + 1 == misfit.size()};
  if (found.at_limit) return found;
  const double bend = misfit[i - 1] - 2 * misfit[i] + misfit[i + 1];
  if (bend > 0) found.place += 0.5 * kPlaceStep * (misfit[i - 1] - misfit[i + 1]) / bend;
  return found;
}

void CatchOpenCv(const std::function<void()>& work) {
  try {
    work();
  } catch (const cv::Exception& error) {
    throw PhotoFailure{PhotoFault::kOurs,
                       Format("OpenCV says \"%s\" in %s; please report it with the picture",
                              error.err.c_str(), error.func.c_str())};
  }
}

PhotoPlanes MakePlanes(const RgbImage& image) {
  constexpr double kMostLight = 65535;
  constexpr double kLeastSide = 64, kMostAspect = 10;
  const auto [shorter, longer] = std::minmax(image.width, image.height);
  if (shorter < kLeastSide || longer > kMostAspect * shorter)
    throw PhotoFailure{
        PhotoFault::kTooSmall,
        Format("the picture is %dx%d px, expected at least %.0f px on each side, and "
               "one side at most %.0f times the other",
               image.width, image.height, kLeastSide, kMostAspect)};
  PhotoPlanes planes;
  const cv::Mat3b photo(image.height, image.width,
                        reinterpret_cast<cv::Vec3b*>(const_cast<uint8_t*>(image.rgb.data())));
  planes.size = photo.size();
  planes.scale = std::min(1.0, double(kWorkingSide) / std::max(image.width, image.height));
  cv::resize(photo, planes.rgb, {}, planes.scale, planes.scale, cv::INTER_AREA);
  cv::Mat1w table(1, 256);
  std::transform(LightOfStored().begin(), LightOfStored().end(), table.begin(),
                 [](float light) { return cv::saturate_cast<uint16_t>(kMostLight * light); });
  const auto reduce = [&](const auto& stored, auto* result) {
    cv::Mat light;
    cv::LUT(stored, table, light);
    cv::resize(light, light, {}, planes.scale, planes.scale, cv::INTER_AREA);
    light.convertTo(*result, CV_32F, 1 / kMostLight);
    cv::GaussianBlur(*result, *result, {}, kSmoothing);
  };
  reduce(photo, &planes.light);
  cv::Mat1b luma;
  cv::cvtColor(photo, luma, cv::COLOR_RGB2GRAY);
  reduce(luma, &planes.luma);
  cv::cvtColor(planes.light, planes.lab, cv::COLOR_LRGB2Lab);
  return planes;
}

double PhotoPlanes::WorkingBlur(double blur_of_photo) const {
  return std::hypot(scale * blur_of_photo, kSmoothing);
}

void CheckExposure(const PhotoPlanes& planes) {
  constexpr double kDarkest = 15;    // L* of the lightest thousandth
  constexpr double kOneColor = 0.2;  // standard deviation [Lab units]
  std::vector<float> lightness;
  for (int row = 0; row < planes.lab.rows; row += 4)
    for (int col = 0; col < planes.lab.cols; col += 4) lightness.push_back(planes.lab(row, col)[0]);
  const float high = Quantile(lightness, 0.999);
  if (high < kDarkest)
    throw PhotoFailure{PhotoFault::kDark,
                       Format("the photograph is too dark: its lightest parts have a lightness of "
                              "%.0f %%, expected at least %.0f",
                              high, kDarkest)};
  cv::Scalar mean, deviation;
  cv::meanStdDev(planes.lab, mean, deviation);
  if (cv::norm(deviation) < kOneColor)
    throw PhotoFailure{PhotoFault::kNoCloth,
                       "the picture is of one colour, expected one piece of cloth on a ground"};
}

void CheckGlare(const PhotoPlanes& planes, const cv::Mat1b& cloth) {
  constexpr double kMostOfGround = 0.02, kMostOfCloth = 0.004;
  constexpr double kReach = 0.03;  // of the cloth's side: what is farther inside hides no edge
  constexpr double kMostInside = 0.03;
  cv::Mat1b white;
  cv::inRange(planes.rgb, cv::Scalar::all(kSaturated), cv::Scalar::all(255), white);
  const double side = std::sqrt(double(cv::countNonZero(cloth)));
  // Back light or a white ground, or hardly any white.
  if (cv::mean(white, BorderMask(white.size()))[0] / 255 > kMostOfGround ||
      cv::countNonZero(white) <= kMostOfCloth * side * side)
    return;
  const cv::Mat1b inner = Eroded(cloth, static_cast<int>(kReach * side));
  const cv::Mat1b hull = FilledHull(cloth) * 255, glare = white & hull;
  const double share = cv::countNonZero(glare) / (side * side);
  if (share <= kMostInside &&
      cv::countNonZero(glare & (1 - inner) * 255) <= kMostOfCloth * side * side)
    return;
  throw PhotoFailure{PhotoFault::kGlare,
                     Format("glare: %.1f %% of the cloth is white without detail, expected light "
                            "that is not reflected into the camera",
                            100 * share),
                     {LongestOutline(glare / 255)}};
}

cv::Mat1b FilledHull(const cv::Mat1b& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  std::vector<cv::Point> places, hull;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  for (const auto& outline : outlines) places.insert(places.end(), outline.begin(), outline.end());
  cv::Mat1b inside = cv::Mat1b::zeros(mask.size());
  if (places.empty()) return inside;
  cv::convexHull(places, hull);
  cv::fillConvexPoly(inside, hull, 1);
  return inside;
}

std::vector<cv::Point> LongestOutline(const cv::Mat1b& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (outlines.empty()) return {};
  return *std::max_element(outlines.begin(), outlines.end(),
                           [](const auto& a, const auto& b) { return a.size() < b.size(); });
}

cv::Mat1b BorderMask(cv::Size size) {
  const int width = std::max(2, static_cast<int>(kBorderShare * std::min(size.width, size.height)));
  cv::Mat1b border(size, 1);
  border(cv::Rect(width, width, size.width - 2 * width, size.height - 2 * width)) = 0;
  return border;
}

cv::Mat1b RoundElement(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

cv::Mat1b Eroded(const cv::Mat1b& mask, int radius) {
  cv::Mat1b eroded;
  cv::erode(mask, eroded, RoundElement(radius));
  return eroded;
}
cv::Mat1b Dilated(const cv::Mat1b& mask, int radius) {
  cv::Mat1b dilated;
  cv::dilate(mask, dilated, RoundElement(radius));
  return dilated;
}

cv::Mat1b LargestFilled(const cv::Mat1b& mask) {
  cv::Mat1b filled = cv::Mat1b::zeros(mask.size());
  const std::vector<cv::Point> outline = LongestOutline(mask);
  if (!outline.empty())
    cv::drawContours(filled, std::vector<std::vector<cv::Point>>{outline}, 0, 1, cv::FILLED);
  return filled;
}

}  // namespace drape
