// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <filesystem>
#include <memory>

#include "losses/dataset/dataset.h"
#include "physics/util/atomic_file.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/forward/accuracy_table.h"
#include "solver/posterior/posterior_io.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tools/cli/provenance.h"
#include "tools/inputs/fit_options.h"
#include "tools/programs/simulate/simulate_tool.h"

namespace drape::attack {
namespace {

// posterior.json in the folder of the mutant; base.json is put beside it.
Reader MakePosteriorReader(const std::string& valid, const std::string& kind) {
  const std::string base = ReadText(valid + kind + "/base.json"),
                    spread = kind == "elements" ? "element_sd" : "covariance";
  return {.name = kind,
          .file = "posterior.json",
          .content = ReadText(valid + kind + "/posterior.json"),
          .read =
              [base](const std::string& path) {
                const std::string folder = std::filesystem::path(path).parent_path();
                if (!std::filesystem::exists(folder + "/base.json"))
                  WriteFileAtomically(folder + "/base.json", base);
                const StoredPosterior read = ReadPosterior(folder);
                return read.mean.allFinite() && read.covariance.allFinite()
                           ? std::string()
                           : "read a posterior that is not finite";
              },
          .impossible = {{"/mean/0", "1e9"},
                         {"/prior_sd/0", "-1"},
                         {"/prior_sd/0", "1e9"},
                         {"/" + spread + "/0", "-1"},
                         {"/" + spread, "[]"},
                         {kind == "elements" ? "/element_sd/0" : "/covariance/0/0", "1e12"},
                         {kind == "elements" ? "/element_sd/0" : "/covariance/0/0", "-1e-3"},
                         {kind == "elements" ? "/element_sd/1" : "/covariance/0/1", "-5"}}};
}

Reader MakeConfigReader() {
  return {.name = "config",
          .file = "config.json",
          .content = R"({"mesh": "disc:100", "steps": 2, "time_step": 0.1, "law": "smooth",
                         "fabric": "a.json", "dump_steps": [1, 2], "solve": "hybrid",
                         "camera_width": 256, "camera_scale": 719.5})",
          .read = [](const std::string& path) {
            SimulateOptions options;
            SimulateTable(options).ReadConfig(path);
            return std::string();
          }};
}

Reader MakeFitConfigReader() {
  return {.name = "fit config",
          .file = "fit.json",
          .content = R"({"images": ["a.png"], "fabric": "a.json", "iterations": [5, 8],
                         "initial_lifts": [0.5, 1.0], "threads": 2,
                         "field_basis": "modes", "sigma_px": 0.5, "density": 0.2})",
          .read = [](const std::string& path) {
            FitToolOptions options;
            FitTable(options).ReadConfig(path);
            return std::string();
          }};
}

// As far as a program gets before it reads anything else.
Reader MakeSummaryReader(const std::string& valid) {
  return {.name = "summary as config",
          .file = "summary.json",
          .content = MakeSummary(valid, valid),
          .read = [](const std::string& path) {
            SimulateOptions options;
            const auto run = SimulateTable(options).ReadConfig(path);
            if (run) CheckInputs(*run);
            return std::string();
          }};
}

Reader MakeSplitReader(const std::string& valid) {
  const auto dataset = std::make_shared<Dataset>(ReadDataset(valid + "set"));
  return {.name = "split",
          .file = "split.json",
          .content = ReadText(valid + "split.json"),
          .read = [dataset](const std::string& path) {
            ReadSplit(path, *dataset);
            return std::string();
          }};
}

}  // namespace

std::vector<Reader> MakeSettingReaders(const std::string& valid, const std::string&) {
  return {MakePosteriorReader(valid, "posterior"),
          MakePosteriorReader(valid, "elements"),
          MakeConfigReader(),
          MakeFitConfigReader(),
          MakeSummaryReader(valid),
          MakeSplitReader(valid),
          {.name = "accuracy",
           .file = "accuracy.json",
           .content = ReadText(valid + "accuracy.json"),
           .read =
               [](const std::string& path) {
                 ParseAccuracyTable(ReadWholeFile(path), path).Pick("fast", "");
                 return std::string();
               }},
          {.name = "lab test",
           .file = "tensile.json",
           .content = ReadText(valid + "tensile.json"),
           .read = [](const std::string& path) {
             ReadLabMeasurements(path);
             return std::string();
           }}};
}

}  // namespace drape::attack
