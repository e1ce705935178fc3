// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_case.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/element_blocks.h"
#include "physics/linalg/linear_solver.h"
#include "physics/simulation/rollout.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

const StabilityAxis& FindAxis(const std::string& name, const std::string& where) {
  std::string names;
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (name == axis.name) return axis;
    names += std::string(axis.name) + ", ";
  }
  throw InputError(where, "found '" + name + "', expected one of " + names + "law");
}

std::vector<std::string> SplitAt(const std::string& text, char by) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, by);) parts.push_back(part);
  return parts;
}

template <class T>
T ParseNumber(const std::string& text, T least, T most, const char* what,
              const std::string& where) {
  T value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && value >= least && value <= most) return value;
  std::string range;
  AppendNumber(range, least);
  AppendNumber(range += " … ", most);
  throw InputError(where, "found '" + text + "', expected a " + what + ", " + range);
}

// Four digits are enough of a value in a list that people read.
double Rounded(double value) { return std::stod(Format("%.4g", value)); }

std::vector<double> ParseValues(const std::string& text, const StabilityAxis& axis,
                                const std::string& where) {
  const auto parse = [&](const std::string& part) {
    return ParseNumber(part, axis.least, axis.most, "number", where);
  };
  std::vector<double> values;
  if (const std::vector<std::string> range = SplitAt(text, ':'); range.size() == 3) {
    const double from = parse(range[0]), to = parse(range[1]);
    const int count = ParseNumber(range[2], 2, 200, "count", where);
    if (!(from > 0.0 && to > from))
      throw InputError(where, "expected from:to:count with 0 < from < to");
    for (int i = 0; i < count; ++i)
      values.push_back(Rounded(from * std::pow(to / from, i / (count - 1.0))));
    return values;
  }
  for (const std::string& part : SplitAt(text, '/')) values.push_back(parse(part));
  if (values.empty()) throw InputError(where, "has no value");
  std::sort(values.begin(), values.end());
  if (std::adjacent_find(values.begin(), values.end()) != values.end())
    throw InputError(where, "holds a value twice");
  return values;
}

void ParseSetting(const std::string& text, const std::string& where, StabilityMap& map) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw InputError(where, "found '" + text + "', expected axis=values");
  const std::string name = text.substr(0, equals), value = text.substr(equals + 1);
  if (name == "law") {
    map.base.law = ParseName<LawKind>(value, where);
    map.name += "-" + value;
    return;
  }
  const StabilityAxis& axis = FindAxis(name, where);
  const std::vector<double> values = ParseValues(value, axis, where + ": " + name);
  if (values.size() == 1) {
    axis.Set(map.base, values[0]);
    map.name += "-" + name + value;
    return;
  }
  const int k = map.axis[0] == nullptr ? 0 : 1;
  if (map.axis[k] != nullptr) throw InputError(where, "found a third axis, '" + name + "'");
  map.axis[k] = &axis;
  map.values[k] = values;
}

// A linear solver of which a step uses no more than Factor and Solve of a vector.
class StudySolver : public LinearSolver {
 public:
  std::unique_ptr<LinearSolver> Clone() const override { LOG(FATAL) << "not cloned"; }
  std::unique_ptr<LinearSolver> Adapt(const BlockPattern&) const override {
    LOG(FATAL) << "no contact of the cloth with itself";
  }
  void Solve(RowMatrix&) override { LOG(FATAL) << "one right-hand side only"; }
  void SaveFactor(std::vector<double>&) const override { LOG(FATAL) << "no adjoint"; }
  void SolveSaved(const std::vector<double>&, RowMatrix&) override { LOG(FATAL) << "no adjoint"; }
  std::size_t factor_bytes() const override { return 0; }
};

// The whole of a symmetric matrix; rows of the pattern are its columns.
template <class T>
Eigen::SparseMatrix<T> ToSparse(const BlockPattern& p, const BlockMatrix& A) {
  const int n = 3 * p.num_vertices();
  Eigen::SparseMatrix<T> sparse(n, n);
  sparse.reserve(9 * p.num_blocks());
  for (int j = 0; j < n; ++j) {
    sparse.startVec(j);
    for (int b = p.row_start[j / 3]; b < p.row_start[j / 3 + 1]; ++b)
      for (int k = 0; k < 3; ++k)
        sparse.insertBack(3 * p.column[b] + k, j) = static_cast<T>(A.block(b)[3 * (j % 3) + k]);
  }
  sparse.finalize();
  return sparse;
}

class PcgSolver final : public StudySolver {
 public:
  PcgSolver(const BlockPattern& pattern, const PcgOptions& options) : pattern_(pattern) {
    pcg_.setTolerance(options.tolerance);
    pcg_.setMaxIterations(options.max_iterations);
  }
  bool Factor(const BlockMatrix& A) override {
    sparse_ = ToSparse<double>(pattern_, A);
    pcg_.compute(sparse_);
    return pcg_.preconditioner().info() == Eigen::Success;
  }
  void Solve(Eigen::VectorXd& b) override { b = pcg_.solve(b).eval(); }
  bool converged() const { return pcg_.info() == Eigen::Success; }

