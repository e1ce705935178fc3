// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/garment/garment_tool.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "losses/image/image.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "solver/garment/body/body_spec.h"
#include "solver/garment/geometry_cache.h"
#include "solver/garment/pattern/pattern_io.h"
#include "solver/garment/render.h"
#include "solver/prediction/material_source.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kFrameRate = 25.0;  // [1/s]
constexpr StoredFormat kCheckpoint = {"drapefit-garment-run", 1};

// What all runs have in common.
struct Wardrobe {
  Pattern pattern;
  GarmentMesh garment;
  SewnGarment sewn;
  std::unique_ptr<Body> body;
  WearOptions wear;
};

Wardrobe MakeWardrobe(const GarmentOptions& options) {
  Wardrobe wardrobe;
  wardrobe.pattern = ReadPattern(options.garment);
  wardrobe.body = ParseBodySpec(options.body, wardrobe.pattern.arm_angle,
                                {.frames_per_second = options.body_fps});
  wardrobe.garment = MakeGarmentMesh(wardrobe.pattern, options.edge);
  wardrobe.sewn = Sew(wardrobe.garment, MakeLaw(options.law));
  wardrobe.wear = options.wear;
  wardrobe.wear.frames = static_cast<int>(std::lround(options.seconds * kFrameRate));
  const double frame = 1.0 / kFrameRate;
  wardrobe.wear.steps_per_frame =
      std::max(1, static_cast<int>(std::ceil(frame / options.wear.h - 1e-9)));
  wardrobe.wear.h = frame / wardrobe.wear.steps_per_frame;
  return wardrobe;
}

MaterialSource MakeMaterials(const GarmentOptions& options, const ClothModel& model) {
  if (options.material.empty() == options.posterior.empty())
    throw InputError("options 'material' and 'posterior'",
                     std::string("found ") + (options.material.empty() ? "neither" : "both") +
                         ", expected one of them");
  if (!options.posterior.empty())
    return ReadMaterialSource(options.posterior, model, static_cast<uint64_t>(options.seed));
  if (options.draws > 1)
    throw InputError("option 'draws'", "found more than one of a material, expected a posterior");
  const bool raises = options.min_relative_stiffness > 0.0;
  Material material =
      ReadMaterial(options.material, {raises ? NegativeEntries::kRaise : NegativeEntries::kReject});
  if (raises) RaiseSmallEntries(material.field, options.min_relative_stiffness);
  return [field = material.field](int) { return field; };
}

