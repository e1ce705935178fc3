// SPDX-License-Identifier: Apache-2.0
// Tests of the symmetries and the balance of the forces of a whole cloth, and of its stiffness.
#include "physics/cloth/assembly/assembly.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "physics/cloth/assembly/element_blocks.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

TEST(MirrorTest, TurningTheClothOverChangesNothingInTheSmoothLaw) {
  std::mt19937_64 random(11);
  for (const std::string law : {"smooth", "reference"}) {
    Scene scene;
    const ClothModel model(test::SmallDisc(law)->mesh, scene, MakeLaw(law));
    const Eigen::VectorXd x = test::NoisyStart(model, 3e-3, random).x;
    Eigen::VectorXd force, mirrored_force, mirrored_x = x;
    for (int i = 2; i < x.size(); i += 3) mirrored_x[i] = -x[i];
    AssembleForce(model, test::TestMaterial(), x, force);
    AssembleForce(model, test::TestMaterial(), mirrored_x, mirrored_force);
    for (int i = 2; i < x.size(); i += 3) mirrored_force[i] = -mirrored_force[i];
    const double difference = (force - mirrored_force).norm() / force.norm();
    if (law == "smooth") {
      EXPECT_LT(difference, 1e-12);
    } else {
      EXPECT_GT(difference, 1e-6);  // a known artefact of the reference law
    }
  }
}

TEST(RigidMotionTest, NoForceAndNoTorque) {
  std::mt19937_64 random(12);
  for (const std::string law : {"smooth", "reference"}) {
    const ClothModel model(test::SmallDisc(law)->mesh, Scene(), MakeLaw(law));
    const MaterialField material = test::TestMaterial();
    const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(1, 2, -1).normalized());
    const auto rigid = [&](Eigen::VectorXd x) {
      for (int i = 0; i < x.size(); i += 3)
        x.segment<3>(i) = turn * x.segment<3>(i) + Eigen::Vector3d(0.3, -0.2, 0.7);
      return x;
    };
    // There is no force at rest. The scale is that of a strain of 1 %.
    Eigen::VectorXd force, scale;
    AssembleForce(model, material, 1.01 * model.mesh.rest_x, scale);
    AssembleForce(model, material, rigid(model.mesh.rest_x), force);
    EXPECT_LT(force.norm(), 1e-10 * scale.norm());
    // In a deformed shape internal forces balance, and they turn with the cloth.
    const Eigen::VectorXd x = test::NoisyStart(model, 1e-3, random).x, turned = rigid(x);
    Eigen::VectorXd turned_force;
    AssembleForce(model, material, x, force);
    AssembleForce(model, material, turned, turned_force);
    Eigen::Vector3d total = Eigen::Vector3d::Zero(), torque = total;
    for (int i = 0; i < x.size(); i += 3) {
      total += turned_force.segment<3>(i);
      torque += turned.segment<3>(i).cross(turned_force.segment<3>(i));
      EXPECT_LT((turn * force.segment<3>(i) - turned_force.segment<3>(i)).norm(),
                1e-10 * force.norm());
    }
    EXPECT_LT(total.norm(), 1e-10 * force.norm());
    EXPECT_LT(torque.norm(), 1e-10 * force.norm());
  }
}

TEST(AssemblyTest, HingePartOfTheStepMatrixHasRankOne) {
  DiscOptions options;
  options.target_vertices = 100;
  Mesh mesh = MakeDisc(options);
  mesh.hinges.resize(1);
  Scene scene;
  scene.stretch = false;
  const ClothModel model(mesh, scene, MakeLaw("smooth"));
  MaterialField material = test::TestMaterial();
  material.density = 0.0;
  std::mt19937_64 random(13);
  Eigen::VectorXd force;
  BlockMatrix A(model.pattern);
  AssembleStep(model, material, test::NoisyStart(model, 3e-3, random).x, 0.05, force, A);
  const int n = model.num_dofs();
  RowMatrix dense = RowMatrix::Zero(n, n);
  AddMultiply(model.pattern, A, RowMatrix::Identity(n, n), dense);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense);
  EXPECT_LT((dense - dense.transpose()).norm(), 1e-14 * dense.norm());
  EXPECT_GT(eigen.eigenvalues()[n - 1], 0.0);
  EXPECT_LT(std::fabs(eigen.eigenvalues()[n - 2]), 1e-12 * eigen.eigenvalues()[n - 1]);
  EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[n - 1]);
}

