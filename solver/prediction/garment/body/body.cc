// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
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

constexpr double kLowerSeconds = .75;  // in which the arms come down

Vector3d Vertex(const Eigen::VectorXd& x, int i) { return x.segment<3>(3 * i); }

// Rises from 0 at s ≤ 0 to 1 at s ≥ 1, with two continuous derivatives.
double SmoothStep(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

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

// The arms of a standing person, which move about the shoulders for dressing.
class Arms {
 public:
  Arms() = default;
  // x: the person, facing −y; contracted: its limbs drawn together to their axes (Contract). The
  // arms turn to `angle` off the body [rad].
  Arms(const Eigen::VectorXd& x, const Eigen::VectorXd& contracted, double angle) {
    constexpr double kShoulderHeight = .802, kShoulderWidth = .098;  // of the height, as ours
    constexpr double kLeast = .05, kOut = .12, kReach = .6, kAboveKnees = .38;  // of the height
    const auto heights = x.reshaped(3, x.size() / 3).row(2);
    const double low = heights.minCoeff(), height = heights.maxCoeff() - low;
    share_ = Eigen::VectorXd::Zero(x.size() / 3);
    for (const int side : {1, -1}) {
      Arm& arm = arms_[side < 0];
      arm.joint = {side * kShoulderWidth * height, 0, low + kShoulderHeight * height};
      Vector3d tip = arm.joint;
      for (int i = 0; i < share_.size(); ++i) {
        const Vector3d p = Vertex(x, i);
        if (side * p.x() < kOut * height || side * p.x() > kReach * height ||
            p.z() < low + kAboveKnees * height)
          continue;
        if (across(p - arm.joint).norm() > across(tip - arm.joint).norm()) tip = p;
      }
      arm.length = across(tip - arm.joint).norm();
      const Vector3d along = across(tip - arm.joint).normalized();
      if (arm.length < 3 * kLeast * height) continue;
      arm.hangs = std::atan2(side * along.x(), -along.z());
      Turn(side < 0, angle);
      for (int i = 0; i < share_.size(); ++i) {
        const Vector3d p = across(Vertex(contracted, i) - arm.joint);
        const double far = p.dot(along), off = (p - far * along).norm();
        const double share = SmoothStep(far / (kLeast * height)) *
                             (1 - SmoothStep((off / height - kLeast / 2) / kLeast));
        if (share > std::abs(share_[i])) share_[i] = side * share;
      }
    }
  }
  // Turns an arm to an angle off the body [rad].
  void Turn(int side, double angle) {
    arms_[side].turn =
        Eigen::AngleAxisd((side == 0 ? 1 : -1) * (arms_[side].hangs - angle), Vector3d::UnitY());
  }
  // Moves the middle of an arm to that of its sleeve. x: the body as it begins until then.
  void Shift(int side, const Vector3d& sleeve, const Eigen::VectorXd& x) {
    if (arms_[side].length > 0) arms_[side].shift = sleeve - Middle(x, side, sleeve);
  }
  // Moves the arms of x by a share of their way.
  void Move(double share, Eigen::VectorXd& x) const {
    for (int i = 0; i < share_.size(); ++i) {
      const Arm& arm = arms_[share_[i] < 0];
      const double part = share * std::abs(share_[i]);
      const Eigen::AngleAxisd turn(part * arm.turn.angle(), arm.turn.axis());
      x.segment<3>(3 * i) = arm.joint + part * arm.shift + turn * (Vertex(x, i) - arm.joint);
    }
  }

 private:
  struct Arm {
    Vector3d joint = Vector3d::Zero(), shift = Vector3d::Zero();  // [m]
    double length = 0, hangs = 0;                                 // [m]; off the body [rad]
    Eigen::AngleAxisd turn = Eigen::AngleAxisd::Identity();
  };
  static Vector3d across(const Vector3d& p) { return {p.x(), 0, p.z()}; }

  // The middle of an arm, as far from its shoulder as a place.
  Vector3d Middle(const Eigen::VectorXd& x, int side, const Vector3d& place) const {
    constexpr double kWidth = .03;  // [m]
    const Arm& arm = arms_[side];
    const double far = std::min((place - arm.joint).norm(), arm.length - kWidth);
    Vector3d sum = Vector3d::Zero();
    double weights = 0;
    for (int i = 0; i < share_.size(); ++i) {
      if (share_[i] == 0 || (share_[i] < 0) != (side == 1)) continue;
      const double apart = ((Vertex(x, i) - arm.joint).norm() - far) / kWidth;
      const double weight = std::abs(share_[i]) * std::exp(-apart * apart);
      sum += weight * Vertex(x, i);
      weights += weight;
    }
    return sum / weights;
  }

  Eigen::VectorXd share_;  // of the motion, of each vertex; negative: of the right arm
  std::array<Arm, 2> arms_ = {};
};

// How far the vertices of a body are off when it begins to grow [m]: towards its limbs' axes. Legs
// are not drawn up or down, as the crotch would come down between them.
Eigen::VectorXd Shrunk(const Eigen::VectorXd& x, const Eigen::VectorXd& contracted) {
  constexpr double kShare = .75, kHips = .5, kChest = .65;  // of the way; of the height
  Eigen::VectorXd shrunk = kShare * (contracted - x);
  const auto heights = x.reshaped(3, x.size() / 3).row(2);
  const double low = heights.minCoeff(), height = heights.maxCoeff() - low;
  for (Eigen::Index i = 2; i < x.size(); i += 3)
    shrunk[i] *= SmoothStep(((x[i] - low) / height - kHips) / (kChest - kHips));
  return shrunk;
}
// A limb of this radius is drawn together to half of it or less [m].
constexpr double kLimb = .17;

class BodySequence : public Body {
 public:
  BodySequence(Triangles triangles, std::vector<Eigen::VectorXd> frames, const BodyFiles& files,
               double arm_angle)
      : Body(std::move(triangles), static_cast<int>(frames[0].size() / 3)),
        frames_(std::move(frames)) {
    files_ = files;
    num_files_ = static_cast<int>(frames_.size());
    if (files.grow) {
      start_ = weightless_until_ = kGrowSeconds;
      if (arm_angle > 0) {
        arms_ = Arms(frames_[0], Contract({frames_[0], this->triangles()}, kLimb), arm_angle);
        start_ += kLowerSeconds;
      }
      Begin();
    }
    rests_after_ = start_ + (num_files_ - 1) / files_.frames_per_second;
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
    if (t >= start_) return Grown(t);
    Eigen::VectorXd x = frames_[0];
    arms_.Move(1 - SmoothStep((t - kGrowSeconds) / kLowerSeconds), x);
    return x + (1 - SmoothStep(t / kGrowSeconds)) * shrunk_;
  }

  void ReachInto(const Sleeves& sleeves) override {
    if (!files_.grow) return;
    for (int side = 0; side < 2; ++side)
      if (sleeves[side].angle > 0) arms_.Turn(side, sleeves[side].angle);
    Begin();
    const Eigen::VectorXd x = Positions(0);
    for (int side = 0; side < 2; ++side)
      if (sleeves[side].angle > 0) arms_.Shift(side, sleeves[side].middle, x);
    Begin();
  }

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
  // Draws the limbs together where they wait for the garment.
  void Begin() {
    Eigen::VectorXd x = frames_[0];
    arms_.Move(1, x);
    shrunk_ = Shrunk(x, Contract({x, triangles()}, kLimb));
  }
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
  double start_ = 0;  // of the motion [s]
  Arms arms_;
  Eigen::VectorXd shrunk_;  // how far the vertices are off at t = 0 [m]
  std::vector<int> pelvis_;
};

}  // namespace

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
  double volume = 0;
  for (const auto& t : first.triangles)
    volume += Vertex(first.x, t[0]).dot(Vertex(first.x, t[1]).cross(Vertex(first.x, t[2])));
  ObjSurface body = first;
  if (volume < 0)
    for (auto& t : body.triangles) std::swap(t[1], t[2]);
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
  if (most > 0)
    NoteInput(first_path, Format("parts that face one another at less than %g mm, as thighs may, "
                                 "are pressed in by up to %.1f mm: cloth fits between them",
                                 1e3 * kPartGap, 1e3 * most));
  if (!names.is_one()) CheckNoLaterFrame(names, start + static_cast<int>(frames.size()));
  return std::make_unique<BodySequence>(std::move(body.triangles), std::move(frames), found,
                                        arm_angle);
}

