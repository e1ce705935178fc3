// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "physics/mesh/scan_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/wrap.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<int, 3>>;

constexpr double kPelvisBottom = .45, kPelvisTop = .65;  // of the height
constexpr int kMaxFrames = 100000;
constexpr double kMaxSpeed = 20;  // of a vertex between two frames [m/s]

// The name with the number in the place of %0Nd or %d; without these one file, numbered 0.
class FrameNames {
 public:
  explicit FrameNames(const std::string& pattern) : before_(pattern) {
    const auto fail = [&] {
      throw InputError("body", "found '" + MakePrintableLine(pattern) +
                                   "', expected the name of a file, or a name with one number, "
                                   "such as body_%04d.obj");
    };
    const size_t percent = pattern.find('%');
    if (percent == std::string::npos) return;
    if (pattern.find('%', percent + 1) != std::string::npos) fail();
    size_t end = percent + 1;
    digits_ = 1;
    if (pattern[end] == '0' && end + 1 < pattern.size() && std::isdigit(pattern[end + 1])) {
      digits_ = pattern[end + 1] - '0';
      end += 2;
    }
    if (end >= pattern.size() || pattern[end] != 'd') fail();
    before_ = pattern.substr(0, percent);
    after_ = pattern.substr(end + 1);
  }
  std::string Name(int frame) const {
    return digits_ == 0 ? before_ : before_ + Format("%0*d", digits_, frame) + after_;
  }
  bool is_one() const { return digits_ == 0; }

 private:
  std::string before_, after_;
  int digits_ = 0;
};

// The place where faces of a surface meet, for a note: empty where none do, and nothing where
// contact cannot take the surface, which is open or has a face without an area.
std::optional<std::string> FindMeetings(const ObjSurface& surface, const std::string& path) {
  try {
    RequireClosed(surface, path);
  } catch (const InputError&) {
    return std::nullopt;
  }
  const auto found = FindSelfIntersections(surface.triangles, surface.x, 1 << 20);
  for (const auto& [one, other] : found)
    if (one == other) return std::nullopt;
  if (found.empty()) return "";
  const Vector3d place = Vertex(surface.x, surface.triangles[found[0].first][0]);
  return Format("%zu pairs of faces meet, one of them near (%.2f, %.2f, %.2f) m", found.size(),
                place.x(), place.y(), place.z());
}

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

void CheckSpeed(const Eigen::VectorXd& before, const Eigen::VectorXd& x, double frames_per_second,
                const std::string& path, const std::string& path_before) {
  for (int i = 0; i < x.size() / 3; ++i) {
    const double speed = (Vertex(x, i) - Vertex(before, i)).norm() * frames_per_second;
    if (speed > kMaxSpeed)
      throw InputError(path, Format("vertex %d moves at %.3g m/s, expected at most %g m/s from ",
                                    i + 1, speed, kMaxSpeed) +
                                 path_before);
  }
}

// A gap in the numbers would end the motion unnoticed. end: the number after the last frame.
void CheckNoLaterFrame(const FrameNames& names, int end) {
  constexpr int kLongestGap = 1000;
  for (int later = end + 1; later <= end + kLongestGap; ++later)
    if (std::filesystem::exists(names.Name(later)))
      throw InputError(names.Name(end), "is missing, but " + names.Name(later) +
                                            " exists, expected a file of each number");
}

