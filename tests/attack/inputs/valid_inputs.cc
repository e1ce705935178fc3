// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/valid_inputs.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "losses/dataset/dataset.h"
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/space/space_io.h"
#include "tests/losses/image/photograph.h"
#include "tools/cli/option_text.h"
#include "tools/cli/provenance.h"
#include "tools/programs/simulate/simulate_tool.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

std::string Valid(const std::string& name) { return kValid + name; }

void WriteText(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// A scene with an obstacle of each kind, and where its mesh is.
constexpr char kSolid[] = "SOLID";
constexpr char kContact[] = R"({
  "gravity": [0, 0, -9.81],
  "contact": {"thickness": 4e-4, "range": 5e-4, "stiffness": 100,
              "obstacles": [{"sphere": {"centre": [0, 0, -0.105], "radius": 0.1}},
                            {"plane": {"normal": [0, 0, 1], "offset": -0.3}},
                            {"capsule": {"from": [-0.2, 0.3, -0.2], "to": [0.2, 0.3, -0.2],
                                         "radius": 0.05}},
                            {"plate": {"top": [0.4, 0, -0.2], "radius": 0.09, "thickness": 0.05,
                                       "rim_radius": 0.001}},
                            {"mesh": {"file": "SOLID", "scale": 0.1,
                                      "translation": [0, 0.4, -0.2]}}]}
})";

// Two panels, in front of a mannequin and behind it, with an edge of each kind.
constexpr char kGarmentCode[] = R"({
  "pattern": {
    "panels": {
      "front": {"vertices": [[-30, 0], [30, 0], [30, 60], [-30, 60]],
                "edges": [{"endpoints": [0, 1],
                           "curvature": {"type": "quadratic", "params": [[0.5, -0.1]]}},
                          {"endpoints": [1, 2]},
                          {"endpoints": [2, 3],
                           "curvature": {"type": "cubic", "params": [[0.3, 0.05], [0.7, 0.05]]}},
                          {"endpoints": [3, 0]}],
                "translation": [0, 85, 35], "rotation": [0, 0, 0]},
      "back": {"vertices": [[-30, 0], [30, 0], [30, 60], [-30, 60]],
               "edges": [{"endpoints": [0, 1],
                          "curvature": {"type": "circle", "params": [60, 0, 0]}},
                         {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}],
               "translation": [0, 85, -35], "rotation": [0, 180, 0]}},
    "stitches": [[{"panel": "front", "edge": 1}, {"panel": "back", "edge": 3}],
                 [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 1}, "right_wrong"]],
    "panel_order": ["front", "back"]},
  "parameters": {}, "parameter_order": [],
  "properties": {"curvature_coords": "relative", "units_in_meter": 100}})";

// Four samples of round drapes of one fabric, captures 1 to 4.
void WriteDataset(const std::string& folder) {
  const std::string silhouettes = folder + "/data/Fabric 3/silhouettes/";
  fs::create_directories(silhouettes);
  for (int sample = 1; sample <= 4; ++sample) {
    for (int capture = 1; capture <= 4; ++capture) {
      const double radius = 0.095 + 0.005 * sample + (capture > 2 ? 0.002 : 0.0);
      WritePng(ObserveDisc(radius, Camera(), {}).image, silhouettes + "Sample_" +
                                                            std::to_string(sample) + "_Capture_" +
                                                            std::to_string(capture) + ".png");
    }
  }
}

// Four fabrics that differ by the stretch and by the bend, and their space.
void WritePosteriors(const std::string& folder, const Material& material) {
  StoredPosterior posterior;
  posterior.fabric = ParameterTying::kScales;
  posterior.specimens = 1;
  posterior.base = material.field;
  const int size = posterior.size();
  posterior.prior_sd = Eigen::VectorXd::Constant(size, 1.0);
  posterior.mean = Eigen::VectorXd::Zero(size);
  posterior.covariance = 0.01 * Eigen::MatrixXd::Identity(size, size);
  std::vector<std::string> fabrics;
  for (const Eigen::Vector2d& mean : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.3, 0.3),
                                      Eigen::Vector2d(-0.2, 0.9), Eigen::Vector2d(0.7, -0.4)}) {
    const std::string number = fabrics.empty() ? "" : "_" + std::to_string(fabrics.size() + 1);
    fabrics.push_back(folder + "/posterior" + number);
    posterior.mean.head<2>() = mean;
    fs::create_directories(fabrics.back());
    WritePosterior(fabrics.back(), posterior, "attack");
  }
  WriteMaterialSpace(folder, BuildMaterialSpace(ReadFabricBeliefs(fabrics, SpaceBy::kDrape), {}),
                     {});
  posterior.kind = PosteriorKind::kElements;
  posterior.fabric = ParameterTying::kEntries;
  posterior.specimens = 0;
  posterior.prior_sd = Eigen::VectorXd::Constant(posterior.size(), 1.0);
  posterior.mean = Eigen::VectorXd::Zero(posterior.size());
  posterior.covariance = Eigen::MatrixXd();
  posterior.element_sd = Eigen::VectorXd::Constant(posterior.size(), 0.1);
  fs::create_directories(folder + "/elements");
  WritePosterior(folder + "/elements", posterior, "attack");
}

