// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "physics/simulation/backend.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/summed_tangents.h"

namespace drape::test {

// A cloth without physics: the drape of a material is the rest shape, each point moved along its
// radius by the factor g(θ, p) = 1 − kShrink·tanh(s) + kRipple·tanh(b)·cos 3θ of its angle θ, where
// s and b are the mean logarithms of the stretch and bend entries over those of TestMaterial.
// Derivatives are exact. A test chooses where it fails.
class FakeBackend final : public Backend {
 public:
  static constexpr double kShrink = 0.2, kRipple = 0.05;

  explicit FakeBackend(int vertices = 120) : model_(SmallDisc("smooth", vertices)) {}

  using Region = std::function<bool(double s, double b)>;

  Region fails = [](double, double) { return false; };         // the drape cannot be computed
  Region unstable = [](double, double) { return false; };      // it has no derivatives
  Region other_branch = [](double, double) { return false; };  // it is turned by kTurn
  static constexpr double kTurn = 0.1;                         // [rad]

  std::string name() const override { return "fake"; }
  const ClothModel& model() const override { return *model_; }
  int threads() const override { return 1; }

  // s and b of a material.
  static Eigen::Vector2d Logs(const MaterialField& material) {
    const MaterialField base = TestMaterial();
    double stretch = 0.0, bend = 0.0;
    for (int i = 0; i < kStretchEntries; ++i)
      stretch += std::log(material.stretch[0].entries()[i] / base.stretch[0].entries()[i]);
    for (int i = 0; i < kBendEntries; ++i)
      bend += std::log(material.bend[0].entries()[i] / base.bend[0].entries()[i]);
    return {stretch / kStretchEntries, bend / kBendEntries};
  }

  Eigen::VectorXd Shape(const MaterialField& material) const {
    const Eigen::Vector2d p = Logs(material);
    const double turn = other_branch(p[0], p[1]) ? kTurn : 0.0;
    return Radial(
        [&](double angle) {
          return 1.0 - kShrink * std::tanh(p[0]) +
                 kRipple * std::tanh(p[1]) * std::cos(3 * angle - turn);
        },
        turn);
  }

  // ∂x/∂(log entry), shape [3V, 39].
  RowMatrix ShapeByLogEntries(const MaterialField& material) const {
    const Eigen::Vector2d p = Logs(material);
    const auto slope = [](double q) { return 1.0 - std::tanh(q) * std::tanh(q); };
    const Eigen::VectorXd by_s = Radial([&](double) { return -kShrink * slope(p[0]); }, 0.0);
    const Eigen::VectorXd by_b =
        Radial([&](double angle) { return kRipple * slope(p[1]) * std::cos(3 * angle); }, 0.0);
    RowMatrix columns(by_s.size(), kMaterialEntries);
    columns.leftCols(kStretchEntries) = by_s.replicate(1, kStretchEntries) / kStretchEntries;
    columns.rightCols(kBendEntries) = by_b.replicate(1, kBendEntries) / kBendEntries;
    return columns;
  }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch, const RolloutOptions&,
                                      std::vector<Recording>*) override {
    std::vector<RolloutResult> results;
    for (const RolloutInput& input : batch) {
      const Eigen::VectorXd x = Shape(*input.material);
      results.push_back(
          {Fails(input) ? RolloutStatus::kNotPositiveDefinite : RolloutStatus::kOk, {x, 0 * x}, 0});
    }
    return results;
  }
  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const>,
                                      const RolloutOptions& options) override {
    std::vector<TangentResult> results;
    for (RolloutResult& rollout : Rollouts(batch, options, nullptr))
      results.push_back({std::move(rollout), {}, {}});
    for (std::size_t i = 0; i < batch.size(); ++i)
      results[i].dx = ShapeByLogEntries(*batch[i].material);
    return results;
  }
  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording>, std::span<const RowMatrix>,
                                      const RolloutOptions&) override {
    return std::vector<AdjointResult>(batch.size());
  }
  std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                            const EquilibriumOptions&) override {
    std::vector<EquilibriumResult> results;
    largest_batch = std::max(largest_batch, batch.size());
    for (const RolloutInput& input : batch) {
      ++equilibria;
      results.emplace_back().x = Shape(*input.material);
      results.back().status =
          Fails(input) ? EquilibriumStatus::kNotConverged : EquilibriumStatus::kStable;
    }
    return results;
  }
  std::vector<RowMatrix> EquilibriumTangents(std::span<const RolloutInput> batch,
                                             std::span<const MaterialField* const>) override {
    std::vector<RowMatrix> results;
    for (const RolloutInput& input : batch) {
      const Eigen::Vector2d p = Logs(*input.material);
      results.push_back(unstable(p[0], p[1]) ? RowMatrix() : ShapeByLogEntries(*input.material));
    }
    return results;
  }
  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    return SumEquilibriumTangents(*this, batch, changes);
  }
  std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix>) override {
    return std::vector<std::optional<MaterialGradient>>(batch.size());
  }

  int equilibria = 0;             // requested so far
  std::size_t largest_batch = 0;  // of them

 private:
  bool Fails(const RolloutInput& input) const {
    const Eigen::Vector2d p = Logs(*input.material);
    return fails(p[0], p[1]);
  }
  Eigen::VectorXd Radial(const std::function<double(double)>& factor, double turn) const {
    Eigen::VectorXd x = model_->mesh.rest_x;
    for (int i = 0; i < x.size(); i += 3) {
      const double angle = std::atan2(x[i + 1], x[i]) + turn;
      const double radius = std::hypot(x[i], x[i + 1]) * factor(angle);
      x.segment<3>(i) << radius * std::cos(angle), radius * std::sin(angle), 0.0;
    }
    return x;
  }

  std::shared_ptr<const ClothModel> model_;
};

}  // namespace drape::test