// The places of the unsewn vertices, which the OBJ file and the cache have.
Eigen::VectorXd Unsewn(const Wardrobe& wardrobe, const Eigen::VectorXd& x) {
  const std::vector<int>& vertex_of = wardrobe.sewn.vertex_of;
  Eigen::VectorXd all(3 * vertex_of.size());
  for (std::size_t i = 0; i < vertex_of.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = x.segment<3>(3 * vertex_of[i]);
  return all;
}

std::vector<std::array<int, 3>> Triangles(const Mesh& mesh) {
  std::vector<std::array<int, 3>> triangles;
  for (const Face& face : mesh.faces)
    triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
  return triangles;
}

// Where a run can go on: the state at a frame, and what has been measured up to it.
struct Checkpoint {
  int frame = -1;  // none yet
  State state;
  GarmentRun run;
};

nlohmann::json CheckpointJson(const Checkpoint& at, const std::string& settings) {
  const auto list = [](const Eigen::VectorXd& v) {
    return std::vector<double>(v.begin(), v.end());
  };
  return {{"settings", settings},
          {"frame", at.frame},
          {"x", list(at.state.x)},
          {"v", list(at.state.v)},
          {"body_intersections", at.run.body_intersections},
          {"newton_steps", at.run.newton_steps},
          {"smallest_gap", at.run.smallest_gap},
          {"largest_stretch", at.run.largest_stretch},
          {"seconds", at.run.seconds}};
}

Checkpoint ReadCheckpoint(const std::string& path, const std::string& settings, int dofs) {
  const nlohmann::json stored = ReadStoredJson(path, kCheckpoint);
  const JsonInput input(stored, path);
  if (input.At("settings").String() != settings)
    throw InputError(path,
                     "found another garment, body, material or setting, expected the "
                     "present one: run without --resume, or undo the change");
  constexpr int kMostCount = 1'000'000'000;
  Checkpoint at;
  at.frame = input.At("frame").IntegerWithin(0, kMostCount);
  at.state = {input.At("x").Vector(dofs), input.At("v").Vector(dofs)};
  at.run.body_intersections = input.At("body_intersections").IntegerWithin(0, kMostCount);
  at.run.newton_steps = input.At("newton_steps").IntegerWithin(0, kMostCount);
  at.run.smallest_gap = input.At("smallest_gap").Number();
  at.run.largest_stretch = input.At("largest_stretch").NotNegative();
  at.run.seconds = input.At("seconds").NotNegative();
  return at;
}

void AddFrame(const WornFrame& frame, GarmentRun* run) {
  run->smallest_gap =
      frame.index == 0 ? frame.smallest_gap : std::min(run->smallest_gap, frame.smallest_gap);
  run->largest_stretch = std::max(run->largest_stretch, frame.largest_stretch);
  run->body_intersections = std::max(run->body_intersections, frame.body_intersections);
  run->newton_steps += frame.newton_steps;
  run->seconds += frame.seconds;
}

// Eight frames from the caches, side by side.
void WriteSheet(const Wardrobe& wardrobe, const std::string& folder) {
  constexpr int kPictures = 8, kColumns = 4;
  const GeometryCache cloth = ReadGeometryCache(folder + "/garment.pc2"),
                      body = ReadGeometryCache(folder + "/body.pc2");
  const std::vector<std::array<int, 3>> triangles = Triangles(wardrobe.garment.mesh);
  const auto last = static_cast<int>(std::min(cloth.frames.size(), body.frames.size())) - 1;
  std::vector<RgbImage> pictures;
  for (int k = 0; k < kPictures; ++k) {
    const int frame = static_cast<int>(std::lround(last * (k + 1.0) / kPictures));
    const Eigen::VectorXd x = cloth.frames[frame].cast<double>(),
                          y = body.frames[frame].cast<double>();
    pictures.push_back(RenderSurfaces({{&wardrobe.body->triangles(), &y, kBodyColour, kBodyColour},
                                       {&triangles, &x, kClothColour, kClothBackColour}},
                                      {.azimuth = 30.0}));
  }
  WritePng(TilePictures(pictures, kColumns), folder + "/sheet.png");
}

void WriteBodyObj(const Body& body, const std::string& path) {
  const Eigen::VectorXd x = body.Positions(0.0);
  std::string text;
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    text += Format("v %.9g %.9g %.9g\n", x[i], x[i + 1], x[i + 2]);
  for (const auto& [a, b, c] : body.triangles())
    text += Format("f %d %d %d\n", a + 1, b + 1, c + 1);
  WriteFileAtomically(path, text);
}

double LowestPoint(const Eigen::VectorXd& x) {
  double lowest = x[2];
  for (Eigen::Index i = 2; i < x.size(); i += 3) lowest = std::min(lowest, x[i]);
  return lowest;
}

GarmentRun RunOne(const GarmentOptions& options, const Wardrobe& wardrobe,
                  const MaterialField& material, const std::string& settings,
                  const std::string& folder, const RunControl& control) {
  fs::create_directories(folder);
  const std::string stored = folder + "/checkpoint.json";
  Checkpoint at;
  if (options.resume && fs::exists(stored)) {
    at = ReadCheckpoint(stored, settings, wardrobe.sewn.model->num_dofs());
  } else {
    at.state = StartToWear(wardrobe.sewn, *wardrobe.body, wardrobe.wear);
    WriteObj(folder + "/garment.obj", wardrobe.garment.mesh, Unsewn(wardrobe, at.state.x));
    WriteBodyObj(*wardrobe.body, folder + "/body.obj");
  }
  GeometryCacheWriter cloth(folder + "/garment.pc2", wardrobe.garment.mesh.num_vertices(),
                            at.frame + 1);
  GeometryCacheWriter body(folder + "/body.pc2", wardrobe.body->num_vertices(), at.frame + 1);
  const WearResult result =
      Wear(wardrobe.sewn, material, *wardrobe.body, wardrobe.wear, at.state, std::max(0, at.frame),
           control, [&](const WornFrame& frame) {
             if (frame.index <= at.frame) return;
             cloth.Append(Unsewn(wardrobe, frame.cloth.x));
             body.Append(frame.body);
             AddFrame(frame, &at.run);
             at.frame = frame.index;
             at.state = frame.cloth;
             WriteStoredJson(stored, kCheckpoint, CheckpointJson(at, settings));
           });
  GarmentRun run = at.run;
  run.wear = result;
  run.wear.frames = at.frame + 1;
  run.vertices = wardrobe.sewn.model->mesh.num_vertices();
  run.faces = wardrobe.sewn.model->mesh.num_faces();
  run.hem_height = LowestPoint(at.state.x);
  run.self_intersections =
      static_cast<int>(FindSelfIntersections(wardrobe.sewn.triangles(), at.state.x, 1000).size());
  WriteSheet(wardrobe, folder);
  return run;
}

Json RunJson(const GarmentRun& run) {
  return {{"name", run.name},
          {"status", run.wear.status == WearStatus::kDone        ? "done"
                     : run.wear.status == WearStatus::kCancelled ? "cancelled"
                                                                 : "failed"},
          {"reason", run.wear.reason},
          {"frames", run.wear.frames},
          {"vertices", run.vertices},
          {"faces", run.faces},
          {"smallest_gap_m", run.smallest_gap},
          {"largest_stretch", run.largest_stretch},
          {"body_intersections", run.body_intersections},
          {"self_intersections", run.self_intersections},
          {"hem_height_m", run.hem_height},
          {"newton_steps", run.newton_steps},
          {"seconds", run.seconds}};
}

void WriteSummary(const GarmentOptions& options, const WearOptions& wear,
                  const GarmentResult& result, const std::string& path) {
  Json json = {{"tool", "drape_garment"},
               {"status", result.cancelled ? "cancelled" : "done"},
               {"garment", options.garment},
               {"body", options.body},
               {"material", options.posterior.empty() ? options.material : options.posterior},
               {"law", options.law},
               {"edge_m", options.edge},
               {"time_step", wear.h},
               {"frames_per_second", kFrameRate},
               {"thickness_m", wear.thickness},
               {"skin_offset_m", wear.skin_offset},
               {"friction", wear.friction},
               {"runs", Json::array()}};
  for (const GarmentRun& run : result.runs) json["runs"].push_back(RunJson(run));
  for (const auto& [name, version] : Versions()) json["versions"][name] = version;
  WriteFileAtomically(path, json.dump(2) + "\n");
}

}  // namespace