RowMatrix Dense(const ClothModel& model, const BlockMatrix& A) {
  const int n = model.num_dofs();
  RowMatrix dense = RowMatrix::Zero(n, n);
  AddMultiply(model.pattern, A, RowMatrix::Identity(n, n), dense);
  return dense;
}

// A disc on a support, with handles.
ClothModel SupportedDisc(const std::string& law) {
  Scene scene = CusickScene();
  scene.handles = Handles{};
  return {test::SmallDisc(law)->mesh, scene, MakeLaw(law)};
}

// The blocks in vector registers are those of the dense derivative of each hinge.
TEST(StiffnessTest, HingeBlocksAreThoseOfTheDerivative) {
  std::mt19937_64 random(16);
  const ClothModel model(test::SmallDisc("smooth")->mesh, Scene(), MakeLaw("smooth"));
  const MaterialField material = test::TestMaterial();
  const Eigen::VectorXd x = test::NoisyStart(model, 3e-3, random).x,
                        w = test::NoisyStart(model, 3e-3, random).x;
  for (int e = 0; e < 20; ++e) {
    const Hinge& hinge = model.mesh.hinges[e];
    const HingeCorners places = GatherCorners(hinge, x.data()),
                       moves = GatherCorners(hinge, w.data());
    double Q[12][12];
    BendStepDerivative(SmoothBend(), hinge, material.bend[0], places, moves, 0.05, Q);
    BlockMatrix by_row(model.pattern), in_registers(model.pattern);
    AddHingeBlocks(Q, &model.pattern.hinge_block[16 * e], by_row);
    AddHingeBlocks(
        EvaluateBendStepRates(SmoothBend(), hinge, material.bend[0], places, moves, 0.05), 1.0,
        &model.pattern.hinge_block[16 * e], in_registers);
    const RowMatrix expected = Dense(model, by_row);
    EXPECT_GT(expected.norm(), 0.0);
    EXPECT_LT((Dense(model, in_registers) - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(StiffnessTest, IsTheSymmetricPartOfTheDerivativeOfTheForce) {
  std::mt19937_64 random(17);
  for (const std::string law : {"smooth", "reference"}) {
    const ClothModel model = SupportedDisc(law);
    const MaterialField material = test::Scatter(test::TestMaterial(), model.mesh, 0.2, random);
    const Eigen::VectorXd x = test::NoisyStart(model, 3e-3, random).x;
    Eigen::VectorXd force, expected_force;
    const ElementStates states = EvaluateElements(model, material, x, force);
    AssembleForce(model, material, x, expected_force);
    EXPECT_LT((force - expected_force).norm(), 1e-13 * force.norm());
    BlockMatrix derivative(model.pattern), K(model.pattern);
    AssembleStepDerivative(model, material, x, Eigen::VectorXd::Zero(x.size()), 1.0, derivative);
    AssembleStiffness(model, states, MembraneStress(states), x, StiffnessPart::kWhole, K);
    const RowMatrix by_x = Dense(model, derivative), stiffness = Dense(model, K);
    EXPECT_GT((by_x - by_x.transpose()).norm(), 1e-6 * by_x.norm());
    EXPECT_LT((stiffness + 0.5 * (by_x + by_x.transpose())).norm(), 1e-13 * by_x.norm()) << law;
  }
}

TEST(StiffnessTest, HasTheGeometricPartOfTheGivenStress) {
  std::mt19937_64 random(18);
  const ClothModel model = SupportedDisc("smooth");
  const Eigen::VectorXd x = test::NoisyStart(model, 3e-3, random).x;
  Eigen::VectorXd force;
  const ElementStates states = EvaluateElements(model, test::TestMaterial(), x, force);
  StressField change(model.mesh.num_faces(), {3.0, -2.0, 1.0}), other = MembraneStress(states);
  for (std::size_t f = 0; f < other.size(); ++f) {
    other[f].uu += change[f].uu;
    other[f].vv += change[f].vv;
    other[f].uv += change[f].uv;
  }
  BlockMatrix expected(model.pattern), K(model.pattern);
  AssembleStiffness(model, states, MembraneStress(states), x, StiffnessPart::kWhole, expected);
  AddGeometricStiffness(model, change, expected);
  AssembleStiffness(model, states, other, x, StiffnessPart::kWhole, K);
  const RowMatrix dense = Dense(model, expected);
  EXPECT_LT((Dense(model, K) - dense).norm(), 1e-13 * dense.norm());
}

TEST(AssemblyPartTest, CornersAreOfOnePartEach) {
  const Mesh mesh = test::SmallDisc("smooth", 500)->mesh;
  for (const int count : {1, 2, 3, 7}) {
    const std::vector<AssemblyPart> parts = SplitAssembly(mesh, count);
    ASSERT_EQ(parts.size(), static_cast<std::size_t>(count));
    std::vector<unsigned> faces(mesh.num_faces(), 0), hinges(mesh.num_hinges(), 0);
    std::size_t twice = 0;
    for (const AssemblyPart& part : parts) {
      EXPECT_FALSE(part.faces.empty());
      for (const auto& [index, corners] : part.faces) {
        EXPECT_EQ(faces[index] & corners, 0U);
        twice += faces[index] != 0;
        faces[index] |= corners;
      }
      for (const auto& [index, corners] : part.hinges) {
        EXPECT_EQ(hinges[index] & corners, 0U);
        hinges[index] |= corners;
      }
    }
    EXPECT_THAT(faces, testing::Each(7U));
    EXPECT_THAT(hinges, testing::Each(15U));
    if (count == 1) {
      EXPECT_EQ(twice, 0U);
    }
    EXPECT_LT(twice, faces.size() / 3) << count << " parts";
  }
}

TEST(AssemblyPartTest, SumsHaveTheSameBits) {
  std::mt19937_64 random(8);
  for (const std::string law : {"smooth", "reference"}) {
    const auto model = test::SmallDisc(law, 500);
    const MaterialField material = test::TestMaterial();
    const Eigen::VectorXd x = test::NoisyStart(*model, 3e-3, random).x,
                          w = test::NoisyStart(*model, 3e-3, random).x;
    Eigen::VectorXd force, step_force, force_of_parts;
    BlockMatrix step(model->pattern), derivative(model->pattern), of_parts(model->pattern);
    AssembleForce(*model, material, x, force);
    AssembleStep(*model, material, x, 0.05, step_force, step);
    AssembleStepDerivative(*model, material, x, w, 0.05, derivative);
    BlockMatrix stiffness(model->pattern);
    const ElementStates states = EvaluateElements(*model, material, x, force_of_parts);
    const double energy = Energy(*model, material.density, states, x);
    AssembleStiffness(*model, states, MembraneStress(states), x, StiffnessPart::kWhole, stiffness);
    const Eigen::VectorXd force_of_states = force_of_parts;
    for (const int count : {1, 2, 5}) {
      SCOPED_TRACE(testing::Message() << law << ", " << count << " parts");
      const AssemblyParts parts = SplitAssembly(model->mesh, count);
      AssembleForce(*model, material, x, force_of_parts, nullptr, parts);
      EXPECT_EQ(force_of_parts, force);
      AssembleStep(*model, material, x, 0.05, force_of_parts, of_parts, nullptr, parts);
      EXPECT_EQ(force_of_parts, step_force);
      EXPECT_TRUE(of_parts.value == step.value);
      AssembleStepDerivative(*model, material, x, w, 0.05, of_parts, nullptr, parts);
      EXPECT_TRUE(of_parts.value == derivative.value);
      const ElementStates own =
          EvaluateElements(*model, material, x, force_of_parts, nullptr, parts);
      EXPECT_EQ(force_of_parts, force_of_states);
      EXPECT_EQ(Energy(*model, material.density, own, x), energy);
      AssembleStiffness(*model, own, MembraneStress(own), x, StiffnessPart::kWhole, of_parts,
                        nullptr, parts);
      EXPECT_TRUE(of_parts.value == stiffness.value);
    }
  }
}

}  // namespace
}  // namespace drape
