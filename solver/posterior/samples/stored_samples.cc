// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/samples/stored_samples.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kSamplesFormat[] = "drapefit-samples";
constexpr int kVersion = 1;
constexpr int kMostDrawn = 1'000'000;

template <class Numbers>
Json List(const Numbers& numbers) {
  return std::vector<double>(numbers.begin(), numbers.end());
}

StoredSamples::Image ReadImage(const JsonInput& input) {
  input.ExpectKeys({"name", "sigma_m", "radius_m"});
  const double sigma = input.At("sigma_m").Number();
  if (!(sigma > 0.0)) input.At("sigma_m").Fail("a positive standard deviation");
  return {input.At("name").String(), sigma, input.At("radius_m").Vector()};
}

StoredSamples::Sample ReadSample(const JsonInput& input, int parameters, int angles, int images) {
  input.ExpectKeys({"log_factors", "log_prior", "log_density", "radius_m"});
  const JsonInput outlines = input.At("radius_m");
  outlines.ExpectArray(images);
  StoredSamples::Sample sample{input.At("log_factors").Vector(parameters),
                               input.At("log_prior").Number(), input.At("log_density").Number(),
                               Eigen::MatrixXd(angles, images)};
  for (int i = 0; i < images; ++i) sample.radius.col(i) = outlines.At(i).Vector(angles);
  return sample;
}

}  // namespace

Eigen::MatrixXd StoredSamples::LogLikelihood(const Sample& sample) const {
  Eigen::MatrixXd log_likelihood(angles(), images.size());
  for (Eigen::Index i = 0; i < log_likelihood.cols(); ++i) {
    const Image& image = images[i];
    const Eigen::ArrayXd z = (sample.radius.col(i) - image.radius) / image.sigma;
    log_likelihood.col(i) =
        -0.5 * z.square() - std::log(image.sigma * std::sqrt(2 * std::numbers::pi));
  }
  return log_likelihood;
}

// A line for each image and each sample.
void WriteSamples(const std::string& folder, const StoredSamples& samples) {
  const auto lines = [](std::string* text, const auto& items, const auto& make) {
    for (std::size_t i = 0; i < items.size(); ++i)
      *text += (i == 0 ? "\n  " : ",\n  ") + make(items[i]).dump();
  };
  std::string text = "{\"format\": \"" + std::string(kSamplesFormat) +
                     "\", \"version\": " + std::to_string(kVersion) +
                     ", \"drawn\": " + std::to_string(samples.drawn) + ",\n \"images\": [";
  lines(&text, samples.images, [](const StoredSamples::Image& image) {
    return Json{{"name", image.name}, {"sigma_m", image.sigma}, {"radius_m", List(image.radius)}};
  });
  text += "],\n \"samples\": [";
  lines(&text, samples.samples, [](const StoredSamples::Sample& sample) {
    Json outlines = Json::array();
    for (const auto& outline : sample.radius.colwise()) outlines.push_back(List(outline));
    return Json{{"log_factors", List(sample.log_factors)},
                {"log_prior", sample.log_prior},
                {"log_density", sample.log_density},
                {"radius_m", outlines}};
  });
  WriteFileAtomically(folder + "/" + kSamplesFile, text + "]}\n");
}

StoredSamples ReadSamples(const std::string& folder, int parameters) {
  const std::string path = folder + "/" + kSamplesFile;
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") || input.At("format").value() != kSamplesFormat)
    input.Fail(std::string("samples of a posterior, with \"format\": \"") + kSamplesFormat + '"');
  if (input.At("version").Integer() != kVersion) input.At("version").Fail(std::to_string(kVersion));
  input.ExpectKeys({"format", "version", "drawn", "images", "samples"});
  StoredSamples stored;
  stored.drawn = input.At("drawn").IntegerWithin(0, kMostDrawn);
  const JsonInput images = input.At("images"), samples = input.At("samples");
  images.ExpectArray();
  samples.ExpectArray();
  for (int i = 0; i < images.Size(); ++i) {
    stored.images.push_back(ReadImage(images.At(i)));
    if (stored.images[i].radius.size() != stored.angles())
      images.At(i).At("radius_m").Fail("as many radii as of the first image");
  }
  for (int s = 0; s < samples.Size(); ++s)
    stored.samples.push_back(ReadSample(samples.At(s), parameters, stored.angles(), images.Size()));
  return stored;
}

}  // namespace drape
