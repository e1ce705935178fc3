// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/wear.h"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/material/laws/stretch_element.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Columns = DeformationGradient<double>;

double LargestStretch(const ClothModel& model, const Eigen::VectorXd& x) {
  double largest = 0.0;
  for (const Face& face : model.mesh.faces) {
    const GreenStrain<double> G = Green(GatherColumns(face, x.data()));
    const double middle = 0.5 * (G.uu + G.vv), off = std::hypot(0.5 * (G.uu - G.vv), G.uv);
    largest = std::max(largest, std::sqrt(1.0 + 2.0 * (middle + off)) - 1.0);
  }
  return largest;
}

// Pairs of faces that meet, and the faces of the cloth that meet the body.
struct Intersections {
  int with_body = 0, of_cloth = 0;
  std::set<int> pierced = {};
};
Intersections FindIntersections(const std::vector<std::array<int, 3>>& cloth,
                                const Eigen::VectorXd& x, const Body& body,
                                const Eigen::VectorXd& body_x) {
  const int vertices = static_cast<int>(x.size() / 3), faces = static_cast<int>(cloth.size());
  std::vector<std::array<int, 3>> all = cloth;
  for (std::array<int, 3> triangle : body.triangles()) {
    for (int& i : triangle) i += vertices;
    all.push_back(triangle);
  }
  Eigen::VectorXd both(x.size() + body_x.size());
  both << x, body_x;
  Intersections found;
  for (const auto& [one, other] :
       FindSelfIntersections(all, both, std::numeric_limits<int>::max())) {
    if (one >= faces) continue;
    ++(other < faces ? found.of_cloth : found.with_body);
    if (other >= faces) found.pierced.insert(one);
  }
  return found;
}

// The contact with the body as it moves from one time to another.
Contact BodyContact(const Body& body, const WearOptions& options, double before, double now) {
  const auto places = [&](double t) -> Eigen::Matrix3Xd {
    const Eigen::VectorXd x = body.Positions(t);
    return x.reshaped(3, x.size() / 3);
  };
  return {.thickness = options.thickness,
          .skin = options.skin_offset,
          .obstacles = {std::make_shared<const SurfaceObstacle>(places(now), body.triangles(),
                                                                places(before))}};
}

// The further distance from the body that single vertices keep before the first step [m].
using FurtherSkin = std::map<int, double>;

void PushOutFurther(Contact contact, const FurtherSkin& further, Eigen::VectorXd& x) {
  PushOut(contact, x);
  const double skin = contact.skin;
  for (const auto& [i, more] : further) {
    contact.skin = skin + more;
    Eigen::VectorXd place = x.segment<3>(3 * i);
    PushOut(contact, place);
    x.segment<3>(3 * i) = place;
  }
}

// Draws seams together whose panels begin apart: each edge in turn is brought towards its rest
// length, as in position-based dynamics [Müller 2007], while held vertices stay and the body is
// kept out. What stretch is left the first steps take.
// Around limbs that are drawn together to their axes no edge moves cloth by more than `most` [m] in
// a sweep, which would carry it across them.
void DrawTogether(const SewnGarment& garment, const Contact& contact, const FurtherSkin& further,
                  int sweeps, double most, Eigen::VectorXd& x) {
  const int sweeps_to_push = most < HUGE_VAL ? 1 : 5;
  constexpr double kShare = 0.5;  // of what an edge is too long or too short
  std::vector<bool> held(x.size() / 3, false);
  for (const int i : garment.held_by_pelvis) held[i] = true;
  const std::vector<RestEdge> edges = ListEdges(garment.model->mesh);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (const RestEdge& edge : edges) {
      const auto& [a, b] = edge.vertex;
      if (held[a] && held[b]) continue;
      const Eigen::Vector3d side = x.segment<3>(3 * b) - x.segment<3>(3 * a);
      const double now = side.norm();
      if (!(now > 0.0)) continue;
      const double longer = std::clamp(kShare * (now - edge.rest_length), -most, most);
      const Eigen::Vector3d change = longer / now * side;
      const double of_a = held[a] ? 0.0 : held[b] ? 1.0 : 0.5;
      x.segment<3>(3 * a) += of_a * change;
      x.segment<3>(3 * b) -= (1.0 - of_a) * change;
    }
    if (sweep % sweeps_to_push == 0) PushOutFurther(contact, further, x);
  }
  PushOutFurther(contact, further, x);
}

double MostMove(const Body& body) { return body.weightless_until() > 0.0 ? 0.004 : HUGE_VAL; }

// The vertices of faces of the cloth that meet the body or are not further off than half of the
// thickness.
std::set<int> FindTooNear(const Mesh& mesh, const Contact& contact, const Body& body,
                          const Eigen::VectorXd& x) {
  std::set<int> near;
  const std::vector<std::array<int, 3>> cloth = ListTriangles(mesh);
  for (const int face : FindIntersections(cloth, x, body, body.Positions(0.0)).pierced)
    near.insert(cloth[face].begin(), cloth[face].end());
  SurfaceContact surfaces(mesh, Eigen::VectorXd::Ones(mesh.num_vertices()), std::nullopt);
  surfaces.SetObstacles(contact);
  for (const ActivePair& active : surfaces.FindActivePairs(x))
    if (active.distance.value <= 0.5 * contact.thickness)
      for (const int i : active.pair.vertex)
        if (i < mesh.num_vertices()) near.insert(i);
  return near;
}

