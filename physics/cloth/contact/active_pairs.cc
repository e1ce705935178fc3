// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/active_pairs.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "physics/cloth/contact/vertex_contact.h"

namespace drape {
namespace {

PairMatrix PositivePart(const PairMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<PairMatrix> solver(symmetric);
  const PairMatrix& vectors = solver.eigenvectors();
  return vectors * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}
PairMatrix SelectPart(const PairMatrix& symmetric, StiffnessPart part) {
  switch (part) {
    case StiffnessPart::kPositive:
      return PositivePart(symmetric);
    case StiffnessPart::kNegative:
      return -PositivePart(-symmetric);
    case StiffnessPart::kWhole:
      break;
  }
  return symmetric;
}

// The second derivative of the energy of one pair [N/m].
PairMatrix Curvature(const ActivePair& pair) {
  const Barrier barrier = EvaluateBarrier(pair.gap(), pair.layer.range);
  const Eigen::Vector<double, 12> by_distance =
      (pair.distance.normal * pair.distance.weight.transpose()).reshaped();
  PairMatrix curvature =
      pair.mollifier.value *
      (barrier.curvature * by_distance * by_distance.transpose() +
       barrier.slope * DistanceCurvature(pair.pair.of_edges, pair.places, pair.distance));
  if (pair.mollifier.value < 1.0) {
    const Eigen::Vector<double, 12> by_angle = pair.mollifier.gradient.reshaped();
    const PairMatrix mixed = by_distance * by_angle.transpose();
    curvature += barrier.slope * (mixed + mixed.transpose()) +
                 barrier.value * MollifierCurvature(pair.places, pair.rest_squares);
  }
  return pair.layer.stiffness * pair.area * curvature;
}

}  // namespace

double AddPairForces(const ActivePairs& pairs, Eigen::VectorXd& f) {
  double energy = 0.0;
  for (const ActivePair& pair : pairs) {
    const double scale = pair.layer.stiffness * pair.area;
    const double barrier = EvaluateBarrier(pair.gap(), pair.layer.range).value;
    const Eigen::Vector3d push = NormalForce(pair) * pair.distance.normal;
    for (int i = 0; i < 4; ++i)
      if (pair.of_cloth[i])
        f.segment<3>(3 * pair.pair.vertex[i]) +=
            pair.distance.weight[i] * push - scale * barrier * pair.mollifier.gradient.col(i);
    energy += scale * pair.mollifier.value * barrier;
  }
  return energy;
}

void ForEachPairStiffness(const ActivePairs& pairs, StiffnessPart part, const BlockVisitor& add) {
  for (const ActivePair& pair : pairs) {
    const PairMatrix stiffness = SelectPart(Curvature(pair), part);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int row = pair.pair.vertex[i], column = pair.pair.vertex[j];
        if (row <= column && pair.of_cloth[j])
          add(row, column, stiffness.block<3, 3>(3 * i, 3 * j));
      }
  }
}

double NormalForce(const ActivePair& pair) {
  return -pair.layer.stiffness * pair.area * pair.mollifier.value *
         EvaluateBarrier(pair.gap(), pair.layer.range).slope;
}

Rub MakeRub(const ActivePair& pair, const Eigen::VectorXd& before) {
  Rub rub{.weight = pair.distance.weight, .normal = pair.distance.normal};
  const auto first = std::find(pair.of_cloth.begin(), pair.of_cloth.end(), true);
  const int of_cloth = pair.pair.vertex[first - pair.of_cloth.begin()];
  for (int i = 0; i < 4; ++i) {
    rub.vertex[i] = pair.of_cloth[i] ? pair.pair.vertex[i] : of_cloth;
    if (!pair.of_cloth[i]) rub.weight[i] = 0.0;
  }
  rub.start = rub.Point(before) - pair.obstacle_move;
  return rub;
}

}  // namespace drape
