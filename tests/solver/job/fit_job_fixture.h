// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/job/fit_job.h"
#include "tests/losses/temp_folder.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {

// A job of one image, made with four times the bending stiffness of its start tables.
class FitJobTest : public testing::Test {
 protected:
  FitJobTest() {
    WriteStart(TestMaterial());
    data_.material = folder_ / "start.json";
    data_.density = TestMaterial().density;
    spec_.simpler_models = false;
    spec_.mesh = "disc:150";
    spec_.coarse_mesh = "disc:100";
    files_.out = folder_.path();
    files_.checkpoint = folder_ / "checkpoint.json";
    files_.log = folder_ / "fit.log";
    spec_.stages.grid.stretch = {1.0};
    spec_.stages.grid.bend = {4.0};
    spec_.stages.grid.lifts = {1.0};
    spec_.stages.candidates_per_round = {1};
    spec_.stages.iterations = {2};
    spec_.observation.angles = 72;
    spec_.observation.warp = "up";
    AddImage("a.png", DrapeImage());
  }
  void WriteStart(const MaterialField& field) const {
    WriteMaterial(folder_ / "start.json", {.name = "start",
                                           .field = field,
                                           .source_convention = "arcsim",
                                           .source = "",
                                           .warnings = {}});
  }
  static const GrayImage& DrapeImage() {
    static const GrayImage image = [] {
      const auto backend = SmoothDisc(150);
      const MaterialField reference = Scaled(TestMaterial(), 1.0, 4.0);
      const State drape = Settled(*backend, reference, RandomStart(backend->model(), 1));
      return MakeObservation(backend->model().mesh, drape, 72, "reference").image;
    }();
    return image;
  }
  void AddImage(const std::string& name, const GrayImage& image) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    WritePng(image, folder_ / name);
    data_.images.push_back(folder_ / name);
  }
  void UseBdp() {
    spec_.model = FitModel::kBdp;
    spec_.stages.prior_sigma = 0.3;
    spec_.posterior.draws = 2;
    spec_.posterior.iterations = 3;
    spec_.posterior.elbo_samples = 25;
  }
  static RunControl CancelInRoundOne(std::atomic<bool>* cancel) {
    return {cancel, [cancel](double, const std::string& note) {
              if (note.starts_with("round 1")) *cancel = true;
            }};
  }
  std::string ComputeError() const {
    try {
      RunFitJob(spec_, data_, files_, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  nlohmann::json Summary() const { return ReadJsonFile(folder_ / "summary.json"); }
  bool Exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  const TempFolder folder_;
  FitSpec spec_;
  FitData data_;
  FitFiles files_;
};

}  // namespace drape::test