 private:
  const BlockPattern& pattern_;
  Eigen::SparseMatrix<double> sparse_;
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                           Eigen::IncompleteCholesky<double>>
      pcg_;
};

class FloatSolver final : public StudySolver {
 public:
  explicit FloatSolver(const BlockPattern& pattern) : pattern_(pattern) {}
  bool Factor(const BlockMatrix& A) override {
    const Eigen::SparseMatrix<float> sparse = ToSparse<float>(pattern_, A);
    if (!analysed_) llt_.analyzePattern(sparse);
    analysed_ = true;
    llt_.factorize(sparse);
    return llt_.info() == Eigen::Success;
  }
  void Solve(Eigen::VectorXd& b) override {
    const Eigen::VectorXf rhs = b.cast<float>();
    b = llt_.solve(rhs).eval().cast<double>();
  }

 private:
  const BlockPattern& pattern_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<float>> llt_;
  bool analysed_ = false;
};

// The step of production with this linear solver.
Integrator MakeOneSolveStep(const std::shared_ptr<const ClothModel>& model,
                            const MaterialField& material, double h,
                            std::unique_ptr<LinearSolver> linear) {
  CHECK_GT(h, 0.0);
  const auto solver = std::make_shared<StepSolver>(model, std::move(linear));
  const Eigen::VectorXd mass = model->LumpedMass(material.density);
  return [=](State& state) {
    switch (AdvanceOneStep(*solver, material, mass, h, state)) {
      case RolloutStatus::kNotPositiveDefinite:
        return solver->force().allFinite() ? IntegratorStatus::kNotPositiveDefinite
                                           : IntegratorStatus::kNotFinite;
      case RolloutStatus::kNotFinite:
        return IntegratorStatus::kNotFinite;
      default:
        return IntegratorStatus::kOk;
    }
  };
}

void RoundToFloat(State& state) {
  state.x = state.x.cast<float>().cast<double>().eval();
  state.v = state.v.cast<float>().cast<double>().eval();
}

// The positive semidefinite part of the symmetric part of −Q.
template <int N>
void Project(double (&Q)[N][N]) {
  using Matrix = Eigen::Matrix<double, N, N, Eigen::RowMajor>;
  Eigen::Map<Matrix> map(&Q[0][0]);
  if (!map.allFinite()) return;
  const Matrix symmetric = -0.5 * (map + map.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetric);
  const auto vectors = eigen.eigenvectors();
  map = vectors * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}

void AddFaces(const ClothModel& model, const MaterialField& material, const double* x,
              BlockMatrix& K) {
  const DeformationGradient<double> at_rest{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  std::visit(
      [&](const auto& law) {
        for (int f = 0; f < model.mesh.num_faces(); ++f) {
          const Face& face = model.mesh.faces[f];
          Matrix6 Q;
          StretchStepDerivative(law, GatherColumns(face, x), material.stretch_of(f), at_rest, 1.0,
                                Q);
          Project(Q);
          AddFaceBlocks(face, Q, face.area, &model.pattern.face_block[9 * f], K);
        }
      },
      model.law.stretch);
}

void AddHinges(const ClothModel& model, const MaterialField& material, const double* x,
               BlockMatrix& K) {
  const HingeCorners at_rest{};
  std::visit(
      [&](const auto& law) {
        for (int e = 0; e < model.mesh.num_hinges(); ++e) {
          const Hinge& hinge = model.mesh.hinges[e];
          double Q[12][12];
          BendStepDerivative(law, hinge, material.bend_of(e), GatherCorners(hinge, x), at_rest, 1.0,
                             Q);
          Project(Q);
          AddHingeBlocks(Q, &model.pattern.hinge_block[16 * e], K);
        }
      },
      model.law.bend);
}

}  // namespace

std::span<const StabilityAxis> StabilityAxes() {
  using Case = StabilityCase;
  static const std::vector<StabilityAxis> axes = {
      {"time_step", "time step h [s]", 1e-6, 10.0, {&Case::h}},
      {"stiffness",
       "stiffness, stretch and bend [factor]",
       1e-6,
       1e6,
       {&Case::stretch, &Case::bend}},
      {"stretch", "stretch stiffness [factor]", 1e-6, 1e6, {&Case::stretch}},
      {"bend", "bend stiffness [factor]", 1e-6, 1e6, {&Case::bend}},
      {"density", "density [kg/m²]", 1e-4, 10.0, {&Case::density}},
      {"sliver", "needles, long by short side", 1.0, 1e6, {&Case::sliver}},
      {"compression", "size of the start in the plane [factor]", 0.1, 2.0, {&Case::compression}},
      {"tangle", "random displacement of the start [edge lengths]", 0.0, 10.0, {&Case::tangle}},
      {"handle", "handle stiffness [factor]", 1e-6, 1e6, {&Case::handle}},
      {"pre_steps", "steps before Newton", 0.0, 10000.0, {&Case::pre_steps}},
  };
  return axes;
}

