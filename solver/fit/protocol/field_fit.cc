// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/field_fit.h"

#include <Spectra/MatOp/SymShiftInvert.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/util/math/random.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Eigen::VectorXd VertexAreas(const Mesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_vertices());
  for (const Face& face : mesh.faces)
    for (const int v : face.vertex) areas[v] += face.area / 3;
  return areas;
}

constexpr int kModesDisc = 1200;  // vertices of the disc on which modes are found
// The damping is in units of the prior, beside squared singular values up to some 1e5 of outlines;
// σ of an experiment may be as small as one likes.
constexpr double kMaxDamping = 1e7, kNoLimit = std::numeric_limits<double>::infinity();
// The drape of a single table has been fitted to the end of its branch: trials move to the next
// branch, millimetres away, and Newton needs 30 to 60 iterations for that.
constexpr int kNewtonFactor = 3;
constexpr double kRestartDamping = 100.0;  // beside the same squares
constexpr double kFieldTolerance = 1e-4;
// For the progress line: iterations of an attempt, and the share of the time that the first takes.
constexpr double kUsualIterations = 30.0, kFirstShare = 0.8;

// A field that one parameter moves as a whole.
FieldTerm::Basis Constant(int elements, double value) {
  return Eigen::MatrixXd::Constant(elements, 1, value).sparseView();
}

FieldTerm::Basis Identity(int elements, double sigma) {
  FieldTerm::Basis basis(elements, elements);
  basis.setIdentity();
  return sigma * basis;
}

Eigen::MatrixXd GroupTie(int entries, FieldGroups groups) {
  if (groups == FieldGroups::kEntries) return Eigen::MatrixXd::Identity(entries, entries);
  return Eigen::MatrixXd::Ones(entries, 1);
}

// A standard deviation of mean log factors, given as rows of a, shape [elements, P], under the
// prior and under the posterior 1 − Jᵀ·(J·Jᵀ + 1)⁻¹·J of its linearisation.
void Deviations(const FieldTerm::Basis& a, const Eigen::MatrixXd& jacobian, Eigen::VectorXd* prior,
                Eigen::VectorXd* posterior) {
  const Eigen::Index rows = jacobian.rows();
  const Eigen::LLT<Eigen::MatrixXd> data(jacobian * jacobian.transpose() +
                                         Eigen::MatrixXd::Identity(rows, rows));
  const Eigen::MatrixXd known = data.matrixL().solve((a * jacobian.transpose()).transpose());
  Eigen::VectorXd variance(a.rows());
  for (Eigen::Index e = 0; e < a.rows(); ++e) variance[e] = a.row(e).squaredNorm();
  *prior = variance.cwiseSqrt();
  variance -= known.colwise().squaredNorm().transpose();
  *posterior = variance.cwiseMax(0.0).cwiseSqrt();
}

// Squared singular values of the Jacobian above those of a unit prior.
int CountDetermined(const Eigen::MatrixXd& jacobian) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> squares(jacobian * jacobian.transpose(),
                                                               Eigen::EigenvaluesOnly);
  return static_cast<int>((squares.eigenvalues().array() > 1.0).count());
}

}  // namespace

Sparse LaplaceStiffness(const Mesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Face& face : mesh.faces) {
    const Eigen::Matrix<double, 2, 3> gradients = BarycentricGradients(mesh, face);
    const Eigen::Matrix3d element = face.area * gradients.transpose() * gradients;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        entries.emplace_back(face.vertex[i], face.vertex[j], element(i, j));
  }
  Sparse stiffness(mesh.num_vertices(), mesh.num_vertices());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return stiffness;
}

LaplaceModes FindLaplaceModes(const Mesh& mesh, int count) {
  CHECK(count >= 1 && count < mesh.num_vertices() - 1) << count;
  constexpr int kMaxRestarts = 1000;
  constexpr double kTolerance = 1e-10;
  const Eigen::VectorXd areas = VertexAreas(mesh);
  const double area = areas.sum();
  const Sparse stiffness = LaplaceStiffness(mesh);
  Sparse mass(areas.size(), areas.size());
  for (int i = 0; i < areas.size(); ++i) mass.insert(i, i) = areas[i];
  using ShiftInvert = Spectra::SymShiftInvert<double, Eigen::Sparse, Eigen::Sparse>;
  using Product = Spectra::SparseSymMatProd<double>;
  ShiftInvert inverse(stiffness, mass);
  Product product(mass);
  const int subspace = std::min<int>(mesh.num_vertices(), std::max(2 * count + 1, 20));
  // The lowest eigenvalue is 0: shift below it, by less than the first that is not.
  Spectra::SymGEigsShiftSolver<ShiftInvert, Product, Spectra::GEigsMode::ShiftInvert> lanczos(
      inverse, product, count, subspace, -1.0 / area);
  lanczos.init();
  lanczos.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance,
                  Spectra::SortRule::SmallestAlge);
  CHECK(lanczos.info() == Spectra::CompInfo::Successful) << "modes of the Laplacian";
  LaplaceModes modes{lanczos.eigenvalues().cwiseMax(0.0), lanczos.eigenvectors()};
  for (auto mode : modes.vectors.colwise()) {
    Eigen::Index largest;
    mode.cwiseAbs().maxCoeff(&largest);
    mode *= std::copysign(std::sqrt(area / mode.cwiseAbs2().dot(areas)), mode[largest]);
  }
  return modes;
}