// One table repeated for each face and hinge.
Material FieldOn(const Mesh& mesh, Material material) {
  material.field.stretch.assign(static_cast<std::size_t>(mesh.num_faces()),
                                material.field.stretch.front());
  material.field.bend.assign(static_cast<std::size_t>(mesh.num_hinges()),
                             material.field.bend.front());
  return material;
}

const std::map<std::string, std::vector<std::string>>& Commands() {
  const std::string material = "--fabric=" + Valid("wool.json");
  const std::string start = "--start=" + Valid("waves.json");
  const std::vector<std::string> fit = {"--mesh=disc:100",
                                        "--coarse_mesh=disc:100",
                                        "--candidates_per_round=1",
                                        "--iterations=1",
                                        "--initial_stretch=1",
                                        "--initial_bend=1",
                                        "--initial_lifts=1",
                                        "--initial_steps=10",
                                        "--settle_steps=5",
                                        "--num_parameters=2",
                                        "--threads=1",
                                        "--out=out"};
  std::vector<std::string> compare = {"--data=" + Valid("set"),
                                      "--data_fabric=3",
                                      "--models=homogeneous",
                                      "--seeds=1",
                                      "--train=2",
                                      "--train_captures=1",
                                      "--face=up",
                                      "--draws=4",
                                      "--calibrate=false",
                                      "--fabric=" + Valid("wool.json")};
  compare.insert(compare.end(), fit.begin(), fit.end());
  std::vector<std::string> fit_image = {"--images=" + Valid("drape.png"), material};
  fit_image.insert(fit_image.end(), fit.begin(), fit.end());
  static const std::map<std::string, std::vector<std::string>> kCommands = {
      {"drape_simulate",
       {"--mesh=disc:100", material, start, "--steps=2", "--time_step=0.1", "--out=out"}},
      {"drape_fit", fit_image},
      {"drape_metrics", {Valid("drape.png"), "--out=out/metrics.json"}},
      {"drape_equilibria",
       {"--mesh=disc:100", material, "--samples=2", "--steps=10", "--threads=1", "--out=out"}},
      {"drape_predict",
       {"--mesh=disc:100", material, "--draws=2", "--steps=10", "--threads=1", "--out=out"}},
      {"drape_check", {"--mesh=disc:100", material, "--steps=2"}},
      {"drape_compare", compare},
      {"drape_bench",
       {material, start, "--mesh=disc:120", "--solve=hybrid", "--time_step=0.2",
        "--coarse_mesh=disc:120", "--reference=disc:140,disc:160",
        "--reference_relax_mesh=disc:120", "--branch_mm=50", "--run_seconds=0", "--repeats=1",
        "--out=out"}},
      {"drape_speed",
       {material, "--mesh=disc:100", "--steps=2", "--repeats=1", "--threads=1", "--out=out"}},
      {"drape_stability",
       {"--mesh=disc:100", material, start, "--maps=step time_step=0.1/0.5 bend=1/2",
        "--damping_time_step=0.1", "--duration=0.5", "--threads=1", "--out=out"}},
      {"drape_gradients",
       {material, "--mesh=disc:100", "--horizons=1,3", "--time_steps=0.1", "--fold_starts=0",
        "--out=out"}},
      {"drape_space",
       {"--posteriors=" + Valid("posterior") + "," + Valid("posterior_2"),
        "--new=" + Valid("posterior"), "--out=out"}},
      {"drape_garment",
       {"--garment=" + Valid("skirt.json"), "--body=mannequin:stand", material, "--edge=0.09",
        "--seconds=0.04", "--out=out"}},
      {"drape_compare_optimisers",
       {"--twins=" + Valid("wool.json"), "--fabric=" + Valid("shirt.json"), "--twin_mesh=disc:120",
        "--mesh=disc:100", "--coarse_mesh=disc:100", "--num_parameters=2", "--methods=lm",
        "--budget=2", "--threads=1", "--out=out"}}};
  return kCommands;
}

}  // namespace