std::string CaseName(const StabilityCase& run) {
  const StabilityCase usual;
  std::string name = ToString(run.method);
  if (run.law != usual.law) name += std::string(" law=") + ToString(run.law);
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (axis.fields.size() > 1 || run.*axis.fields[0] == usual.*axis.fields[0]) continue;
    AppendNumber(name += std::string(" ") + axis.name + "=", run.*axis.fields[0]);
  }
  return name;
}

nlohmann::json CaseJson(const StabilityCase& run) {
  nlohmann::json json = {{"method", ToString(run.method)}, {"law", ToString(run.law)}};
  for (const StabilityAxis& axis : StabilityAxes())
    if (axis.fields.size() == 1) json[axis.name] = run.*axis.fields[0];
  return json;
}

StabilityCase StabilityMap::At(int i, int j) const {
  StabilityCase run = base;
  axis[0]->Set(run, values[0][i]);
  axis[1]->Set(run, values[1][j]);
  return run;
}

std::vector<StabilityCase> StabilityMap::Cases() const {
  std::vector<StabilityCase> cases;
  for (int j = 0; j < static_cast<int>(values[1].size()); ++j)
    for (int i = 0; i < static_cast<int>(values[0].size()); ++i) cases.push_back(At(i, j));
  return cases;
}

std::vector<StabilityMap> ParseStabilityMaps(const std::string& line, const std::string& where) {
  const std::string place = where + " '" + line + "'";
  std::istringstream words(line);
  std::string methods;
  words >> methods;
  StabilityMap map;
  for (std::string word; words >> word;) ParseSetting(word, place, map);
  if (map.axis[1] == nullptr)
    throw InputError(place, "expected two axes with more than one value each");
  if (map.axis[0] == map.axis[1])
    throw InputError(place, std::string("names '") + map.axis[0]->name + "' twice");
  std::vector<StabilityMap> maps;
  for (const std::string& method : SplitAt(methods, '+')) {
    maps.push_back(map);
    maps.back().base.method = ParseName<StabilityMethod>(method, place);
    maps.back().name = method + "-" + map.axis[0]->name + "-" + map.axis[1]->name + map.name;
  }
  return maps;
}

Integrator MakeExplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h, double drag) {
  CHECK_GT(h, 0.0);
  CHECK_GE(drag, 0.0);
  const double slowing = 1.0 / (1.0 + h * drag);
  const Eigen::VectorXd inverse_mass = model->LumpedMass(material.density).cwiseInverse();
  return [=, force = Eigen::VectorXd()](State& state) mutable {
    AssembleForce(*model, material, state.x, force);
    state.v = slowing * (state.v + h * inverse_mass.cwiseProduct(force));
    state.x += h * state.v;
    return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
  };
}

Integrator MakeLinearlyImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                                     const MaterialField& material, double h,
                                     StepLinearSolver solver, const PcgOptions& pcg) {
  const BlockPattern& pattern = model->pattern;
  if (solver == StepLinearSolver::kPcg) {
    auto linear = std::make_unique<PcgSolver>(pattern, pcg);
    const PcgSolver& gradients = *linear;  // the step keeps it
    return
        [step = MakeOneSolveStep(model, material, h, std::move(linear)), &gradients](State& state) {
          const IntegratorStatus status = step(state);
          const bool is_solved = status != IntegratorStatus::kOk || gradients.converged();
          return is_solved ? status : IntegratorStatus::kNotConverged;
        };
  }
  if (solver == StepLinearSolver::kFloat)
    return [step = MakeOneSolveStep(model, material, h, std::make_unique<FloatSolver>(pattern))](
               State& state) {
      RoundToFloat(state);
      const IntegratorStatus status = step(state);
      RoundToFloat(state);
      return status;
    };
  return MakeOneSolveStep(model, material, h, MakeLinearSolver(pattern));
}

Integrator MakeImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h,
                             const ImplicitEulerOptions& options) {
  const auto euler = std::make_shared<ImplicitEuler>(model, material, h, options);
  return [euler](State& state) { return euler->Advance(state); };
}

void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K) {
  K.SetZero();
  if (model.scene.stretch) AddFaces(model, material, x.data(), K);
  if (model.scene.bend) AddHinges(model, material, x.data(), K);
  for (int i : model.held)
    K.AddScaledIdentity(model.pattern.diagonal[i], model.scene.handles->stiffness);
}

}  // namespace drape