class BodySequence : public Body {
 public:
  BodySequence(Triangles triangles, std::vector<Eigen::VectorXd> frames, const BodyFiles& files,
               double arm_angle)
      : Body(std::move(triangles), static_cast<int>(frames[0].size() / 3)),
        frames_(std::move(frames)) {
    files_ = files;
    num_files_ = static_cast<int>(frames_.size());
    if (files.grow) BeginThin(frames_[0], arm_angle);
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

  Eigen::VectorXd Positions(double t) const override { return Growing(t, Grown(t)); }

  Eigen::Isometry3d PelvisMotion(double t) const override {
    const Eigen::VectorXd x = Grown(t);
    Eigen::Matrix3Xd from(3, pelvis_.size()), to(3, pelvis_.size());
    for (size_t k = 0; k < pelvis_.size(); ++k) {
      from.col(k) = Vertex(frames_[0], pelvis_[k]);
      to.col(k) = Vertex(x, pelvis_[k]);
    }
    return Eigen::Isometry3d(Eigen::umeyama(from, to, /*with_scaling=*/false));
  }

 private:
  // Positions of the body as it is grown, from the beginning.
  Eigen::VectorXd Grown(double t) const {
    const double last = static_cast<double>(frames_.size()) - 1;
    const double place = std::clamp((t - start_) * files_.frames_per_second, 0.0, last);
    const size_t frame = std::min(static_cast<size_t>(place), frames_.size() - 1);
    if (frame + 1 == frames_.size()) return frames_[frame];
    const double share = place - static_cast<double>(frame);
    return (1 - share) * frames_[frame] + share * frames_[frame + 1];
  }

  std::vector<Eigen::VectorXd> frames_;
  std::vector<int> pelvis_;
};

// The surface with its faces turned outwards.
ObjSurface FacingOut(ObjSurface surface) {
  double volume = 0;
  for (const auto& t : surface.triangles)
    volume += Vertex(surface.x, t[0]).dot(Vertex(surface.x, t[1]).cross(Vertex(surface.x, t[2])));
  if (volume < 0)
    for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

// most: by how far parts were pressed in [m].
void NotePress(double most, const std::string& path) {
  if (most == 0) return;
  NoteInput(path, Format("parts that face one another at less than %g mm, as thighs may, are "
                         "pressed in by up to %.1f mm: cloth fits between them",
                         1e3 * kPartGap, 1e3 * most));
}

}  // namespace

void Body::BeginThin(const Eigen::VectorXd& person, double arm_angle) {
  person_ = person;
  limbs_ = Limbs({person, triangles_});
  if (arm_angle > 0) limbs_.TurnArms(arm_angle);
  MoveLimbs(arm_angle > 0);
}

// Draws the limbs together where they wait for the garment.
void Body::MoveLimbs(bool any) {
  weightless_until_ = kGrowSeconds;
  start_ = kGrowSeconds + (any ? kLowerSeconds : 0);
  Eigen::VectorXd x = person_;
  shrunk_ = limbs_.thin();
  limbs_.Move(1, x);
  limbs_.Move(1, shrunk_);
  shrunk_ -= x;
}

Eigen::VectorXd Body::Growing(double t, Eigen::VectorXd x) const {
  if (person_.size() == 0 || t >= start_) return x;
  limbs_.Move(1 - SmoothStep((t - kGrowSeconds) / kLowerSeconds), x);
  return x + (1 - SmoothStep(t / kGrowSeconds)) * shrunk_;
}

void Body::ReachInto(const std::vector<ClothTube>& tubes) {
  if (person_.size() == 0) return;
  std::string moved;
  for (const ClothTube& tube : tubes) {
    const std::string limb = limbs_.ReachInto(tube);
    if (!limb.empty()) moved += (moved.empty() ? "" : ", ") + limb;
  }
  if (moved.empty()) return;
  MoveLimbs(true);
  NoteInput("--body", moved + Format(": they begin in the garment, and are back in their place "
                                     "after %g s",
                                     start_));
}

std::unique_ptr<Body> ReadBodySequence(const std::string& name_pattern, const BodyFiles& files,
                                       double arm_angle) {
  const double frames_per_second = files.frames_per_second;
  if (!(frames_per_second >= 1 && frames_per_second <= 1e5))
    throw InputError("body",
                     Format("%g frames per second, expected 1 … 100000", frames_per_second));
  const FrameNames names(name_pattern);
  const int start = std::filesystem::exists(names.Name(0)) ? 0 : 1;
  const std::string first_path = names.Name(start);
  ObjSurface first = ReadSurface(first_path);
  const BodyFiles found = FindStance(first, files, first_path);
  Stand(found, first);
  ObjSurface body = FacingOut(first);
  std::optional<Follower> wrap;
  const std::optional<std::string> meetings = FindMeetings(body, first_path);
  if (!meetings) {
    body = Wrap(first);
    wrap.emplace(first, body.x);
    NoteInput(first_path,
              Format("the surface is open or has faces without an area: the cloth meets a wrap, "
                     "%g mm outside of it and over clefts of less than %g mm",
                     1e3 * kWrapOffset, 2e3 * kWrapGap));
  } else if (!meetings->empty()) {
    NoteInput(first_path, *meetings + ": cloth meets what is outside, and may be pinched there");
  }
  double most = PressIn(body);
  std::vector<Eigen::VectorXd> frames = {body.x};
  Eigen::VectorXd before = first.x;
  for (int k = start + 1;
       k < kMaxFrames && !names.is_one() && std::filesystem::exists(names.Name(k)); ++k) {
    const std::string path = names.Name(k);
    ObjSurface next = ReadSurface(path);
    Stand(found, next);
    CheckSameFaces(next, first, path, first_path);
    CheckSpeed(before, next.x, frames_per_second, path, names.Name(k - 1));
    before = next.x;
    ObjSurface posed{wrap ? wrap->At(next.x) : next.x, body.triangles};
    if (meetings == "" && FindMeetings(posed, path) != "")
      NoteInput(path, "the body meets itself from here on, and may pinch cloth");
    most = std::max(most, PressIn(posed));
    frames.push_back(std::move(posed.x));
  }
  NotePress(most, first_path);
  if (!names.is_one()) CheckNoLaterFrame(names, start + static_cast<int>(frames.size()));
  return std::make_unique<BodySequence>(std::move(body.triangles), std::move(frames), found,
                                        arm_angle);
}

std::unique_ptr<Body> ParseBody(const std::string& spec, double arm_angle, const BodyFiles& files) {
  constexpr char kMannequin[] = "mannequin:";
  if (!spec.starts_with(kMannequin)) return ReadBodySequence(spec, files, arm_angle);
  const auto kind =
      ParseName<MotionKind>(MakePrintableLine(spec.substr(sizeof(kMannequin) - 1)), "motion");
  return std::make_unique<Mannequin>(kind, arm_angle);
}

}  // namespace drape
