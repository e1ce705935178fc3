// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/check.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"

namespace drape {
namespace {

constexpr double kRounding = 1e-10;    // of sums that are zero up to rounding
constexpr double kRigid = 1e-8;        // strains are differences of numbers near 1
constexpr double kDifferences = 1e-6;  // best of a sweep of central differences

using Vector = Eigen::VectorXd;

double RelativeError(const Vector& found, const Vector& expected) {
  return (found - expected).norm() / std::max(found.norm(), expected.norm());
}

Vector Scalar(double value) { return Vector::Constant(1, value); }

double MeanEdge(const Mesh& mesh) {
  double sum = 0.0;
  for (const Hinge& hinge : mesh.hinges) sum += hinge.rest_length;
  return sum / mesh.num_hinges();
}

bool HasEqualRows(const StretchTable& table) {
  for (const auto& row : table.c)
    if (!std::equal(std::begin(row), std::end(row), std::begin(table.c[0]))) return false;
  return true;
}

// The error of central differences of second and of fourth order, whichever is less. The fourth
// allows a longer step, which drowns less in rounding: a cloth that swings freely turns so much
// that none of the second order is good to kDifferences. The second crosses fewer kinks.
double DifferenceError(double step, const Vector& derivative,
                       const std::function<Vector(double)>& at) {
  const Vector near = (at(step) - at(-step)) / (2.0 * step);
  const Vector far = (at(2.0 * step) - at(-2.0 * step)) / (4.0 * step);
  return std::min(RelativeError(near, derivative),
                  RelativeError((4.0 * near - far) / 3.0, derivative));
}

class SceneChecks {
 public:
  SceneChecks(std::shared_ptr<const ClothModel> model, const MaterialField& material,
              const State& start, const CheckOptions& options, const RunControl& control)
      : model_(std::move(model)),
        material_(material),
        start_(start),
        options_(options),
        control_(control),
        random_(options.seed),
        solver_(model_),
        edge_(MeanEdge(model_->mesh)),
        rollout_{.h = options.h, .steps = options.steps} {
    start_.x += options.noise * edge_ * Direction(start_.x.size());
  }

  std::vector<CheckRow> Run() {
    const RolloutResult result = Rollout(solver_, material_, start_, rollout_);
    const bool ran = result.status == RolloutStatus::kOk;
    Add("rollout", std::string("the rollout runs: ") + ToString(result.status), !ran, 0.0);
    if (!ran) return std::move(rows_);
    x_ = result.end.x;
    for (const auto group : {&SceneChecks::CheckForces, &SceneChecks::CheckEnergy,
                             &SceneChecks::CheckStiffness, &SceneChecks::CheckRollout})
      if (!control_.cancelled()) (this->*group)();
    return std::move(rows_);
  }

 private:
  // Normal numbers, the largest 1 in size.
  Vector Direction(Eigen::Index size) {
    Vector direction(size);
    for (double& value : direction) value = SampleNormal(random_);
    return direction / direction.cwiseAbs().maxCoeff();
  }

  void Add(const std::string& group, const std::string& name, double value,
           double bound = CheckRow::kNoBound) {
    rows_.push_back({group, name, value, bound});
  }

  // at(s): the function at s along a direction; derivative: ∂at/∂s at s = 0. unit: of the steps.
  void AddSweep(const std::string& group, const std::string& name, double unit,
                const Vector& derivative, double bound, const std::function<Vector(double)>& at) {
    if (control_.cancelled()) return;
    double best = std::numeric_limits<double>::infinity();
    for (int exponent = 3; exponent <= 8; ++exponent) {
      const double step = unit * std::pow(10.0, -exponent);
      const double error = DifferenceError(step, derivative, at);
      Add(group, name + ", step 1e-" + std::to_string(exponent), error);
      best = std::min(best, error);
    }
    Add(group, name + ", best step", best, bound);
    constexpr double kSweeps = 5;
    control_.Report(++sweeps_done_ / kSweeps, group);
  }

  Vector Force(const ClothModel& model, const Vector& x) const {
    Vector force;
    AssembleForce(model, material_, x, force);
    return force;
  }

