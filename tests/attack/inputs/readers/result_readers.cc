// SPDX-License-Identifier: Apache-2.0
// Results that other programs read: pools of drapes and what is learned from them, samples of a
// posterior, outlines, figures of others, raw data of a tensile device.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/stored/stored_json.h"
#include "solver/fit/lab_measurement.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/studies/bench/speed_study.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

using nlohmann::json;

// The reader of a file with a checksum that is made right again for each mutant.
Reader MakeSealedReader(const std::string& name, const std::string& path,
                        std::function<std::string(const std::string&)> read) {
  json members = json::parse(ReadText(path));
  const std::string format = members.at("format");
  const int version = members.at("version");
  for (const char* key : {"format", "version", "checksum"}) members.erase(key);
  return {.name = name,
          .file = std::filesystem::path(path).filename(),
          .content = members.dump(),
          .read = std::move(read),
          .seal = [=](const json& changed) {
            return StoredJsonText({format.c_str(), version}, changed);
          }};
}

SpecimenDistribution MiddleOfRanges() {
  SpecimenDistribution middle;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const NumberRange& range = NumberRanges()[k];
    middle.mean[0][k] = middle.mean[1][k] = 0.5 * (range.low + range.high);
    middle.deviation[k] = 0.5 * (range.least_deviation + range.most_deviation);
  }
  return middle;
}

Reader MakePoolReader(const std::string& scratch) {
  const std::string path = scratch + "pool.json";
  DrapePool pool;
  pool.mesh = "disc:300";
  pool.setting = "smooth law";
  pool.simulated = 3;
  pool.rounds = {{.drapes = 3}};
  for (int i = 0; i < 2; ++i)
    pool.drapes.push_back(
        {MiddleOfRanges().mean[0],
         {FeatureVector::Constant(0.3 + 0.01 * i), Eigen::VectorXd::Constant(kPoolAngles, 0.11)}});
  WritePool(path, pool);
  return MakeSealedReader("pool", path, [](const std::string& from) {
    const DrapePool read = ReadPool(from);
    for (const PooledDrape& drape : read.drapes)
      if (!drape.numbers.allFinite() || !drape.shape.radius.allFinite())
        return "read drapes that are not finite";
    return read.LogProposal().array().isNaN().any() ? "read drapes of no density" : "";
  });
}

Reader MakeSpecimensReader(const std::string& scratch) {
  const std::string path = scratch + "specimens.json";
  WriteDistributionFit(path, {.best = MiddleOfRanges(),
                              .resampled = {MiddleOfRanges()},
                              .score = 1.0,
                              .cross_validated = 1.1,
                              .effective = 90.0,
                              .drapes = 100});
  return MakeSealedReader("specimens", path, [](const std::string& from) {
    const DistributionFit fit = ReadDistributionFit(from);
    const SpecimenNumbers numbers = SampleNumbers(fit.best, ClothFace::kUp, 1);
    return numbers.allFinite() ? "" : "read a distribution whose samples are not finite";
  });
}

// In the folder of the mutant.
Reader MakeSamplesReader(const std::string& scratch) {
  constexpr int kParameters = 2;
  StoredSamples stored;
  stored.drawn = 2;
  stored.images = {{"front", 1e-3, Eigen::Vector3d(0.11, 0.12, 0.13)}};
  stored.samples = {
      {Eigen::Vector2d(0.1, -0.3), -1.5, -0.25, Eigen::MatrixXd::Constant(3, 1, 0.12)}};
  WriteSamples(scratch, stored);
  return {.name = "samples",
          .file = kSamplesFile,
          .content = ReadText(scratch + kSamplesFile),
          .read = [](const std::string& path) {
            const StoredSamples read =
                ReadSamples(std::filesystem::path(path).parent_path(), kParameters);
            for (const StoredSamples::Sample& sample : read.samples)
              if (read.LogLikelihood(sample).array().isNaN().any())
                return "read samples of no likelihood";
            return "";
          }};
}

// Strips that follow F = k·strain to 10 %, in few samples.
Reader MakeRawDataReader() {
  json raw;
  for (const auto& [direction, stiffness] : {std::pair{"L", 9000.0}, {"W", 6000.0}, {"B", 500.0}}) {
    json way = json::array();
    for (int i = 0; i <= 60; ++i) {
      way.push_back(8.0 + 8.0 * i / 600);
      way.push_back(0.4 + stiffness * i / 600);
    }
    raw[direction] = {{"S2", {{"width", 5}, {"samplesTree", {way}}}}};
  }
  return {.name = "raw tensile data",
          .file = "denim.json",
          .content = json({{"schema", "1.1"}, {"raw_data", raw}}).dump(),
          .read = [](const std::string& path) {
            for (const LabMeasurement& strip : ReadLabMeasurements(path))
              for (const LabPoint& point : strip.points)
                if (!std::isfinite(point.set) || !std::isfinite(point.reading))
                  return "read points that are not finite";
            return "";
          }};
}

}  // namespace

std::vector<Reader> MakeResultReaders(const std::string& scratch) {
  return {MakePoolReader(scratch),
          MakeSpecimensReader(scratch),
          MakeSamplesReader(scratch),
          MakeRawDataReader(),
          {.name = "published speeds",
           .file = "speeds.json",
           .content = R"({"vertices": [297, 1104], "rows": [{"name": "a", "machine": "b",
                          "source": "c", "forward_s": [0.1, 0.2], "backward_s": [0.3, 0.4]}]})",
           .read = [](const std::string& path) {
             ReadPublishedSpeeds(path);
             return std::string();
           }}};
}

}  // namespace drape::attack