std::unique_ptr<Body> ParseBody(const std::string& spec, double arm_angle, const BodyFiles& files,
                                bool grows_as_files) {
  constexpr char kMannequin[] = "mannequin:";
  if (!spec.starts_with(kMannequin)) return ReadBodySequence(spec, files, arm_angle);
  const auto kind =
      ParseName<MotionKind>(MakePrintableLine(spec.substr(sizeof(kMannequin) - 1)), "motion");
  return std::make_unique<Mannequin>(kind, arm_angle, grows_as_files);
}

// The file mannequin.obj as it was when the library was built.
extern const char* const kMannequinObj;

namespace {

using Eigen::AngleAxisd;
// The bones of the mannequin, 1.72 m tall, in its rest pose: arms 25° off the body, legs apart.
// Right is −x and mirrors left.
enum Bone {
  kPelvis,
  kBelly,
  kChest,
  kNeck,
  kHead,
  kUpperArm,  // left, then right, and so on
  kForearm = kUpperArm + 2,
  kHand = kForearm + 2,
  kThigh = kHand + 2,
  kShin = kThigh + 2,
  kFoot = kShin + 2,
  kNumBones = kFoot + 2
};

// One of the shapes of which a bone's flesh is the union: a cone with round ends between two points
// [m], or an ellipsoid about the first of them.
struct Flesh {
  Vector3d a, b;
  double radius_a, radius_b;              // [m]
  Vector3d half_axes = Vector3d::Zero();  // of the ellipsoid [m], else zero
};

struct BoneShape {
  int parent;           // −1 for the pelvis
  Vector3d joint;       // about which it turns in its parent [m]
  Vector3d begin, end;  // its axis, towards which its flesh shrinks [m]
  std::vector<Flesh> flesh;
};

Flesh Cone(const Vector3d& a, const Vector3d& b, double radius_a, double radius_b) {
  return {a, b, radius_a, radius_b};
}

Flesh Ellipsoid(const Vector3d& centre, const Vector3d& half_axes) {
  return {centre, centre, 0, 0, half_axes};
}

// Moves a point of the left side to the right for side = 1.
Vector3d OnSide(int side, const Vector3d& left) {
  return side == 0 ? left : Vector3d(-left.x(), left.y(), left.z());
}

void AddTrunk(std::array<BoneShape, kNumBones>& bones) {
  bones[kPelvis] = {
      -1, {0, 0, .96}, {0, 0, .90}, {0, 0, 1.00}, {Ellipsoid({0, .012, .94}, {.160, .110, .125})}};
  bones[kBelly] = {kPelvis,
                   {0, 0, 1.04},
                   {0, 0, 1.00},
                   {0, 0, 1.18},
                   {Ellipsoid({0, 0, 1.09}, {.098, .074, .17})}};
  bones[kChest] = {kBelly,
                   {0, .01, 1.18},
                   {0, 0, 1.18},
                   {0, 0, 1.37},
                   {Ellipsoid({0, .005, 1.27}, {.142, .098, .165}),
                    Cone({-.145, .008, 1.378}, {.145, .008, 1.378}, .048, .048)}};
  bones[kNeck] = {kChest,
                  {0, .012, 1.42},
                  {0, .012, 1.42},
                  {0, 0, 1.50},
                  {Cone({0, .012, 1.40}, {0, 0, 1.52}, .052, .048)}};
  bones[kHead] = {kNeck,
                  {0, 0, 1.52},
                  {0, -.012, 1.55},
                  {0, -.012, 1.66},
                  {Ellipsoid({0, -.012, 1.605}, {.076, .093, .115})}};
}

void AddArm(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d down(std::sin(kRestArmAngle), 0, -std::cos(kRestArmAngle));
  const Vector3d shoulder(.168, .008, 1.380);
  const Vector3d elbow = shoulder + .28 * down, wrist = elbow + .25 * down,
                 fingers = wrist + .14 * down;
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kUpperArm + side] = {
      kChest, at(shoulder), at(shoulder), at(elbow), {Cone(at(shoulder), at(elbow), .050, .034)}};
  bones[kForearm + side] = {kUpperArm + side,
                            at(elbow),
                            at(elbow),
                            at(wrist),
                            {Cone(at(elbow), at(wrist), .034, .026),
                             Cone(at(elbow + .04 * down), at(elbow + .10 * down), .033, .030)}};
  bones[kHand + side] = {kForearm + side,
                         at(wrist),
                         at(wrist),
                         at(fingers),
                         {Cone(at(wrist + .05 * down), at(fingers), .036, .028)}};
}

