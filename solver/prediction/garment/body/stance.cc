// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/stance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Vector3d Axis(const std::string& name) {
  const double sign = name.front() == '-' ? -1 : 1;
  return sign * Vector3d::Unit(name.back() - 'x');
}

std::string AxisName(int axis, bool negative) {
  return std::string(negative ? "-" : "") + static_cast<char>('x' + axis);
}

// The surface as the middles of its faces, weighed by their areas.
class Samples {
 public:
  explicit Samples(const ObjSurface& surface) {
    const auto count = static_cast<Eigen::Index>(surface.triangles.size());
    middle_.resize(3, count);
    area_.resize(count);
    for (Eigen::Index t = 0; t < count; ++t) {
      const auto corner = [&](int k) -> Vector3d {
        return surface.x.segment<3>(3 * surface.triangles[t][k]);
      };
      middle_.col(t) = (corner(0) + corner(1) + corner(2)) / 3;
      area_[t] = (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
      volume_ += corner(0).dot(corner(1).cross(corner(2))) / 6;
    }
    low_ = middle_.rowwise().minCoeff();
    extent_ = middle_.rowwise().maxCoeff() - low_;
  }
  const Vector3d& extent() const { return extent_; }
  // The share of its box that the body fills.
  double fill() const { return std::abs(volume_) / extent_.prod(); }

  // Ranges from 0, mirrored about the middle of an axis, to 2.
  double Asymmetry(int axis) const {
    constexpr int kBins = 16;
    std::array<double, kBins> bin = {};
    for (Eigen::Index t = 0; t < area_.size(); ++t)
      bin[std::min(kBins - 1, static_cast<int>(kBins * Share(axis, t)))] += area_[t];
    double apart = 0;
    for (int k = 0; k < kBins; ++k) apart += std::abs(bin[k] - bin[kBins - 1 - k]);
    return apart / area_.sum();
  }

  struct Slab {
    double least = HUGE_VAL, most = -HUGE_VAL, mean = 0, spread = 0;  // spread: about the middle
    double width() const { return most - least; }
  };
  // Along `axis`, of the samples between two shares of the height, which is along `up`.
  Slab Between(int up, bool turned, double from, double to, int axis) const {
    Slab slab;
    double area = 0;
    const double middle = low_[axis] + extent_[axis] / 2;
    for (Eigen::Index t = 0; t < area_.size(); ++t) {
      const double share = turned ? 1 - Share(up, t) : Share(up, t);
      if (share < from || share > to) continue;
      const double place = middle_(axis, t);
      slab.least = std::min(slab.least, place);
      slab.most = std::max(slab.most, place);
      slab.mean += area_[t] * place;
      slab.spread += area_[t] * std::abs(place - middle);
      area += area_[t];
    }
    slab.mean /= area;
    slab.spread /= area;
    return slab;
  }

 private:
  double Share(int axis, Eigen::Index t) const {
    return (middle_(axis, t) - low_[axis]) / extent_[axis];
  }

  Eigen::Matrix3Xd middle_;
  Eigen::VectorXd area_;
  double volume_ = 0;
  Vector3d low_, extent_;
};

// Which axes of the file are those of a person: up, sideways and to the front.
struct Axes {
  int up, side, depth;
  bool turned = false, backwards = false;  // against the axis
};

Axes FindAxes(const Samples& samples) {
  constexpr double kMuchLonger = 1.3;  // a body without arms held out
  const Vector3d& extent = samples.extent();
  std::array<int, 3> order = {2, 1, 0};  // of extents that are alike the last axis is up
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
  Axes axes{order[0], order[1], order[2]};
  if (extent[axes.up] < kMuchLonger * extent[axes.side] &&
      samples.Asymmetry(axes.side) > samples.Asymmetry(axes.up))
    std::swap(axes.up, axes.side);
  constexpr double kEnd = .06;  // of the height
  axes.turned = samples.Between(axes.up, false, 1 - kEnd, 1, axes.side).spread >
                samples.Between(axes.up, false, 0, kEnd, axes.side).spread;
  return axes;
}

// The toes of a person are further off the ankles than the heels. Where the feet do not tell,
// `backwards` is as other programs have it.
void FindFront(const Samples& samples, Axes* axes) {
  constexpr double kTells = .01;  // of the height
  const auto foot = samples.Between(axes->up, axes->turned, 0, .05, axes->depth);
  const double ankle = samples.Between(axes->up, axes->turned, .07, .14, axes->depth).mean;
  const double toes = (foot.least + foot.most) / 2 - ankle;
  axes->backwards = std::abs(toes) > kTells * samples.extent()[axes->up]
                        ? toes < 0
                        : axes->up == 2 && axes->depth == 1;
}

// A head on shoulders, legs below arms or hips, no deeper than a belly is, and far from a box.
bool IsPerson(const Samples& samples, const Axes& axes) {
  const double height = samples.extent()[axes.up];
  const auto within = [&](double length, double least, double most) {
    return length >= least * height && length <= most * height;
  };
  const auto width = [&](double from, double to) {
    return samples.Between(axes.up, axes.turned, from, to, axes.side).width();
  };
  const double head = width(.92, 1);
  return within(samples.extent()[axes.depth], .08, .6) &&
         within(samples.extent()[axes.side], .2, 1.3) && within(head, .04, .25) &&
         width(.7, .85) > 1.3 * head && width(.4, .85) > 1.05 * width(.15, .3) &&
         samples.fill() < .35;
}

// The unit that makes a height that of a person [m], or 0.
double FindUnit(double height) {
  for (const double unit : {1.0, .1, .01, .001, .3048, .0254})
    if (height * unit >= 1.4 && height * unit <= 2.2) return unit;
  for (const double unit : {1.0, .01, .001})
    if (height * unit >= .5 && height * unit <= 1.4) return unit;
  return 0;
}

std::string SizeText(const Vector3d& size, const char* unit) {
  return Format("%.4g%s along x, %.4g%s along y and %.4g%s along z", size.x(), unit, size.y(), unit,
                size.z(), unit);
}

void CheckUpright(const ObjSurface& body, const BodyFiles& files, const std::string& where) {
  constexpr double kSmallest = 0.4, kLargest = 2.8;  // of people, arms out [m]
  constexpr double kDeepest = 1.5, kWidest = 2.0;    // of the height
  const Vector3d size = Extents(body);
  const std::string extent = where + Format(": extent, with --body_scale=%g", files.scale);
  CheckUsual(extent, size.maxCoeff(), "m", kSmallest, kLargest);
  if (!(size.maxCoeff() >= .1 && size.maxCoeff() <= 10))
    throw InputError(extent, Format("found %g m, expected .1 … 10 m", size.maxCoeff()));
  if (size.y() > kDeepest * size.z() || size.x() > kWidest * size.z())
    throw InputError(where, "found a body of " + SizeText(size, " m") + " with --body_up=" +
                                files.up + ", expected one that is upright along z; try --body_up" +
                                (files.up == "z" ? "=y" : "=z"));
}

// The move that puts feet and hips of a body in metres in their place [m].
std::vector<double> FindOffset(const ObjSurface& body) {
  constexpr double kFloor = .05, kHips = .1;  // that far off nothing is moved [m]
  const auto x = body.x.reshaped(3, body.x.size() / 3);
  const double low = x.row(2).minCoeff();
  const Samples samples(body);
  std::vector<double> offset = {0, 0, std::abs(low) > kFloor ? -low : 0};
  for (int axis = 0; axis < 2; ++axis) {
    const auto hips = samples.Between(2, false, .52, .6, axis);
    const double middle = axis == 0 ? (hips.least + hips.most) / 2 : hips.mean;
    if (std::abs(middle) > kHips) offset[axis] = -middle;
  }
  return offset;
}

}  // namespace

