// SPDX-License-Identifier: Apache-2.0
// Results that other programs read: pools of drapes and what is learned from them, samples of a
// posterior, outlines, figures of others, raw data of a tensile device.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/metrics/laboratory_drape.h"
#include "physics/util/stored/stored_json.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/studies/bench/speed_study.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

using nlohmann::json;

// The reader of a file with a checksum that is made right again for each mutant.
Reader MakeSealedReader(const std::string& name, const std::string& path,
                        std::vector<std::pair<std::string, std::string>> impossible,
                        std::function<std::string(const std::string&)> read) {
  json members = json::parse(ReadText(path));
  const std::string format = members.at("format");
  const int version = members.at("version");
  for (const char* key : {"format", "version", "checksum"}) members.erase(key);
  return {.name = name,
          .file = std::filesystem::path(path).filename(),
          .content = members.dump(),
          .read = std::move(read),
          .seal =
              [=](const json& changed) {
                return StoredJsonText({format.c_str(), version}, changed);
              },
          .impossible = std::move(impossible)};
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
    pool.drapes.push_back({MiddleOfRanges().mean[0],
                           {FeatureVector(0.3 + 0.01 * i, 6, 1e-6, 2e-6, 1e-6, 1e-6),
                            Eigen::VectorXd::Constant(kPoolAngles, 0.11)}});
  WritePool(path, pool);
  const std::vector<std::pair<std::string, std::string>> impossible = {
      {"/drapes/0/radius_um/0", "0"},
      {"/drapes/0/radius_um/0", "-110000"},
      {"/drapes/1/radius_um/3", "9000000"},
      {"/drapes/0/features/0", "50"},
      {"/drapes/0/features/0", "-2"},
      {"/drapes/1/features/1", "-3"},
      {"/drapes/1/features/1", "2.5"},
      {"/drapes/0/features/2", "-1e-6"},
      {"/drapes/0/numbers/0", "1e6"},
      {"/drapes/1/numbers/7", "-1e6"},
      {"/drapes/0/numbers", "null"},
      {"/simulated", "1"},
      {"/seed", "-1"},
      {"/mesh", "3"}};
  return MakeSealedReader("pool", path, impossible, [](const std::string& from) {
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
  const std::vector<std::pair<std::string, std::string>> impossible = {
      {"/best/log_bending_length/deviation", "0"},
      {"/best/log_bending_length/deviation", "-0.1"},
      {"/best/log_bending_length/mean_up", "1e9"},
      {"/resampled/0/start_slope/mean", "-1e9"},
      {"/effective_drapes", "-5"},
      {"/effective_drapes", "101"},
      {"/drapes", "0"},
      {"/drapes", "-3"}};
  return MakeSealedReader("specimens", path, impossible, [](const std::string& from) {
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
          .read =
              [](const std::string& path) {
                const StoredSamples read =
                    ReadSamples(std::filesystem::path(path).parent_path(), kParameters);
                for (const StoredSamples::Sample& sample : read.samples)
                  if (read.LogLikelihood(sample).array().isNaN().any())
                    return "read samples of no likelihood";
                return "";
              },
          .impossible = {{"/drawn", "-1"},
                         {"/images/0/sigma_m", "0"},
                         {"/images/0/sigma_m", "-0.001"},
                         {"/images/0/radius_m/0", "0"},
                         {"/images/0/radius_m/1", "-0.1"},
                         {"/images/0/radius_m/2", "50"},
                         {"/samples/0/radius_m/0/1", "-0.1"},
                         {"/samples/0/log_factors/0", "1e6"},
                         {"/samples/0/log_prior", "null"}}};
}

// Strips that follow F = k·strain to 10 %, in few samples.
json RawData() {
  json raw;
  for (const auto& [direction, stiffness] : {std::pair{"L", 9000.0}, {"W", 6000.0}, {"B", 500.0}}) {
    json way = json::array();
    for (int i = 0; i <= 60; ++i) {
      way.push_back(8.0 + 8.0 * i / 600);
      way.push_back(0.4 + stiffness * i / 600);
    }
    raw[direction] = {{"S2", {{"width", 5}, {"samplesTree", {way}}}}};
  }
  raw["M"] = 180;
  return {{"schema", "1.1"}, {"raw_data", raw}};
}

std::string ReadStrips(const std::string& path) {
  for (const LabMeasurement& strip : ReadLabMeasurements(path)) {
    if (!(strip.density >= 0)) return "read a density that is no number";
    for (const LabPoint& point : strip.points)
      if (!std::isfinite(point.set) || !std::isfinite(point.reading))
        return "read points that are not finite";
  }
  return "";
}

Reader MakeRawDataReader() {
  return {.name = "raw tensile data",
          .file = "denim.json",
          .content = RawData().dump(),
          .read = ReadStrips};
}

// A fabric with its weight, and the file of raw data that is put beside it.
Reader MakeU3mReader() {
  const json physics = {{"devices", {{"fab", "denim.fab"}}}, {"weight", 190}};
  return {.name = "u3m",
          .file = "denim.u3m",
          .content = json({{"schema", "1.1"}, {"material", {{"physics", physics}}}}).dump(),
          .read = [](const std::string& path) {
            const auto raw = std::filesystem::path(path).parent_path() / "denim.fab";
            if (!std::filesystem::exists(raw)) test::WriteQuickly(raw, RawData().dump());
            return ReadStrips(path);
          }};
}

// The laboratory's numbers of a drape, in the summary of a fit.
Reader MakeSheetReader() {
  const json row = {{"key", "dc"},       {"name", "drape coefficient"},
                    {"value", 35.6},     {"low", 35.2},
                    {"high", nullptr},   {"unit", "%"},
                    {"source", "image"}, {"standard", "ISO 9073-9"}};
  const json sheet = {{"title", "drape"}, {"rows", {row}}};
  return {.name = "laboratory sheet",
          .file = "summary.json",
          .content = json({{"laboratory", {{"drape", sheet}}}}).dump(),
          .read = [](const std::string& path) {
            const auto read = ReadSheet(std::filesystem::path(path).parent_path(), "drape");
            if (read) SheetText(*read, {});
            return std::string();
          }};
}

}  // namespace

std::vector<Reader> MakeResultReaders(const std::string& scratch) {
  return {MakePoolReader(scratch),
          MakeSpecimensReader(scratch),
          MakeSamplesReader(scratch),
          MakeRawDataReader(),
          MakeU3mReader(),
          MakeSheetReader(),
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
