// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/mannequin.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<int, 3>>;

constexpr double kPelvisBottom = .45, kPelvisTop = .65;  // of the height
constexpr int kMaxFrames = 100000;

Vector3d Vertex(const Eigen::VectorXd& x, int i) { return x.segment<3>(3 * i); }

// The name with the number in the place of %0Nd or %d.
class FrameNames {
 public:
  explicit FrameNames(const std::string& pattern) {
    const auto fail = [&] {
      throw InputError("body", "found '" + MakePrintableLine(pattern) +
                                   "', expected a name with one number, such as body_%04d.obj");
    };
    const size_t percent = pattern.find('%');
    if (percent == std::string::npos || pattern.find('%', percent + 1) != std::string::npos) fail();
    size_t end = percent + 1;
    if (pattern[end] == '0' && end + 1 < pattern.size() && std::isdigit(pattern[end + 1])) {
      digits_ = pattern[end + 1] - '0';
      end += 2;
    }
    if (end >= pattern.size() || pattern[end] != 'd') fail();
    before_ = pattern.substr(0, percent);
    after_ = pattern.substr(end + 1);
  }
  std::string Name(int frame) const { return before_ + Format("%0*d", digits_, frame) + after_; }

 private:
  std::string before_, after_;
  int digits_ = 1;
};

std::string FaceText(const std::array<int, 3>& t) {
  return Format("%d %d %d", t[0] + 1, t[1] + 1, t[2] + 1);
}

void CheckSameFaces(const ObjSurface& surface, const ObjSurface& first, const std::string& path,
                    const std::string& first_path) {
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(path, found + ", expected " + expected + " as in " + first_path);
  };
  if (surface.x.size() != first.x.size())
    fail(Format("%d vertices", int(surface.x.size() / 3)), Format("%d", int(first.x.size() / 3)));
  if (surface.triangles.size() != first.triangles.size())
    fail(Format("%zu faces", surface.triangles.size()), Format("%zu", first.triangles.size()));
  for (size_t f = 0; f < first.triangles.size(); ++f)
    if (surface.triangles[f] != first.triangles[f])
      fail(Format("face %zu is ", f + 1) + FaceText(surface.triangles[f]),
           FaceText(first.triangles[f]));
}

void CheckSpeed(const Eigen::VectorXd& before, const Eigen::VectorXd& x,
                const BodySequenceOptions& options, const std::string& path,
                const std::string& path_before) {
  for (int i = 0; i < x.size() / 3; ++i) {
    const double speed = (Vertex(x, i) - Vertex(before, i)).norm() * options.frames_per_second;
    if (speed > options.max_speed)
      throw InputError(path, Format("vertex %d moves at %.3g m/s, expected at most %g m/s from ",
                                    i + 1, speed, options.max_speed) +
                                 path_before);
  }
}

class BodySequence : public Body {
 public:
  BodySequence(Triangles triangles, std::vector<Eigen::VectorXd> frames, double frames_per_second)
      : Body(std::move(triangles), static_cast<int>(frames[0].size() / 3)),
        frames_(std::move(frames)),
        frames_per_second_(frames_per_second) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < num_vertices(); ++i) {
      low = std::min(low, frames_[0][3 * i + 2]);
      high = std::max(high, frames_[0][3 * i + 2]);
    }
    for (int i = 0; i < num_vertices(); ++i) {
      const double share = (frames_[0][3 * i + 2] - low) / (high - low);
      if (share >= kPelvisBottom && share <= kPelvisTop) pelvis_.push_back(i);
    }
    if (pelvis_.size() < 3) {
      pelvis_.clear();
      for (int i = 0; i < num_vertices(); ++i) pelvis_.push_back(i);
    }
  }

  Eigen::VectorXd Positions(double t) const override {
    const double last = static_cast<double>(frames_.size()) - 1;
    const double place = std::clamp(t * frames_per_second_, 0.0, last);
    const size_t frame = std::min(static_cast<size_t>(place), frames_.size() - 1);
    if (frame + 1 == frames_.size()) return frames_[frame];
    const double share = place - static_cast<double>(frame);
    return (1 - share) * frames_[frame] + share * frames_[frame + 1];
  }

  Eigen::Isometry3d PelvisMotion(double t) const override {
    const Eigen::VectorXd x = Positions(t);
    Eigen::Matrix3Xd from(3, pelvis_.size()), to(3, pelvis_.size());
    for (size_t k = 0; k < pelvis_.size(); ++k) {
      from.col(k) = Vertex(frames_[0], pelvis_[k]);
      to.col(k) = Vertex(x, pelvis_[k]);
    }
    return Eigen::Isometry3d(Eigen::umeyama(from, to, /*with_scaling=*/false));
  }

 private:
  std::vector<Eigen::VectorXd> frames_;
  double frames_per_second_;
  std::vector<int> pelvis_;
};

}  // namespace

std::unique_ptr<Body> ReadBodySequence(const std::string& name_pattern,
                                       const BodySequenceOptions& options) {
  if (!(options.frames_per_second >= 1 && options.frames_per_second <= 1e5))
    throw InputError(
        "body", Format("%g frames per second, expected 1 … 100000", options.frames_per_second));
  if (!(options.max_speed > 0))
    throw InputError("body", Format("a largest speed of %g m/s, expected > 0", options.max_speed));
  const FrameNames names(name_pattern);
  const int start = std::filesystem::exists(names.Name(0)) ? 0 : 1;
  const std::string first_path = names.Name(start);
  const ObjSurface first = ReadObjSurface(first_path);
  RequireClosed(first, first_path);
  RequireSolid(first, first_path);
  std::vector<Eigen::VectorXd> frames = {first.x};
  for (int k = start + 1; k < kMaxFrames && std::filesystem::exists(names.Name(k)); ++k) {
    const std::string path = names.Name(k);
    ObjSurface next = ReadObjSurface(path);
    CheckSameFaces(next, first, path, first_path);
    CheckSpeed(frames.back(), next.x, options, path, names.Name(k - 1));
    RequireSolid(next, path);
    frames.push_back(std::move(next.x));
  }
  return std::make_unique<BodySequence>(first.triangles, std::move(frames),
                                        options.frames_per_second);
}

std::unique_ptr<Body> ParseBody(const std::string& spec, double arm_angle,
                                const BodySequenceOptions& options) {
  constexpr char kMannequin[] = "mannequin:";
  if (!spec.starts_with(kMannequin)) return ReadBodySequence(spec, options);
  const auto kind =
      ParseName<MotionKind>(MakePrintableLine(spec.substr(sizeof(kMannequin) - 1)), "motion");
  return std::make_unique<Mannequin>(kind, arm_angle);
}

}  // namespace drape