void Stand(const BodyFiles& files, ObjSurface& surface) {
  const Vector3d up = Axis(files.up), front = Axis(files.front);
  Eigen::Matrix3d turn;
  turn << up.cross(front).transpose(), -front.transpose(), up.transpose();
  const Vector3d offset(files.offset[0], files.offset[1], files.offset[2]);
  for (Eigen::Index i = 0; i < surface.x.size(); i += 3)
    surface.x.segment<3>(i) = files.scale * turn * surface.x.segment<3>(i) + offset;
}

BodyFiles FindStance(const ObjSurface& surface, const BodyFiles& files, const std::string& where) {
  BodyFiles found = files;
  const Vector3d size = Extents(surface);
  if (found.up == "auto") {
    const Samples samples(surface);
    Axes axes = FindAxes(samples);
    if (!(size.minCoeff() > 0) || !IsPerson(samples, axes))
      throw InputError(where, "found a surface of " + SizeText(size, "") +
                                  ", whose proportions are not those of a standing person; a body "
                                  "that is none needs --body_up, --body_scale and --body_offset");
    FindFront(samples, &axes);
    found.up = AxisName(axes.up, axes.turned);
    if (found.front == "auto") found.front = AxisName(axes.depth, axes.backwards);
  }
  if (found.front == "auto")
    found.front = found.up == "z" ? "-y" : found.up.back() == 'z' ? "y" : "z";
  const Vector3d up = Axis(found.up);
  if (up.dot(Axis(found.front)) != 0)
    throw InputError(where, "found --body_front=" + found.front + " and --body_up=" + found.up +
                                ", expected a front across the axis that points up");
  if (found.scale == 0) found.scale = FindUnit(std::abs(up.dot(size)));
  if (found.scale == 0)
    throw InputError(where, Format("found a body %.4g units tall, which no unit makes a person: "
                                   "give --body_scale, %.3g makes it 1.7 m tall",
                                   std::abs(up.dot(size)), 1.7 / std::abs(up.dot(size))));
  if (!found.offset.empty() && found.offset.size() != 3)
    throw InputError("--body_offset",
                     Format("found %zu numbers, expected x, y and z [m]", found.offset.size()));
  found.offset.resize(3, 0.0);
  ObjSurface standing = surface;
  Stand(found, standing);
  CheckUpright(standing, found, where);
  if (files.offset.empty()) found.offset = FindOffset(standing);
  const std::vector<double>& offset = found.offset;
  if ((files.up == "auto" && found.up != "z") ||
      (files.front == "auto" && files.up == "auto" && found.front != "-y") ||
      (files.scale == 0 && found.scale != 1) ||
      (files.offset.empty() && offset != std::vector<double>(3, 0.0)))
    NoteInput(where, Format("is read as a body %.2f m tall: --body_up=%s --body_front=%s "
                            "--body_scale=%g --body_offset=%.3g,%.3g,%.3g, guessed where not given",
                            Extents(standing).z(), found.up.c_str(), found.front.c_str(),
                            found.scale, offset[0], offset[1], offset[2]));
  return found;
}

}  // namespace drape