void AddLeg(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d hip(.090, 0, .91), knee(.135, -.01, .50), ankle(.165, .02, .085);
  const Vector3d heel(.165, .035, .040), toes(.185, -.150, .034);
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kThigh + side] = {
      kPelvis, at(hip), at(hip), at(knee), {Cone(at(hip), at(knee), .083, .048)}};
  bones[kShin + side] = {kThigh + side,
                         at(knee),
                         at(knee),
                         at(ankle),
                         {Cone(at(knee), at(ankle), .046, .034),
                          Cone(at({.139, .010, .43}), at({.150, .022, .28}), .042, .036)}};
  bones[kFoot + side] = {
      kShin + side, at(ankle), at(heel), at(toes), {Cone(at(heel), at(toes), .040, .034)}};
}

// The cone with round ends, exact where the ends do not contain one another [m].
double ConeDistance(const Flesh& cone, const Vector3d& point) {
  const Vector3d axis = cone.b - cone.a, p = point - cone.a;
  const double length = axis.norm(), along = p.dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, p.squaredNorm() - along * along));
  const double slope = (cone.radius_a - cone.radius_b) / length;
  const double rise = std::sqrt(1 - slope * slope);
  const double foot = along - across * slope / rise;  // of the normal of the cone, on the axis
  if (foot < 0) return p.norm() - cone.radius_a;
  if (foot > length) return (point - cone.b).norm() - cone.radius_b;
  return across * rise + along * slope - cone.radius_a;
}