// Moves vertices further away from the body, until the faces between them are outside as well.
void ClearBody(const SewnGarment& garment, const Contact& contact, const Body& body,
               Eigen::VectorXd& x) {
  constexpr int kMostRounds = 30, kSweeps = 50;
  constexpr double kMore = 1e-3;  // [m]
  FurtherSkin further;
  for (int round = 0; round < kMostRounds; ++round) {
    const std::set<int> near = FindTooNear(garment.model->mesh, contact, body, x);
    if (near.empty()) return;
    for (const int i : near) further[i] += kMore;
    DrawTogether(garment, contact, further, kSweeps, MostMove(body), x);
  }
}

// Smooths the cloth where it passes through itself, and in each round further around: each vertex
// goes to the middle of its neighbours.
void Untangle(const SewnGarment& garment, const Contact& contact, Eigen::VectorXd& x) {
  constexpr int kMostRounds = 40, kMost = 1000;
  const std::vector<std::array<int, 3>> triangles = ListTriangles(garment.model->mesh);
  std::vector<std::set<int>> near(x.size() / 3);
  for (const std::array<int, 3>& t : triangles)
    for (const int i : t) near[i].insert(t.begin(), t.end());
  std::set<int> tangled;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto found = FindSelfIntersections(triangles, x, kMost);
    if (found.empty()) return;
    for (const int i : std::set<int>(tangled)) tangled.insert(near[i].begin(), near[i].end());
    for (const auto& [one, other] : found)
      for (const int face : {one, other})
        tangled.insert(triangles[face].begin(), triangles[face].end());
    for (const int i : garment.held_by_pelvis) tangled.erase(i);
    for (const int i : tangled) {
      Eigen::VectorXd middle = Eigen::Vector3d::Zero();
      for (const int k : near[i])
        middle += x.segment<3>(3 * k) / static_cast<double>(near[i].size());
      PushOut(contact, middle);
      x.segment<3>(3 * i) = middle;
    }
  }
}

const char* ToText(IntegratorStatus status) {
  switch (status) {
    case IntegratorStatus::kNotPositiveDefinite:
      return "has no positive definite matrix";
    case IntegratorStatus::kNotFinite:
      return "overflows";
    case IntegratorStatus::kPinched:
      return "is pinched: the body moves into cloth that other cloth keeps in its place";
    default:
      return "does not converge";
  }
}

class Wearing {
 public:
  Wearing(const SewnGarment& garment, const MaterialField& material, const Body& body,
          const WearOptions& options, const std::atomic<bool>* cancel)
      : garment_(garment),
        material_(material),
        body_(body),
        options_(options),
        triangles_(ListTriangles(garment.model->mesh)) {
    options_.euler.friction = options_.friction;
    options_.euler.cancel = cancel;
    if (options_.self_contact) {
      options_.euler.self_contact = Contact{.thickness = options_.thickness};
      options_.euler.self_friction = options_.self_friction;
    }
    if (body.weightless_until() > 0.0) {
      auto weightless = std::make_shared<ClothModel>(*garment.model);
      weightless->scene.gravity.reset();
      weightless_ = std::move(weightless);
    }
    if (options_.euler.linear_solver == nullptr)
      options_.euler.linear_solver = MakeLinearSolver(garment.model->pattern);
  }

  // From the frame before `index` to it. Returns why not, or nothing. Cancelled, it may be at a
  // step between.
  std::string NextFrame(int index, State& state, int* newton_steps) {
    euler_.reset();  // its pattern depends on earlier contact: a run that is resumed has the same
                     // bits
    const double from = (index - 1) * options_.steps_per_frame * options_.h;
    model_ = from < body_.weightless_until() ? weightless_ : garment_.model;
    for (int step = 0; step < options_.steps_per_frame; ++step) {
      const int number = (index - 1) * options_.steps_per_frame + step;
      const double begin = number * options_.h;
      if (Step(begin, options_.h, state, newton_steps)) continue;
      const Eigen::Vector3d place = 100.0 * failure().place;
      return Format("step %d, at %.3f s, %s, even in %d parts, near (%.1f, %.1f, %.1f) cm",
                    number + 1, begin, ToText(status_), kMostParts, place.x(), place.y(),
                    place.z());
    }
    return "";
  }
  // The failure of the last step that was tried.
  const ImplicitEulerFailure& failure() const { return euler_->failure(); }

  WornFrame Frame(int index, double time, const State& state) const {
    const Contact contact = BodyContact(body_, options_, time, time);
    WornFrame frame{.index = index, .time = time, .cloth = state};
    frame.body = body_.Positions(time);
    frame.smallest_gap = SmallestGap(contact, state.x);
    frame.largest_stretch = LargestStretch(*garment_.model, state.x);
    const Intersections found = FindIntersections(triangles_, state.x, body_, frame.body);
    frame.body_intersections = found.with_body;
    frame.self_intersections = found.of_cloth;
    return frame;
  }