void MakeValidInputs(const std::string& work, const std::string& sources) {
  const std::string folder = work + "/valid/", configs = sources + "/configs/";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const auto copy = [&](const std::string& from, const std::string& to) {
    fs::copy_file(configs + from, folder + to);
  };
  copy("fabrics/synthetic_wool.json", "wool.json");
  copy("fabrics/synthetic_shirt.json", "shirt.json");
  copy("starts/six_waves.json", "waves.json");
  copy("scenes/cusick.json", "scene.json");
  copy("scenes/uniaxial.json", "pull.json");
  copy("garments/circle_skirt.json", "skirt.json");
  WriteText(folder + "garmentcode.json", kGarmentCode);
  WriteText(folder + "body.obj", MakeBodyObj(0.0));
  WriteText(folder + "contact.json",
            std::string(kContact).replace(std::string(kContact).find(kSolid), sizeof(kSolid) - 1,
                                          fs::absolute(folder + "body.obj").string()));
  copy("lab_tests/wool_tensile_warp.json", "tensile.json");
  copy("lab_tests/wool_cantilever_warp.json", "cantilever.json");
  copy("accuracy.json", "accuracy.json");
  const Mesh mesh = MakeDisc({.target_vertices = 100});
  WriteObj(folder + "disc.obj", mesh, mesh.rest_x);
  WriteState(folder + "state.json", {mesh.rest_x, 0 * mesh.rest_x});
  const Material wool = ReadMaterial(folder + "wool.json");
  WriteMaterialField(folder + "field.json", FieldOn(mesh, wool), mesh);
  WriteText(folder + "published.json",
            R"({"density": 0.2, "c11": [150, 140, 130, 120, 110, 100], "c12": [9, 9, 9, 9, 9, 9],
                "c22": [120, 110, 100, 90, 80, 70], "c33": [20, 20, 20, 20, 20, 20],
                "bending": [[3e-5, 3e-5, 3e-5, 3e-5, 3e-5], [4e-5, 4e-5, 4e-5, 4e-5, 4e-5],
                            [5e-5, 5e-5, 5e-5, 5e-5, 5e-5]]})");
  WritePng(StarSilhouette(Camera()), folder + "drape.png");
  WritePng(StarSilhouette(PhotographCamera()), folder + "photograph.png");
  WriteDataset(folder + "set");
  const Dataset dataset = ReadDataset(folder + "set");
  WriteSplit(folder + "split.json", SplitBySample(dataset.captures, 2, 1));
  WritePosteriors(folder, wool);
  WriteText(folder + "summary.json", MakeSummary(folder, kValid));
  WriteText(folder + "config.json", R"({"steps": 2, "time_step": 0.1, "mesh": "disc:100"})");
}

std::string MakeSummary(const std::string& valid, const std::string& seen) {
  SimulateOptions options;
  const OptionTable table = SimulateTable(options);
  for (const auto& [key, text] :
       {std::pair{"mesh", "disc:100"}, {"steps", "2"}, {"time_step", "0.1"}})
    table.Set(key, text, "");
  table.Set("fabric", seen + "wool.json", "");
  nlohmann::json values;
  for (const Option& option : table.options) values[option.key] = ValueJson(option);
  const InputFile wool = DescribeInput(seen + "wool.json", ReadWholeFile(valid + "wool.json"));
  const nlohmann::json input = {
      {"path", wool.path}, {"bytes", wool.bytes}, {"sha256", wool.sha256}};
  return nlohmann::json({{"outcome", "done"},
                         {"provenance",
                          {{"program", table.tool},
                           {"working_directory", "/"},
                           {"options", values},
                           {"given", *table.given},
                           {"inputs", nlohmann::json::array({input})}}}})
      .dump();
}

std::string MakeBodyObj(double x) {
  constexpr int kRing = 4;
  std::string text = Format("v %g 0 0\nv %g 0 1.8\n", x, x);
  for (int k = 0; k < kRing; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRing;
    text += Format("v %.6f %.6f 1\n", x + 0.2 * std::cos(angle), 0.2 * std::sin(angle));
  }
  for (int k = 0; k < kRing; ++k) {
    const int a = 3 + k, b = 3 + (k + 1) % kRing;
    text += Format("f 1 %d %d\nf 2 %d %d\n", b, a, a, b);
  }
  return text;
}

const std::vector<std::string>& ProgramNames() {
  static const std::vector<std::string> kNames = {"drape_simulate",
                                                  "drape_fit",
                                                  "drape_metrics",
                                                  "drape_equilibria",
                                                  "drape_predict",
                                                  "drape_check",
                                                  "drape_compare",
                                                  "drape_bench",
                                                  "drape_speed",
                                                  "drape_stability",
                                                  "drape_gradients",
                                                  "drape_space",
                                                  "drape_compare_optimisers",
                                                  "drape_garment"};
  return kNames;
}

std::vector<std::string> QuickCommand(const std::string& program) {
  std::vector<std::string> command = {program};
  const std::vector<std::string>& options = Commands().at(program);
  command.insert(command.end(), options.begin(), options.end());
  return command;
}

std::vector<std::string> QuickCommand(const std::string& program,
                                      const std::vector<std::string>& more) {
  std::vector<std::string> command = QuickCommand(program);
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

std::vector<std::string> WithoutOption(std::vector<std::string> command, const std::string& flag) {
  std::erase_if(command, [&](const std::string& word) { return word.rfind(flag + "=", 0) == 0; });
  return command;
}

}  // namespace drape::attack