double EllipsoidDistance(const Flesh& ellipsoid, const Vector3d& point) {
  const Vector3d scaled = (point - ellipsoid.a).cwiseQuotient(ellipsoid.half_axes);
  const double value = scaled.norm();
  const double slope = scaled.cwiseQuotient(ellipsoid.half_axes).norm();
  if (slope < 1e-9) return -ellipsoid.half_axes.minCoeff();
  return value * (value - 1) / slope;
}

AngleAxisd About(const Vector3d& axis, double angle) { return {angle, axis}; }

// The rotation of each bone in its parent.
std::array<Eigen::Quaterniond, kNumBones> JointRotations(const Pose& pose) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  std::array<Eigen::Quaterniond, kNumBones> turn;
  turn.fill(Eigen::Quaterniond::Identity());
  turn[kPelvis] = (About(z, pose.yaw) * About(y, pose.roll));
  turn[kBelly] = About(z, pose.belly_twist);
  turn[kChest] = (About(z, pose.chest_twist) * About(x, pose.chest_bend));
  turn[kHead] = About(z, pose.head_turn);
  for (int side = 0; side < 2; ++side) {
    const double away = side == 0 ? -1 : 1;  // about y, from the body
    turn[kThigh + side] = About(x, -pose.hip[side]);
    turn[kShin + side] = About(x, pose.knee[side]);
    turn[kFoot + side] = About(x, -pose.ankle[side]);
    turn[kUpperArm + side] = (About(x, -pose.arm[side]) * About(y, away * pose.arm_lift[side]));
    turn[kForearm + side] = About(x, -pose.elbow[side]);
  }
  return turn;
}

const std::array<BoneShape, kNumBones>& Skeleton() {
  static const std::array<BoneShape, kNumBones> bones = [] {
    std::array<BoneShape, kNumBones> made;
    AddTrunk(made);
    for (int side = 0; side < 2; ++side) {
      AddArm(side, made);
      AddLeg(side, made);
    }
    return made;
  }();
  return bones;
}

// The motion of each bone from the rest pose into a pose.
std::array<Eigen::Isometry3d, kNumBones> BoneMotions(const Pose& pose) {
  const auto& bones = Skeleton();
  const auto turn = JointRotations(pose);
  std::array<Eigen::Isometry3d, kNumBones> motion;
  for (int b = 0; b < kNumBones; ++b) {  // parents come first
    const int parent = bones[b].parent;
    motion[b] = parent < 0 ? Eigen::Isometry3d(Eigen::Translation3d(pose.shift)) : motion[parent];
    motion[b] = motion[b] * Eigen::Translation3d(bones[b].joint) * turn[b] *
                Eigen::Translation3d(-bones[b].joint);
  }
  return motion;
}