 private:
  static constexpr int kMostParts = 64;

  std::vector<Pin> Pins(double time) const {
    std::vector<Pin> pins;
    const Eigen::Isometry3d motion = body_.PelvisMotion(time);
    for (const int i : garment_.held_by_pelvis)
      pins.push_back({.vertex = i,
                      .stiffness = options_.pin_stiffness,
                      .place = motion * garment_.start_x.segment<3>(3 * i)});
    return pins;
  }

  // One step of h, or where it fails several shorter ones.
  bool Step(double begin, double h, State& state, int* newton_steps) {
    for (int parts = 1; parts <= kMostParts; parts *= 2) {
      State tried = state;
      if (Steps(begin, h / parts, parts, tried, newton_steps)) {
        state = std::move(tried);
        return true;
      }
      if (status_ == IntegratorStatus::kCancelled) return false;
    }
    return false;
  }

  bool Steps(double begin, double h, int count, State& state, int* newton_steps) {
    if (euler_ == nullptr || h != euler_h_)
      euler_ = std::make_unique<ImplicitEuler>(model_, material_, h, options_.euler);
    euler_h_ = h;
    for (int k = 0; k < count; ++k) {
      const double before = begin + k * h, now = before + h;
      const Contact contact = BodyContact(body_, options_, before, now);
      status_ = euler_->Advance(state, {.contact = &contact, .pins = Pins(now)});
      *newton_steps += euler_->cost().newton_steps;
      if (status_ != IntegratorStatus::kOk) return false;
    }
    return true;
  }

  const SewnGarment& garment_;
  const MaterialField& material_;
  const Body& body_;
  WearOptions options_;
  std::vector<std::array<int, 3>> triangles_;
  std::shared_ptr<const ClothModel> weightless_, model_;  // while it is dressed; of this frame
  std::unique_ptr<ImplicitEuler> euler_;
  double euler_h_ = 0.0;
  IntegratorStatus status_ = IntegratorStatus::kOk;
};

constexpr int kSweeps = 1000;

}  // namespace

Eigen::VectorXd DrawSeams(const SewnGarment& garment) {
  Eigen::VectorXd x = garment.start_x;
  DrawTogether(garment, {}, {}, kSweeps, HUGE_VAL, x);
  return x;
}

State StartToWear(const SewnGarment& garment, const Body& body, const WearOptions& options,
                  uint64_t seed) {
  const Contact contact = BodyContact(body, options, 0.0, 0.0);
  State state{garment.start_x, Eigen::VectorXd::Zero(garment.start_x.size())};
  DrawTogether(garment, contact, {}, kSweeps, MostMove(body), state.x);
  if (options.start_noise > 0.0) {
    std::mt19937_64 random(seed);
    for (double& part : state.x) part += options.start_noise * SampleNormal(random);
    PushOut(contact, state.x);
  }
  ClearBody(garment, contact, body, state.x);
  if (options.self_contact) Untangle(garment, contact, state.x);
  return state;
}

std::optional<std::pair<int, int>> FindStartIntersection(const SewnGarment& garment,
                                                         const State& state) {
  const auto pairs = FindSelfIntersections(ListTriangles(garment.model->mesh), state.x);
  return pairs.empty() ? std::nullopt : std::optional(pairs.front());
}

std::optional<int> FindStartPiercing(const SewnGarment& garment, const Body& body,
                                     const WearOptions& options, const State& state) {
  const std::set<int> near =
      FindTooNear(garment.model->mesh, BodyContact(body, options, 0.0, 0.0), body, state.x);
  return near.empty() ? std::nullopt : std::optional(*near.begin());
}

WearResult Wear(const SewnGarment& garment, const MaterialField& material, const Body& body,
                const WearOptions& options, State state, int first, const RunControl& control,
                const std::function<void(const WornFrame&)>& on_frame) {
  Wearing wearing(garment, material, body, options, control.cancel);
  WearResult result;
  const double frame_time = options.h * options.steps_per_frame;
  if (first == 0) {
    on_frame(wearing.Frame(0, 0.0, state));
    ++result.frames;
  }
  for (int index = first + 1; index <= options.frames; ++index) {
    const auto begin = std::chrono::steady_clock::now();
    int newton_steps = 0;
    result.reason = wearing.NextFrame(index, state, &newton_steps);
    if (control.cancelled()) {
      result.reason.clear();
      result.status = WearStatus::kCancelled;
      return result;
    }
    if (!result.reason.empty()) {
      result.status = WearStatus::kFailed;
      result.worst_vertex = wearing.failure().vertex;
      return result;
    }
    WornFrame frame = wearing.Frame(index, index * frame_time, state);
    frame.newton_steps = newton_steps;
    frame.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    on_frame(frame);
    ++result.frames;
    control.Report(static_cast<double>(index) / options.frames,
                   Format("%.2f s", index * frame_time));
  }
  return result;
}

}  // namespace drape
