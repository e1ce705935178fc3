// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/geometry/drape_files.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

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
  for (const double value : LargestStrains(fields_[0])) EXPECT_NEAR(value, vv, 1e-12);
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

TEST_F(DrapeFiles, GlbHoldsPositionsRestAndColours) {
  WriteGlb(Path("a.glb"), model_->mesh, x_, "strain", LargestStrains(fields_[0]));
  const std::string bytes = Read(Path("a.glb"));
  const auto word = [&](size_t at) {
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(8), bytes.size());
  const nlohmann::json json = nlohmann::json::parse(bytes.substr(20, word(12)));
  const size_t binary = 20 + word(12) + 8;
  const nlohmann::json& attributes =
      json.at("meshes").at(0).at("primitives").at(0).at("attributes");
  const auto values = [&](const char* name, int components) {
    const nlohmann::json& accessor = json.at("accessors").at(attributes.at(name).get<int>());
    EXPECT_EQ(accessor.at("count"), model_->mesh.num_vertices());
    const nlohmann::json& view = json.at("bufferViews").at(accessor.at("bufferView").get<int>());
    std::vector<float> list(static_cast<size_t>(components) * model_->mesh.num_vertices());
    EXPECT_EQ(view.at("byteLength").get<size_t>(), 4 * list.size());
    std::memcpy(list.data(), bytes.data() + binary + view.at("byteOffset").get<size_t>(),
                4 * list.size());
    return list;
  };
  const std::vector<float> position = values("POSITION", 3), rest = values("TEXCOORD_0", 2),
                           value = values("_VALUE", 1), colour = values("COLOR_0", 3);
  for (int i = 0; i < model_->mesh.num_vertices(); ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(position[3 * i + k], static_cast<float>(x_[3 * i + k]));
    for (int k = 0; k < 2; ++k)
      EXPECT_EQ(rest[2 * i + k], static_cast<float>(model_->mesh.uv(k, i)));
    EXPECT_NEAR(value[i], (1.02 * 1.02 - 1.0) / 2.0, 1e-7);
    EXPECT_GT(colour[3 * i], 0.99f);  // the most is red
  }
}

}  // namespace
}  // namespace drape