// Signed distance [m] of a point from flesh in the rest pose, negative inside. The distance from an
// ellipsoid is first-order: only its zero is exact.
double FleshDistance(const Flesh& flesh, const Vector3d& point) {
  return flesh.half_axes.isZero() ? ConeDistance(flesh, point) : EllipsoidDistance(flesh, point);
}

// The nearest point of a bone's axis.
Vector3d NearestOnAxis(const BoneShape& bone, const Vector3d& point) {
  const Vector3d axis = bone.end - bone.begin;
  const double share = (point - bone.begin).dot(axis) / axis.squaredNorm();
  return bone.begin + std::clamp(share, 0.0, 1.0) * axis;
}

constexpr double kRampSeconds = .5;
constexpr double kLeastRadiusScale = .5;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn = 2 * std::numbers::pi;

// Each motion at the time t since it set in, with its amplitude a.
Pose Stand(double t, double a) {
  Pose pose;
  pose.shift.x() = a * .008 * std::sin(kTurn * .25 * t);
  pose.chest_bend = a * 1.5 * kDegree * std::sin(kTurn * .25 * t);
  pose.head_turn = a * 10 * kDegree * std::sin(kTurn * .1 * t);
  return pose;
}

Pose Walk(double t, double a) {
  const double phase = kTurn * t;  // one stride, two steps, a second
  Pose pose;
  pose.shift = a * Vector3d(.02 * std::sin(phase), 0, .02 * std::cos(2 * phase));
  pose.yaw = -a * 4 * kDegree * std::sin(phase);
  pose.roll = a * 3 * kDegree * std::sin(phase);
  pose.belly_twist = a * 4 * kDegree * std::sin(phase);
  pose.chest_twist = a * 5 * kDegree * std::sin(phase);
  for (int side = 0; side < 2; ++side) {
    const double leg = phase + side * std::numbers::pi;
    pose.hip[side] = a * 25 * kDegree * std::sin(leg);
    const double swing = leg + .2;  // the knee is bent most as the thigh passes the vertical
    pose.knee[side] = a * (21 + 26 * std::cos(swing) + 13 * std::cos(2 * swing)) * kDegree;
    pose.ankle[side] = a * 10 * kDegree * std::sin(leg);
    pose.arm[side] = -a * 20 * kDegree * std::sin(leg);
    pose.elbow[side] = a * (20 - 10 * std::sin(leg)) * kDegree;
  }
  return pose;
}

Pose Turn(double t, double a) {
  const double phase = kTurn * .5 * t;
  Pose pose;
  pose.yaw = a * 90 * kDegree * std::sin(phase);
  pose.belly_twist = a * 8 * kDegree * std::cos(phase);
  pose.chest_twist = a * 10 * kDegree * std::cos(phase);
  pose.head_turn = a * 15 * kDegree * std::cos(phase);
  for (int side = 0; side < 2; ++side) pose.arm_lift[side] = a * 12 * kDegree;
  return pose;
}

Pose Jump(double t, double a) {
  const double phase = kTurn * 1.25 * t;
  const double crouch = a * .5 * (1 + std::cos(phase));
  Pose pose;
  pose.shift.z() = a * (.03 - .09 * std::cos(phase));
  pose.chest_bend = 6 * kDegree * crouch;
  for (int side = 0; side < 2; ++side) {
    pose.hip[side] = 22 * kDegree * crouch;
    pose.knee[side] = 45 * kDegree * crouch;
    pose.ankle[side] = 23 * kDegree * crouch;
    pose.arm[side] = -15 * kDegree * crouch;
    pose.arm_lift[side] = a * 15 * kDegree * (1 - std::cos(phase)) * .5;
    pose.elbow[side] = 20 * kDegree * crouch;
  }
  return pose;
}

constexpr double kSkinWidth = .030;  // over which the weights of the bones blend [m]
constexpr double kLeastWeight = 1e-4;

double NearestFlesh(const BoneShape& bone, const Vector3d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Flesh& flesh : bone.flesh) nearest = std::min(nearest, FleshDistance(flesh, point));
  return nearest;
}

const ObjContent& RestMesh() {
  static const ObjContent mesh = ParseObj(kMannequinObj, "mannequin.obj", false);
  return mesh;
}