Eigen::VectorXd MaternDeviations(const Eigen::VectorXd& eigenvalues, const MaternOptions& options) {
  CHECK_GT(options.length, 0.0);
  const double kappa_squared = 2.0 / (options.length * options.length);
  const Eigen::VectorXd deviations = (kappa_squared + eigenvalues.array()).inverse();
  return options.sigma / deviations.norm() * deviations;
}

void FieldOptions::Check() const {
  CheckFields(*this);
  CHECK_LT(modes, kModesDisc - 1);
}

std::vector<FieldTerm> CommonTerms(const Mesh& mesh, double sigma) {
  const auto all = [](int entries) { return Eigen::MatrixXd::Identity(entries, entries); };
  return {{ElementKind::kFaces, Constant(mesh.num_faces(), sigma), all(kStretchEntries)},
          {ElementKind::kHinges, Constant(mesh.num_hinges(), sigma), all(kBendEntries)}};
}

std::vector<FieldTerm> NoiseTerms(const Mesh& mesh, double sigma, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<FieldTerm> terms = CommonTerms(mesh, sigma);
  const auto add = [&](ElementKind kind, int elements, int entries) {
    for (int k = 0; k < entries; ++k) {
      Eigen::VectorXd noise(elements);
      for (double& value : noise) value = sigma * SampleNormal(random);
      terms.push_back(
          {kind, noise.sparseView(), Eigen::MatrixXd::Identity(entries, entries).col(k)});
    }
  };
  add(ElementKind::kFaces, mesh.num_faces(), kStretchEntries);
  add(ElementKind::kHinges, mesh.num_hinges(), kBendEntries);
  return terms;
}

std::vector<FieldTerm> MakeFieldTerms(const Mesh& mesh, const FieldOptions& options) {
  options.Check();
  const bool stretch = options.groups != FieldGroups::kBend;
  const bool bend = options.groups != FieldGroups::kStretch;
  std::vector<FieldTerm> terms;
  const auto add = [&](ElementKind kind, int entries, const FieldTerm::Basis& basis) {
    terms.push_back({kind, basis, GroupTie(entries, options.groups)});
  };
  if (options.basis == FieldBasis::kElements) {
    if (stretch)
      add(ElementKind::kFaces, kStretchEntries, Identity(mesh.num_faces(), options.sigma));
    if (bend) add(ElementKind::kHinges, kBendEntries, Identity(mesh.num_hinges(), options.sigma));
    return terms;
  }
  const Mesh disc = MakeDisc({.target_vertices = kModesDisc});
  const LaplaceModes modes = FindLaplaceModes(disc, options.modes);
  const Eigen::MatrixXd scaled =
      modes.vectors *
      MaternDeviations(modes.eigenvalues, {options.length, options.sigma}).asDiagonal();
  const auto at = [&](const Eigen::Matrix2Xd& places) -> FieldTerm::Basis {
    return (InterpolationWeights(disc, places) * scaled).eval().sparseView();
  };
  if (stretch) add(ElementKind::kFaces, kStretchEntries, at(FaceCentres(mesh)));
  if (bend) add(ElementKind::kHinges, kBendEntries, at(HingeCentres(mesh)));
  return terms;
}

namespace {

// The fit of one set of terms; each attempt is a run of Ceres from numbers and drapes of its own.
class FieldFitter {
 public:
  FieldFitter(const FitProblem& problem, const StagedFitOptions& staged,
              const FieldOptions& options, const FitCandidate& candidate, const RunControl& control)
      : problem_(problem),
        staged_(staged),
        options_(options),
        control_(control),
        candidate_fitter_(problem, staged, *problem.fine, control.cancel, 0),
        parametrisation_(FittedMaterial(staged, candidate), mesh().num_faces(), mesh().num_hinges(),
                         Terms()),
        best_drapes_(AtRest(candidate.shapes)) {}

  FieldFit Run() {
    Attempt(0, Eigen::VectorXd::Zero(parametrisation_.size()), best_drapes_);
    for (int restart = 1; restart <= options_.restarts && !Cancelled() && Succeeded(); ++restart)
      TryNeighbourBranch(restart);
    return Conclude();
  }

 private:
  const Mesh& mesh() const { return problem_.fine->model().mesh; }
  bool Cancelled() const { return control_.cancelled(); }
  bool Succeeded() const { return best_.termination != FitTermination::kFailed; }

