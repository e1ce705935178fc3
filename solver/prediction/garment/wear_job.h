// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "solver/prediction/garment/wear.h"

namespace drape {

// Positions over time as a point cache PC2, which Blender and others read beside the OBJ of the
// first frame: a header of 32 bytes ("POINTCACHE2" and a NUL; int32 version 1 and number of points;
// float32 start and sample rate in frames, 0 and 1; int32 number of frames), then float32 x y z of
// each point of each frame, all little-endian [m].

// Writes such a file frame by frame. After each frame the file is complete: the frame is on the
// disk before the header counts it, so that an interrupted run leaves a readable file.
class GeometryCacheWriter {
 public:
  // Begins a new file in place of any other, or, with kept_frames > 0, keeps the first frames of
  // the file that an interrupted run has left and removes the others. Throws IoError when the file
  // cannot be written or is a link, and InputError when it has not so many frames of so many
  // points.
  GeometryCacheWriter(std::string path, int num_points, int kept_frames = 0);
  GeometryCacheWriter(const GeometryCacheWriter&) = delete;
  GeometryCacheWriter& operator=(const GeometryCacheWriter&) = delete;
  ~GeometryCacheWriter();

  // x: [m], shape [3V], CHECKed. Throws IoError when the disk is full.
  void Append(const Eigen::VectorXd& x);
  int num_frames() const { return num_frames_; }

 private:
  void WriteAt(int64_t offset, const void* data, size_t size);
  void WriteHeader();

  std::string path_;
  int num_points_;
  int num_frames_;
  int descriptor_;
};

// A garment on a moving body as a user asks for it: what is worn, how it moves, and how often.
struct WearSpec {
  std::string garment;                  // ReadPattern
  std::string body = "mannequin:walk";  // ParseBody
  BodyFiles body_files = {};            // of a body of files
  double edge = 0.012;                  // of the triangles [m]
  int draws = 1;                        // materials, or starts of one material
  int seed = 1;                         // of the starts
  double seconds = 4.0;                 // simulated
  std::string law = "smooth";           // MakeLaw
  WearOptions wear = {};                // its time step is the largest, its frames are not used
};

template <MutableOrConst<BodyFiles> Files, class Visitor>
void VisitFields(Files& files, Visitor&& visit) {
  auto& [frames_per_second, up, front, scale, offset, grow] = files;
  visit(frames_per_second, Field{.key = "body_fps",
                                 .doc = "files of a body of your own for each second",
                                 .unit = "1/s",
                                 .range = {.least = 1, .most = 1000}});
  const std::vector<std::string> axes = {"auto", "x", "-x", "y", "-y", "z", "-z"};
  visit(up, Field{.key = "body_up",
                  .doc = "axis of those files that points up; auto: guessed and reported",
                  .choices = axes});
  visit(front, Field{.key = "body_front",
                     .doc = "axis to which the body faces; auto: guessed by the toes",
                     .choices = axes});
  visit(scale, Field{.key = "body_scale",
                     .doc = "their unit of length, such as 0.01; 0: guessed",
                     .unit = "m",
                     .range = {.least = 0, .most = 1}});
  visit(offset, Field{.key = "body_offset",
                      .doc = "moves the body, z up, by x,y,z; not given: its feet to "
                             "z = 0, its hips to x = y = 0",
                      .unit = "m",
                      .range = {.least = -1000, .most = 1000}});
  visit(grow,
        Field{.key = "body_grow", .doc = "the body grows to its size in the first half second"});
}

template <MutableOrConst<WearSpec> Spec, class Visitor>
void VisitFields(Spec& spec, Visitor&& visit) {
  auto& [garment, body, body_files, edge, draws, seed, seconds, law, wear] = spec;
  visit(garment, Field{.key = "garment",
                       .doc = "sewing pattern: configs/garments/circle_skirt.json, another of that "
                              "format, or a specification of GarmentCode",
                       .is_path = true});
  visit(body, Field{.key = "body",
                    .doc = "mannequin:stand, mannequin:walk, mannequin:turn, mannequin:jump, or "
                           "a body of your own (OBJ, STL, PLY): a file, or DIR/body_%04d.obj",
                    .is_path = true,
                    .words = {"mannequin:"}});
  VisitFields(body_files, visit);
  visit(edge, Field{.key = "edge",
                    .doc = "length of the triangles' edges",
                    .unit = "m",
                    .range = {.least = 0.002, .most = 0.1}});
  visit(draws, Field{.key = "draws",
                     .doc = "samples of the posterior, one garment each; of a material, starts "
                            "that differ by --start_noise",
                     .range = {.least = 1, .most = 1000},
                     .in_key = false});
  visit(seed, Field{.key = "seed",
                    .doc = "random seed of the samples and of the starts",
                    .range = {.least = 0, .most = 1000000000}});
  visit(seconds, Field{.key = "seconds",
                       .doc = "simulated time, including 0.5 s in which the body grows, and 0.75 s "
                              "in which the mannequin lowers its arms",
                       .unit = "s",
                       .range = {.least = 0.04, .most = 600},
                       .in_key = false});
  visit(law, Field{.key = "law", .is_option = false});
  VisitFields(wear, visit);
}

// How a run is made, which leaves its results as they are.
struct WearRunOptions {
  int threads = 1;               // draws at once
  int step_threads = 1;          // of a time step, where there is one draw
  std::string backend = "auto";  // MakeStepLinearSolver
  std::string out = {};          // folder of the results; empty: nothing is written
  bool resume = false;           // from the checkpoints in `out`
  // Called after each frame.
  std::function<void(const SewnGarment&, const Body&, const WornFrame&)> on_frame = {};
};

// One garment on the body, with one material.
struct GarmentRun {
  std::string name;  // "draw_3"; empty where there is one draw
  WearResult wear;
  int vertices = 0, faces = 0;
  double smallest_gap = 0.0, largest_stretch = 0.0, hem_height = 0.0;  // [m]; of the last frame
  int body_intersections = 0, self_intersections = 0;                  // the most of a frame
  int newton_steps = 0;
  double seconds = 0.0;  // of all frames
};
struct GarmentResult {
  std::vector<GarmentRun> runs = {};
  bool cancelled = false;
  WearSpec spec = {};       // with the time step and the frames of the runs
  std::string device = {};  // of the factorisations, in words
  int body_files = 0;       // Body::num_files
  double body_rests_after = 0.0;
};

// The materials of the draws 0, 1, 2, … for a garment of this model.
using MaterialMaker =
    std::function<std::function<MaterialField(int draw)>(const ClothModel& model)>;

// Dresses the body in a garment. Writes garment.obj, garment.pc2, body.obj, body.pc2 and
// checkpoint.json, of each draw in a folder of its own where there are several. A cancelled run can
// be resumed: a checkpoint knows the run by the fields of its spec, by the material and by the
// SHA-256 of each file that was read, not by a path. Throws InputError and IoError.
GarmentResult RunWearJob(const WearSpec& spec, const WearRunOptions& options,
                         const MaterialMaker& make_materials, const RunControl& control);

// The fields of the spec, the device and the runs.
nlohmann::ordered_json WearSummary(const GarmentResult& result);

}  // namespace drape