  void CheckForces() {
    Scene internal = model_->scene;
    internal.gravity.reset();
    internal.handles.reset();
    internal.load.reset();
    if (internal.contact) internal.contact->obstacles.clear();
    const ClothModel cloth(model_->mesh, internal, model_->law);
    const Vector force = Force(cloth, x_);
    const Eigen::Map<const Eigen::Matrix3Xd> f(force.data(), 3, force.size() / 3);
    const Eigen::Map<const Eigen::Matrix3Xd> x(x_.data(), 3, f.cols());
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (int i = 0; i < f.cols(); ++i) torque += x.col(i).cross(f.col(i));
    const double size = f.colwise().norm().sum();
    const double lever = x.colwise().norm().dot(f.colwise().norm());
    Add("forces", "internal forces sum to zero", f.rowwise().sum().norm() / size, kRounding);
    Add("forces", "internal torques sum to zero", torque.norm() / lever, kRounding);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()) * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3Xd moved = (turn * x).colwise() + Eigen::Vector3d(0.1, -0.2, 0.3);
    const Eigen::Matrix3Xd turned = turn * f;
    Add("forces", "a rigid motion turns the forces",
        RelativeError(Force(cloth, moved.reshaped()), turned.reshaped()), kRigid);
    Add("forces", "the flat rest carries no load",
        Force(cloth, cloth.mesh.rest_x).norm() / force.norm(), kRounding);
  }

  void AddEnergySweep(const std::string& name, const ClothModel& cloth, double bound) {
    const Vector direction = Direction(x_.size());
    AddSweep("energy", name, edge_, Scalar(-Force(cloth, x_).dot(direction)), bound,
             [&](double s) { return Scalar(Energy(cloth, material_, x_ + s * direction)); });
  }

  void CheckEnergy() {
    Scene bend = model_->scene;
    bend.stretch = false;
    AddEnergySweep("bend, gravity, handles: force = -gradient",
                   ClothModel(model_->mesh, bend, model_->law), kDifferences);
    if (!model_->scene.stretch) return;
    const bool has_energy =
        std::all_of(material_.stretch.begin(), material_.stretch.end(), HasEqualRows);
    AddEnergySweep(has_energy ? "all with stretch: force = -gradient"
                              : "all with stretch (a table is no gradient)",
                   *model_, has_energy ? kDifferences : CheckRow::kNoBound);
    Add("energy", "largest rise of the total energy in a step", LargestRise());
  }

  // The largest rise of kinetic plus potential energy in a step, relative to its range.
  double LargestRise() {
    const Vector mass = model_->LumpedMass(material_.density);
    RolloutOptions one = rollout_;
    one.steps = 1;
    State state = start_;
    const auto total = [&] {
      return Energy(*model_, material_, state.x) + 0.5 * state.v.dot(mass.cwiseProduct(state.v));
    };
    double last = total(), least = last, most = last, rise = 0.0;
    for (int step = 0; step < options_.steps; ++step) {
      state = Rollout(solver_, material_, state, one).end;
      const double now = total();
      rise = std::max(rise, now - last);
      least = std::min(least, now);
      most = std::max(most, now);
      last = now;
    }
    return rise / (most - least);
  }

  void CheckStiffness() {
    const Vector direction = Direction(x_.size());
    const Vector none = Vector::Zero(x_.size());
    const BlockMatrix& negative = solver_.StepDerivative(material_, x_, none, 1.0);
    RowMatrix times = RowMatrix::Zero(x_.size(), 1), transposed = times;
    AddMultiply(solver_.wide_model().pattern, negative, direction, times);
    AddTransposeMultiply(solver_.wide_model().pattern, negative, direction, transposed);
    AddSweep("stiffness", "K against differences of the force", edge_, times.col(0), kDifferences,
             [&](double s) { return Force(*model_, x_ + s * direction); });
    Add("stiffness", "unsymmetric part of K along a direction",
        0.5 * (times - transposed).norm() / times.norm());
  }

  Vector End(const MaterialField& material, const State& start) {
    return Rollout(solver_, material, start, rollout_).end.x;
  }

  // The material with each entry changed by the share s·direction.
  MaterialField Moved(const Vector& direction, double s) const {
    MaterialField moved = material_;
    double *stretch = &moved.stretch[0].c[0][0], *bend = &moved.bend[0].b[0][0];
    for (int k = 0; k < kStretchEntries; ++k) stretch[k] *= 1.0 + s * direction[k];
    for (int k = 0; k < kBendEntries; ++k) bend[k] *= 1.0 + s * direction[kStretchEntries + k];
    return moved;
  }