  std::vector<FieldTerm> Terms() const {
    std::vector<FieldTerm> terms = CommonTerms(mesh(), staged_.prior_sigma);
    for (FieldTerm& term : MakeFieldTerms(mesh(), options_)) terms.push_back(std::move(term));
    return terms;
  }
  RolloutResiduals OutlinesAt(const Eigen::VectorXd& theta,
                              const std::vector<State>& starts) const {
    ResidualOptions options = candidate_fitter_.MakeResidualOptions();
    options.equilibrium.max_iterations *= kNewtonFactor;
    RolloutResiduals outlines = ObservationResiduals(problem_.fine, &parametrisation_,
                                                     problem_.observations, starts, options);
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), theta.size()) = theta;
    return outlines;
  }

  void Attempt(int number, const Eigen::VectorXd& theta, const std::vector<State>& starts) {
    FitOptions options;
    options.trust_region.max_iterations = options_.iterations;
    options.trust_region.initial_damping = staged_.initial_damping;
    options.trust_region.unit_damping = true;
    options.trust_region.max_damping = FindExperiment(problem_) ? kNoLimit : kMaxDamping;
    options.trust_region.cost_tolerance = kFieldTolerance;
    options.trust_region.cancel = control_.cancel;
    options.trust_region.progress = [&](const FitIteration& iteration) {
      const double share = IterationShare(iteration.iteration, kUsualIterations);
      const double restarts = (number - 1 + share) / std::max(1, options_.restarts);
      control_.Report(
          number == 0 ? kFirstShare * share : kFirstShare + (1.0 - kFirstShare) * restarts,
          "fields");
    };
    RolloutResiduals outlines = OutlinesAt(theta, starts);
    FitSummary summary = Fit(outlines, options);
    counts_ += summary.counts;
    iterations_ += static_cast<int>(summary.iterations.size()) - 1;
    seconds_ += summary.seconds;
    const bool valid = summary.termination != FitTermination::kFailed;
    if (number == 0) {
      initial_cost_ = summary.initial_cost;
    } else if (!valid || summary.final_cost >= best_.final_cost) {
      return;
    }
    best_ = std::move(summary);
    best_drapes_ = outlines.starts();
  }

  // Where Ceres ends, each step towards lower costs moves to a neighbouring branch, where the cost
  // is a little higher. This takes one such step and continues the fit from there.
  void TryNeighbourBranch(int number) {
    std::vector<State> drapes = best_drapes_;
    RolloutResiduals outlines = OutlinesAt(best_.theta, drapes);
    outlines.PrepareForEvaluation(true, true);
    if (!outlines.has_accepted()) return;
    const double damping = 1.0 + kRestartDamping / number;
    const Eigen::MatrixXd& jacobian = outlines.accepted().jacobian;
    const Eigen::VectorXd gradient =
        jacobian.transpose() * outlines.accepted().residual + best_.theta;
    // −(JᵀJ + c)⁻¹·gradient by the dual system.
    Eigen::MatrixXd dual = jacobian * jacobian.transpose();
    dual.diagonal().array() += damping;
    const Eigen::VectorXd step =
        (jacobian.transpose() * dual.ldlt().solve(jacobian * gradient) - gradient) / damping;
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), step.size()) += step;
    outlines.PrepareForEvaluation(false, true);
    if (!outlines.all_valid()) return;
    for (int i = 0; i < outlines.num_blocks(); ++i) drapes[i].x = outlines.shape(i);
    Attempt(number, best_.theta + step, drapes);
  }

  FieldFit Conclude() {
    FieldFit fit;
    fit.summary = std::move(best_);
    fit.summary.initial_cost = initial_cost_;
    fit.summary.counts = counts_;
    fit.summary.seconds = seconds_;
    fit.iterations = iterations_;
    if (fit.summary.termination == FitTermination::kFailed) return fit;
    fit.material = parametrisation_.Material(fit.summary.theta);
    for (const State& drape : best_drapes_) fit.shapes.push_back(drape.x);
    fit.determined = CountDetermined(fit.summary.jacobian);
    Deviations(parametrisation_.MeanLogFactor(ElementKind::kFaces), fit.summary.jacobian,
               &fit.prior_face, &fit.posterior_face);
    Deviations(parametrisation_.MeanLogFactor(ElementKind::kHinges), fit.summary.jacobian,
               &fit.prior_hinge, &fit.posterior_hinge);
    return fit;
  }

  const FitProblem& problem_;
  const StagedFitOptions& staged_;
  const FieldOptions& options_;
  const RunControl& control_;
  const CandidateFitter candidate_fitter_;
  const FieldParametrisation parametrisation_;
  FitSummary best_;
  std::vector<State> best_drapes_;
  double initial_cost_ = 0.0, seconds_ = 0.0;
  int iterations_ = 0;
  RolloutCounts counts_;
};

}  // namespace

FieldFit FitFields(const FitProblem& problem, const StagedFitOptions& staged,
                   const FieldOptions& options, const FitCandidate& candidate,
                   const RunControl& control) {
  return FieldFitter(problem, staged, options, candidate, control).Run();
}

}  // namespace drape
