// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/geometry/drape_files.h"

#include "physics/simulation/textbook.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class DrapeFiles : public FileFixture {
 protected:
  DrapeFiles() : model_(test::SmallDisc("smooth", 150)), x_(model_->mesh.rest_x) {
    // Stretched along the weft by 1 %, along the warp by 2 %.
    for (int i = 0; i < model_->mesh.num_vertices(); ++i) {
      x_[3 * i] *= 1.01;
      x_[3 * i + 1] *= 1.02;
    }
    fields_ = ComputeFaceFields(*model_, LinearMaterial(100.0, 2e-5, 0.15), x_);
  }

  std::shared_ptr<const ClothModel> model_;
  Eigen::VectorXd x_;
  std::vector<FaceField> fields_;
};

TEST_F(DrapeFiles, FieldsAreThoseOfAUniformStretch) {
  const int faces = model_->mesh.num_faces();
  const double uu = (1.01 * 1.01 - 1.0) / 2.0, vv = (1.02 * 1.02 - 1.0) / 2.0;
  ASSERT_EQ(fields_.size(), 4u);
  for (int f = 0; f < faces; ++f) {
    EXPECT_NEAR(fields_[0].values[3 * f], uu, 1e-12);
    EXPECT_NEAR(fields_[0].values[3 * f + 1], vv, 1e-12);
    EXPECT_NEAR(fields_[0].values[3 * f + 2], 0.0, 1e-12);
    EXPECT_NEAR(fields_[1].values[3 * f], 100.0 * uu, 1e-9);
    EXPECT_NEAR(fields_[1].values[3 * f + 1], 100.0 * vv, 1e-9);
    EXPECT_NEAR(fields_[2].values[4 * f], 100.0, 1e-9);
    EXPECT_NEAR(fields_[3].values[f], 2e-5, 1e-15);
  }
}

TEST_F(DrapeFiles, VtuReadsBackBitForBit) {
  WriteVtu(Path("a.vtu"), model_->mesh, x_, fields_);
  const std::string text = Read(Path("a.vtu"));
  std::istringstream numbers(text.substr(text.find('>', text.find("Name=\"position\"")) + 1));
  for (int i = 0; i < x_.size(); ++i) {
    std::string number;
    numbers >> number;
    EXPECT_EQ(std::stod(number), x_[i]);
  }
  for (const char* name : {"strain [1]", "tension [N/m]", "stiffness [N/m]", "rigidity [N m]",
                           "rest", "ComponentName3=\"c33\""})
    EXPECT_THAT(text, testing::HasSubstr(name));
  WritePvd(Path("a.pvd"), {{0.5, "a.vtu"}});
  EXPECT_THAT(Read(Path("a.pvd")),
              testing::HasSubstr("timestep=\"0.5\" part=\"0\" file=\"a.vtu\""));
}

}  // namespace
}  // namespace drape