  void CheckRollout() {
    Recording recording;
    const RolloutStatus status = Rollout(solver_, material_, start_, rollout_, &recording).status;
    if (status != RolloutStatus::kOk) {
      Add("rollout", std::string("no derivatives: ") + ToString(status), 1.0);
      return;
    }
    const TangentResult tangent = RolloutTangent(solver_, material_, material_, start_, rollout_);
    const Vector seed = Direction(x_.size());
    const AdjointResult adjoint = RolloutAdjoint(solver_, material_, rollout_, recording, seed);
    const Vector by_tangent = tangent.dx.transpose() * seed;
    Add("rollout", "tangent = adjoint",
        RelativeError(adjoint.material.Contract(material_).col(0), by_tangent), kRounding);
    const Vector entries = Direction(kMaterialEntries);
    AddSweep("rollout", "tangent by the material", 1.0, tangent.dx * entries, kDifferences,
             [&](double s) { return End(Moved(entries, s), start_); });
    const Vector move = Direction(x_.size());
    AddSweep("rollout", "adjoint by the start", edge_, Scalar(move.dot(adjoint.x0.col(0))),
             kDifferences, [&](double s) {
               return Scalar(seed.dot(End(material_, {start_.x + s * move, start_.v})));
             });
  }

  std::shared_ptr<const ClothModel> model_;
  const MaterialField& material_;
  State start_;
  const CheckOptions& options_;
  const RunControl& control_;
  std::mt19937_64 random_;
  StepSolver solver_;
  double edge_;  // mean rest length of the inner edges [m]
  RolloutOptions rollout_;
  Vector x_;  // end of the rollout: where forces are checked
  std::vector<CheckRow> rows_;
  int sweeps_done_ = 0;
};

}  // namespace

std::vector<CheckRow> CheckScene(std::shared_ptr<const ClothModel> model,
                                 const MaterialField& material, const State& start,
                                 const CheckOptions& options, const RunControl& control) {
  CHECK_GE(options.steps, 1);
  CHECK_EQ(material.stretch.size(), 1u);
  CHECK_EQ(material.bend.size(), 1u);
  return SceneChecks(std::move(model), material, start, options, control).Run();
}

bool AllPass(const std::vector<CheckRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const CheckRow& row) { return row.ok(); });
}

namespace {

// The options of drape_check.
struct CheckToolOptions {
  SceneInput scene;
  CheckOptions check;
};

OptionTable CheckTable(CheckToolOptions& options) {
  const std::vector<Option> checks = {
      TimeStepOption(&options.check.h, "time step of the rollouts"),
      NumberOption("steps", &options.check.steps, 1, 1000, "number of time steps of the rollouts"),
      NumberOption("seed", &options.check.seed, 0, kUnlimited,
                   "random seed of the run: of the directions and the noise"),
      NumberOption("noise", &options.check.noise, 0, 1,
                   "random offset of the start, which breaks its symmetry", "mean edge lengths"),
  };
  return {.tool = "drape_check",
          .summary = "checks the forces, energies and derivatives of a scene and prints a table",
          .example = "drape_check --config=configs/programs/check.json --law=reference",
          .notes = "exit code 1: a check failed\n",
          .options = Concatenate(FieldOptionList(options.scene), checks)};
}

// One row per check: group, name, value, bound and ok or FAIL; then how many failed.
std::string CheckTableText(const std::vector<CheckRow>& rows) {
  std::string text =
      Format("%-10s %-58s %9s %9s\n", "group", "check (relative errors)", "value", "bound");
  for (const CheckRow& row : rows) {
    text += Format("%-10s %-58s %9.1e ", row.group.c_str(), row.name.c_str(), row.value);
    text += row.has_bound() ? Format("%9.0e  %s\n", row.bound, row.ok() ? "ok" : "FAIL")
                            : Format("%9s\n", "-");
  }
  const auto bounded =
      std::count_if(rows.begin(), rows.end(), [](auto& row) { return row.has_bound(); });
  const auto failed = std::count_if(rows.begin(), rows.end(), [](auto& row) { return !row.ok(); });
  return text + Format("%td of %td checks failed\n", failed, bounded);
}

ToolOutcome RunCheck(const CheckToolOptions& options, const RunControl& control) {
  const LoadedScene scene = LoadScene(options.scene);
  RequireOneTable(scene.fabric.material, "fabric");
  const std::vector<CheckRow> rows =
      CheckScene(scene.model, scene.fabric.material.field, scene.start, options.check, control);
  return {.text = CheckTableText(rows),
          .cancelled = control.cancelled(),
          .exit_code = AllPass(rows) ? kExitOk : kExitCheckFailed};
}

}  // namespace

int CheckMain(int argc, char** argv) { return ToolMain(argc, argv, CheckTable, RunCheck); }

}  // namespace drape
