// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "physics/cloth/assembly/assembly.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

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
    }
  }
}

}  // namespace
}  // namespace drape