GarmentResult RunGarments(const GarmentOptions& options, const RunControl& control) {
  const Wardrobe wardrobe = MakeWardrobe(options);
  const MaterialSource materials = MakeMaterials(options, *wardrobe.sewn.model);
  const OutputFolder out(options.out, {"summary.json"});
  GarmentResult result;
  for (int draw = 0; draw < options.draws && !result.cancelled; ++draw) {
    const std::string name = options.draws > 1 ? Format("draw_%d", draw + 1) : std::string();
    const RunControl part{.cancel = control.cancel,
                          .progress = [&](double fraction, const std::string& note) {
                            control.Report((draw + fraction) / options.draws, name + " " + note);
                          }};
    // The frames of another length of the same run are the same.
    const std::string settings =
        Format("%s %s %s %d %s %g %g %g %g %g %g", options.garment.c_str(), options.body.c_str(),
               (options.material + options.posterior).c_str(), options.seed + draw,
               options.law.c_str(), options.edge, wardrobe.wear.h, wardrobe.wear.thickness,
               wardrobe.wear.skin_offset, wardrobe.wear.friction, options.min_relative_stiffness);
    GarmentRun run = RunOne(options, wardrobe, materials(draw), settings,
                            options.out + (name.empty() ? "" : "/" + name), part);
    run.name = name;
    result.cancelled = run.wear.status == WearStatus::kCancelled;
    result.runs.push_back(std::move(run));
  }
  WriteSummary(options, wardrobe.wear, result, out.Staged("summary.json"));
  out.Publish();
  return result;
}

std::string GarmentText(const GarmentResult& result) {
  std::string text =
      Format("%-10s %8s %7s %10s %11s %9s %9s %9s %9s\n", "", "vertices", "frames", "gap [mm]",
             "stretch [%]", "body hits", "self hits", "hem [cm]", "s/frame");
  for (const GarmentRun& run : result.runs)
    text += Format("%-10s %8d %7d %10.2f %11.1f %9d %9d %9.1f %9.2f\n", run.name.c_str(),
                   run.vertices, run.wear.frames, 1e3 * run.smallest_gap,
                   100.0 * run.largest_stretch, run.body_intersections, run.self_intersections,
                   100.0 * run.hem_height, run.seconds / std::max(1, run.wear.frames - 1));
  return text;
}

std::string GarmentFailure(const GarmentResult& result) {
  for (const GarmentRun& run : result.runs)
    if (run.wear.status == WearStatus::kFailed)
      return (run.name.empty() ? "" : run.name + ": ") + run.wear.reason +
             ", see the frames before";
  return "";
}

}  // namespace drape
