// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "losses/image/segmentation.h"

// Internal to losses: the picture that is worked on, and its light. A lens blurs light, not
// the numbers that a file stores of it. A place where half of the light of either side falls is
// therefore found in linear light; by stored values, a light disc looks .3 standard deviations of
// the blur too large, a dark one too small.

namespace drape {

// The value below which this share of all lies, the upper median by default; 0 of no values.
template <typename T>
T Quantile(std::vector<T> values, double share = 0.5) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<long>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

// The coverage of an image, in its memory.
inline cv::Mat1f CoveragePlane(const GrayImage& image) {
  return {image.height, image.width, const_cast<float*>(image.coverage.data())};
}

// Between linear light and the values that a file stores of it, both 0 … 1 (IEC 61966-2-1, sRGB).
double LightFromStored(double stored);
double StoredFromLight(double light);

// The light of each stored byte.
const std::array<float, 256>& LightOfStored();

// The light of the luma (ITU-R BT.601), which a JPEG file has for each pixel, of stored values; it
// has their colour for four pixels together, by which edges between colours are blurred and, since
// it is not light that is averaged, shifted.
float LumaLight(const Eigen::Vector3f& stored);

// The light at a place of a picture, bilinear: red, green, blue, and that of the luma.
Eigen::Vector4f LightAt(const RgbImage& image, const Eigen::Vector2d& place);

// The share of the second light in what is seen, from + share·across, by its luma; by all of its
// colours where those two differ little in luma.
float ShareOfMixture(const Eigen::Vector4f& seen, const Eigen::Vector3f& from,
                     const Eigen::Vector3f& across);

// Finds a blurred step in samples along a line across it: least squares of
// (1 − Φ)·(a + b t) + Φ·(c + d t), Φ the normal distribution of (t − place)/sigma.
class StepFinder {
 public:
  struct Step {
    double place = 0.0;     // [px] from the middle of the samples
    double misfit = 0.0;    // root mean square, in units of the samples
    bool at_limit = false;  // of the search, which is half of the reach: no step was found
  };

  // Samples from −reach to reach [px].
  StepFinder(double reach, double step, double sigma);
  Step Find(const Eigen::VectorXd& samples) const;
  static Eigen::Index CountSamples(double reach, double step);

 private:
  using Basis = Eigen::Matrix<double, Eigen::Dynamic, 4>;
  double first_place_;
  std::vector<Basis> bases_;  // orthonormal, of the model at each place
};

// Ends the work on a photograph; MeasurePhoto makes a result with this fault of it.
struct PhotoFailure {
  PhotoFault fault;
  std::string reason;
  std::vector<std::vector<cv::Point>> marks = {};  // curves that show where, in the working picture
};

// Does work on a picture, and makes a PhotoFailure of an exception of OpenCV there, which is a
// fault of this program.
void CatchOpenCv(const std::function<void()>& work);

// A photograph at its working size.
struct PhotoPlanes {
  cv::Mat3b rgb;
  cv::Mat3f light;     // red, green and blue in linear light, slightly smoothed
  cv::Mat1f luma;      // the light of the luma, in the same way
  cv::Mat3f lab;       // the same in CIE Lab
  cv::Size size;       // of the photograph
  double scale = 1.0;  // working pixels to one of the photograph

  // The blur in the working picture for a blur in the photograph: standard deviations [px].
  double WorkingBlur(double blur_of_photo) const;
};
// Throws PhotoFailure for a picture that is too small or too narrow.
PhotoPlanes MakePlanes(const RgbImage& image);

// Throws PhotoFailure where nothing can be seen: of a dark picture, and of one of one colour.
void CheckExposure(const PhotoPlanes& planes);

// Throws PhotoFailure for a highlight on the cloth without detail.
void CheckGlare(const PhotoPlanes& planes, const cv::Mat1b& cloth);

// The pixels along the border of a picture.
cv::Mat1b BorderMask(cv::Size size);

// A round structuring element, and what it makes of a mask.
cv::Mat1b RoundElement(int radius);
cv::Mat1b Eroded(const cv::Mat1b& mask, int radius);
cv::Mat1b Dilated(const cv::Mat1b& mask, int radius);

// The convex hull of a mask.
cv::Mat1b FilledHull(const cv::Mat1b& mask);

// The longest closed outline of a mask.
std::vector<cv::Point> LongestOutline(const cv::Mat1b& mask);
cv::Mat1b LargestFilled(const cv::Mat1b& mask);

}  // namespace drape