std::vector<std::array<int, 3>> RestTriangles() {
  std::vector<std::array<int, 3>> triangles;
  for (const ObjFace& face : RestMesh().faces)
    triangles.push_back({face.corner[0].v, face.corner[1].v, face.corner[2].v});
  return triangles;
}

}  // namespace

// How far the arms are lifted out of the way of a garment without sleeves [rad].
constexpr double kClear = 55 * kDegree;

Mannequin::Mannequin(MotionKind kind, double arm_angle, bool grows_as_files)
    : Body(RestTriangles(), static_cast<int>(RestMesh().v.size())),
      kind_(kind),
      lift_(arm_angle == 0 ? (grows_as_files ? kClear : 0) : arm_angle - kRestArmAngle) {
  if (!(lift_ >= -1e-9 && arm_angle <= std::numbers::pi / 2 + 1e-9))
    throw InputError("arms", Format("%g° off the body, expected 25° … 90°", arm_angle / kDegree));
  start_ = kGrowSeconds + (lift_ > 1e-9 ? kLowerSeconds : 0);
  rest_x_.resize(3 * num_vertices());
  for (int i = 0; i < num_vertices(); ++i) {
    rest_x_.segment<3>(3 * i) = RestMesh().v[i];
    skin_.push_back(MakeSkin(RestMesh().v[i]));
  }
  if (!grows_as_files) return;
  const Eigen::VectorXd x = PositionsInPose(PoseAt(0), 1);
  shrunk_ = Shrunk(x, Contract({x, triangles()}, kLimb));
  weightless_until_ = kGrowSeconds;
}

Pose Mannequin::PoseAt(double t) const {
  constexpr Pose (*kPoses[])(double, double) = {Stand, Walk, Turn, Jump};
  Pose pose = kPoses[static_cast<int>(kind_)](t - start_, SmoothStep((t - start_) / kRampSeconds));
  const double lowered = SmoothStep((t - kGrowSeconds) / kLowerSeconds);
  for (double& lift : pose.arm_lift) lift += (1 - lowered) * lift_;
  return pose;
}

Mannequin::Skin Mannequin::MakeSkin(const Vector3d& vertex) {
  std::array<double, kNumBones> distance;
  for (int b = 0; b < kNumBones; ++b) distance[b] = NearestFlesh(Skeleton()[b], vertex);
  const double least = *std::min_element(distance.begin(), distance.end());
  Skin skin{Vector3d::Zero(), {}};
  double sum = 0;
  for (int b = 0; b < kNumBones; ++b) {
    const double apart = (distance[b] - least) / kSkinWidth;
    const double weight = std::exp(-apart * apart);
    if (weight < kLeastWeight) continue;
    skin.weights.emplace_back(b, weight);
    sum += weight;
  }
  for (auto& [bone, weight] : skin.weights) {
    weight /= sum;
    skin.axis += weight * NearestOnAxis(Skeleton()[bone], vertex);
  }
  return skin;
}

Eigen::VectorXd Mannequin::PositionsInPose(const Pose& pose, double radius_scale) const {
  const auto motions = BoneMotions(pose);
  Eigen::VectorXd x(rest_x_.size());
  for (int i = 0; i < num_vertices(); ++i) {
    const Skin& skin = skin_[i];
    const Vector3d rest = skin.axis + radius_scale * (rest_x_.segment<3>(3 * i) - skin.axis);
    Vector3d moved = Vector3d::Zero();
    for (const auto& [bone, weight] : skin.weights) moved += weight * (motions[bone] * rest);
    x.segment<3>(3 * i) = moved;
  }
  return x;
}

Eigen::VectorXd Mannequin::Positions(double t) const {
  const double grown = SmoothStep(t / kGrowSeconds);
  if (shrunk_.size() > 0) return PositionsInPose(PoseAt(t), 1) + (1 - grown) * shrunk_;
  return PositionsInPose(PoseAt(t), kLeastRadiusScale + (1 - kLeastRadiusScale) * grown);
}

Eigen::Isometry3d Mannequin::PelvisMotion(double t) const {
  return BoneMotions(PoseAt(t))[kPelvis] * BoneMotions(PoseAt(0))[kPelvis].inverse();
}

}  // namespace drape
