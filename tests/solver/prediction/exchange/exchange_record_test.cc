// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/exchange_record.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class ExchangeRecordTest : public FileFixture {
 protected:
  // Two factors, on all stretch and on all bend entries: bend known to 10 %, stretch not at all.
  static StoredPosterior Scales() {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kScales;
    posterior.base = test::TestMaterial();
    posterior.prior_sd.resize(2);
    posterior.prior_sd << 1.0, 0.8;
    posterior.mean.resize(2);
    posterior.mean << 0.2, -0.5;
    posterior.covariance.resize(2, 2);
    posterior.covariance << 1.0, 0.0, 0.0, 0.01;
    return posterior;
  }
  static const RecordedNumber& Number(const ExchangeRecord& record, const std::string& key) {
    for (const RecordedNumber& number : record.numbers)
      if (number.key == key) return number;
    throw std::out_of_range(key);
  }
};

TEST_F(ExchangeRecordTest, APosteriorTellsMeasuredFromPrior) {
  WritePosterior(Path(""), Scales(), "test");
  const Law law = MakeLaw("smooth");
  const FabricSource source = ReadFabric(Path(""));
  const ExchangeRecord record = MakeRecord(source, law, {});
  const LinearFabric base = LineariseAtRest(test::TestMaterial(), law);
  const RecordedNumber& bend = Number(record, "bend_weft");
  EXPECT_NEAR(bend.value, base.bend_weft * std::exp(-0.5), 1e-9 * bend.value);
  // A log-normal of sd 0.1.
  EXPECT_NEAR(*bend.sd / bend.value, 0.1, 0.01);
  EXPECT_NEAR(*bend.share_removed, 1.0 - 0.01 / 0.64, 0.003);
  EXPECT_TRUE(bend.measured());
  const RecordedNumber& stretch = Number(record, "c11");
  EXPECT_NEAR(stretch.value, base.c11 * std::exp(0.2), 1e-9 * stretch.value);
  EXPECT_LT(*stretch.share_removed, 0.15);
  EXPECT_FALSE(stretch.measured());
  const nlohmann::ordered_json json = RecordJson(record);
  EXPECT_EQ(json.at("linear").at("bend_weft").at("origin"), "measured");
  EXPECT_EQ(json.at("linear").at("c11").at("origin"), "prior");
  EXPECT_EQ(json.at("tables").at("stretch").size(), 6u);
  EXPECT_EQ(json.at("thickness"), nullptr);
}

TEST_F(ExchangeRecordTest, SamplesHaveTheMomentsOfThePosterior) {
  StoredPosterior posterior = Scales();
  posterior.covariance << 0.5, 0.06, 0.06, 0.01;
  const FabricSamples samples = SampleFabric(posterior, 4000, 1);
  EXPECT_EQ(samples.names, (std::vector<std::string>{"stretch", "bend"}));
  const Eigen::MatrixXd deviation =
      samples.log_factors.colwise() - samples.log_factors.rowwise().mean();
  const Eigen::Matrix2d covariance = deviation * deviation.transpose() / 3999.0;
  EXPECT_NEAR(covariance(0, 0), 0.5, 0.05);
  EXPECT_NEAR(covariance(0, 1), 0.06, 0.006);
  EXPECT_NEAR(covariance(1, 1), 0.01, 0.001);
  EXPECT_NEAR(samples.log_factors.row(1).mean(), -0.5, 0.01);
  EXPECT_NEAR(samples.tables[7].bend[0].b[1][2],
              posterior.base.bend[0].b[1][2] * std::exp(samples.log_factors(1, 7)), 1e-12);
  const FabricSamples prior = SamplePrior(posterior, 4000, 1);
  EXPECT_NEAR(std::sqrt(prior.log_factors.row(0).squaredNorm() / 4000.0), 1.0, 0.05);
}

TEST_F(ExchangeRecordTest, AMaterialFileHasNoUncertainty) {
  const std::string file = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json";
  const Law law = MakeLaw("smooth");
  const ExchangeRecord record = MakeRecord(ReadFabric(file), law, {});
  EXPECT_EQ(record.source.material.name, "synthetic_wool");
  EXPECT_FALSE(record.numbers[0].sd);
  EXPECT_EQ(RecordJson(record).at("linear").at("c11").at("origin"), "not known");
}

TEST_F(ExchangeRecordTest, RefusesWhatIsNoFabric) {
  EXPECT_INPUT_ERROR(ReadFabric(Path("")), "found no material.json");
  EXPECT_INPUT_ERROR(ReadFabric(Path("none.json")), "none.json");
  Write("field.json", R"({"format": "drapefit-material-field"})");
  EXPECT_INPUT_ERROR(ReadFabric(Path("field.json")), "a table for each element");
}

}  // namespace
}  // namespace drape
