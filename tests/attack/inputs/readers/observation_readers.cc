// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <string>

#include "losses/readout/observation_files.h"
#include "solver/fit/observed/experiment_file.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

// 3 × 2 counts of 16 bits, as PIL writes them.
constexpr unsigned char kDepthMap[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52,
    0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x02, 0x10, 0x00, 0x00, 0x00, 0x00, 0xe8, 0x8f, 0xe5,
    0x85, 0x00, 0x00, 0x00, 0x16, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x64, 0x60, 0x60, 0xda,
    0xc3, 0xc0, 0xc8, 0xc0, 0xdc, 0xf2, 0xff, 0x3f, 0x03, 0x23, 0x00, 0x11, 0x32, 0x03, 0x47, 0x28,
    0x1c, 0x91, 0xb7, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

Reader MakeMarkerReader(const std::string& name, const std::string& content) {
  return {.name = name,
          .file = "markers.csv",
          .content = content,
          .read =
              [](const std::string& path) {
                const MeasuredMarkers read = ReadMarkers(path);
                const Eigen::Index count =
                    read.material.cols() + static_cast<Eigen::Index>(read.vertices.size());
                return read.x.allFinite() && read.material.allFinite() && read.x.size() == 3 * count
                           ? std::string()
                           : "read markers that are not finite or not of one number";
              },
          .is_json = false};
}

Reader MakeCloudReader(const std::string& name, const std::string& file,
                       const std::string& content) {
  return {.name = name,
          .file = file,
          .content = content,
          .read =
              [](const std::string& path) {
                return ReadPointCloud(path).allFinite() ? std::string()
                                                        : "read points that are not finite";
              },
          .is_json = false};
}

Reader MakeExperimentReader() {
  const std::string motion = "/experiments/0/motion", first = "/experiments/0/measurements/0";
  return {.name = "experiment",
          .file = "experiment.json",
          .content = R"({"density": 0.15, "fit": ["mass_damping"],
              "experiments": [{"name": "swing", "mesh": "strip:0.2x0.05x4",
                "scene": {"gravity": [0, 0, -9.81],
                          "handles": {"vertices": [0, 5], "stiffness": 1000}},
                "motion": {"steps": 4, "time_step": 0.02, "mass_damping": 1, "wind": [1, 0, 0]},
                "measurements": [{"angle": 30, "tip": [4], "clamp": [0, 0, 0],
                                  "along": [1, 0, 0], "sigma": 1, "step": 4,
                                  "loss": {"huber": 2}}]}]})",
          .read =
              [](const std::string& path) {
                const ExperimentFile read = ReadExperiments(path);
                return read.experiments.empty() ? "read no experiment" : std::string();
              },
          .impossible = {{first + "/sigma", "0"},
                         {first + "/sigma", "-1"},
                         {first + "/step", "5"},
                         {first + "/angle", "200"},
                         {first + "/along", "[0, 0, 1]"},
                         {motion + "/steps", "0"},
                         {motion + "/time_step", "0"},
                         {motion + "/mass_damping", "0"},
                         {motion + "/mass_damping", "-1"},
                         {"/density", "120"}}};
}

}  // namespace

std::vector<Reader> MakeObservationReaders() {
  const std::string depth_map(reinterpret_cast<const char*>(kDepthMap), sizeof kDepthMap);
  return {
      MakeExperimentReader(),
      MakeMarkerReader("markers", "weft_m,warp_m,x_m,y_m,z_m\n0,0.1,0.1,0.2,0\n0.1,0,0.3,0,-0.1\n"),
      MakeMarkerReader("vertex markers", "vertex;x_m;y_m;z_m\n0;0,1;0,2;0\n3;0,3;0;-0,1\n"),
      MakeCloudReader("cloud", "cloud.csv", "x,y,z\n0,0.1,0.2\n0.1,0.2,0\n0,0,-0.1\n"),
      MakeCloudReader("cloud.ply", "cloud.ply",
                      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float "
                      "y\nproperty float z\nend_header\n0 0 0\n1 0 0\n"),
      {.name = "depth map",
       .file = "depth.png",
       .content = depth_map,
       .read =
           [](const std::string& path) {
             const DepthMap read = ReadDepthMap(path, 1e-3);
             return read.depth.size() == size_t(read.width) * size_t(read.height)
                        ? std::string()
                        : "read a map of another size than its pixels";
           },
       .is_json = false}};
}

}  // namespace drape::attack
