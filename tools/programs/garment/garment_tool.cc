// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/garment/garment_tool.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/image/image.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/body_spec.h"
#include "solver/prediction/garment/geometry_cache.h"
#include "solver/prediction/garment/pattern/pattern.h"
#include "solver/prediction/garment/render.h"
#include "solver/prediction/material_source.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kFrameRate = 25.0;  // [1/s]
constexpr StoredFormat kCheckpoint = {"drapefit-garment-run", 2};

// What all runs have in common.
struct Wardrobe {
  Pattern pattern;
  GarmentMesh garment;
  SewnGarment sewn;
  std::unique_ptr<Body> body;
  WearOptions wear;
  std::string device;  // of factorisations, in words
};

Wardrobe MakeWardrobe(const GarmentOptions& options) {
  Wardrobe wardrobe;
  wardrobe.pattern = ReadPattern(options.garment);
  wardrobe.body = ParseBodySpec(options.body, wardrobe.pattern.arm_angle,
                                {.frames_per_second = options.body_fps});
  wardrobe.garment = MakeGarmentMesh(wardrobe.pattern, options.edge, options.garment);
  wardrobe.sewn = Sew(wardrobe.garment, MakeLaw(options.law));
  wardrobe.wear = options.wear;
  // Where other programs have the cores, threads that wait for one another cost more than they
  // gain.
  wardrobe.wear.euler.threads = std::max(1, options.threads / options.draws);
  wardrobe.wear.frames = static_cast<int>(std::lround(options.seconds * kFrameRate));
  const double frame = 1.0 / kFrameRate;
  wardrobe.wear.steps_per_frame =
      std::max(1, static_cast<int>(std::ceil(frame / options.wear.h - 1e-9)));
  wardrobe.wear.h = frame / wardrobe.wear.steps_per_frame;
  wardrobe.wear.euler.linear_solver = MakeStepLinearSolver(
      options.backend, wardrobe.sewn.model->pattern, wardrobe.wear.euler.threads, &wardrobe.device);
  return wardrobe;
}

void CheckOneDraw(const GarmentOptions& options) {
  if (options.draws > 1 && options.wear.start_noise == 0.0)
    throw InputError("option 'draws'",
                     "found more than one of a material, expected a posterior or a positive "
                     "--start_noise");
}

MaterialSource MakeMaterials(const GarmentOptions& options, const ClothModel& model) {
  if (options.material.empty() == options.posterior.empty())
    throw InputError("options 'material' and 'posterior'",
                     std::string("found ") + (options.material.empty() ? "neither" : "both") +
                         ", expected one of them");
  const double least = options.min_relative_stiffness;
  if (!options.posterior.empty()) {
    std::string kind;
    const MaterialSource source =
        ReadMaterialSource(options.posterior, model, static_cast<uint64_t>(options.seed), &kind);
    if (kind == "field")
      throw InputError(options.posterior,
                       "found tables that vary over the disc of a drape, which a garment does not "
                       "have, expected one table or a posterior");
    if (kind == "table") CheckOneDraw(options);
    return [source, least](int draw) {
      MaterialField field = source(draw);
      if (least > 0.0) RaiseSmallEntries(field, least);
      return field;
    };
  }
  CheckOneDraw(options);
  Material material = ReadMaterial(
      options.material, {least > 0.0 ? NegativeEntries::kRaise : NegativeEntries::kReject});
  if (least > 0.0) RaiseSmallEntries(material.field, least);
  return [field = material.field](int) { return field; };
}

// What a run depends on but for its length, which leaves its frames as they are. Files may have
// changed since a checkpoint: sums stand for what was read from them.
std::string SettingsText(const GarmentOptions& options, const Wardrobe& wardrobe,
                         const MaterialField& material) {
  double stretch = 0.0, bend = 0.0;
  for (const StretchTable& table : material.stretch)
    stretch += std::accumulate(table.entries(), table.entries() + kStretchEntries, 0.0);
  for (const BendTable& table : material.bend)
    bend += std::accumulate(table.entries(), table.entries() + kBendEntries, 0.0);
  const Mesh& mesh = wardrobe.garment.mesh;
  return Format(
      "%s %.17g %.17g %s %.17g %s %.17g %.17g %.17g %s %g %g %g %g %g %g %g %d %d %g %g %d",
      options.garment.c_str(), wardrobe.garment.start_x.sum(), mesh.uv.sum(), options.body.c_str(),
      wardrobe.body->Positions(0.0).sum(), (options.material + options.posterior).c_str(),
      material.density, stretch, bend, options.law.c_str(), options.edge, wardrobe.wear.h,
      wardrobe.wear.euler.tolerance, wardrobe.wear.thickness, wardrobe.wear.skin_offset,
      wardrobe.wear.friction, wardrobe.wear.euler.creep_speed, wardrobe.wear.euler.friction_rounds,
      wardrobe.wear.self_contact, wardrobe.wear.self_friction, wardrobe.wear.start_noise,
      options.seed);
}

// The places of the unsewn vertices, which the OBJ file and the cache have.
Eigen::VectorXd Unsewn(const Wardrobe& wardrobe, const Eigen::VectorXd& x) {
  const std::vector<int>& vertex_of = wardrobe.sewn.vertex_of;
  Eigen::VectorXd all(3 * vertex_of.size());
  for (std::size_t i = 0; i < vertex_of.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = x.segment<3>(3 * vertex_of[i]);
  return all;
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
          {"self_intersections", at.run.self_intersections},
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
  at.run.self_intersections = input.At("self_intersections").IntegerWithin(0, kMostCount);
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
  run->self_intersections = std::max(run->self_intersections, frame.self_intersections);
  run->newton_steps += frame.newton_steps;
  run->seconds += frame.seconds;
}

// Eight frames from the caches, side by side.
void WriteSheet(const Wardrobe& wardrobe, const std::string& folder) {
  constexpr int kPictures = 8, kColumns = 4;
  const GeometryCache cloth = ReadGeometryCache(folder + "/garment.pc2"),
                      body = ReadGeometryCache(folder + "/body.pc2");
  const std::vector<std::array<int, 3>> triangles = ListTriangles(wardrobe.garment.mesh);
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

// The first vertex of garment.obj that is this one of the sewn garment, counted from 1 as in that
// file, and its panel.
std::string VertexText(const Wardrobe& wardrobe, int sewn_vertex) {
  const std::vector<int>& vertex_of = wardrobe.sewn.vertex_of;
  const auto i = static_cast<int>(std::find(vertex_of.begin(), vertex_of.end(), sewn_vertex) -
                                  vertex_of.begin());
  const std::vector<int>& begin = wardrobe.garment.panel_begin;
  const auto panel = std::upper_bound(begin.begin(), begin.end(), i) - begin.begin() - 1;
  return Format("vertex %d of garment.obj in panel '%s'", i + 1,
                wardrobe.pattern.panels[panel].name.c_str());
}

[[noreturn]] void RefuseStart(const GarmentOptions& options, const Wardrobe& wardrobe,
                              const State& start, int vertex, const std::string& found,
                              const std::string& expected) {
  const Eigen::Vector3d place = 100.0 * start.x.segment<3>(3 * vertex);
  throw InputError(options.garment,
                   Format("found cloth that %s before the first step, near (%.1f, %.1f, %.1f) cm, ",
                          found.c_str(), place.x(), place.y(), place.z()) +
                       VertexText(wardrobe, vertex) + ", expected " + expected);
}

// Contact keeps cloth out of itself and the body out of cloth, but takes neither out.
void CheckStart(const GarmentOptions& options, const Wardrobe& wardrobe, const State& start) {
  if (const auto vertex = FindStartPiercing(wardrobe.sewn, *wardrobe.body, wardrobe.wear, start))
    RefuseStart(options, wardrobe, start, *vertex, "the body passes through",
                "panels around it: move them apart, or set a smaller --edge");
  if (!options.wear.self_contact) return;
  if (const auto faces = FindStartIntersection(wardrobe.sewn, start))
    RefuseStart(options, wardrobe, start, wardrobe.sewn.model->mesh.faces[faces->first].vertex[0],
                "passes through itself",
                "panels that do not: move them apart, or set --self_contact=false");
}

double LowestPoint(const Eigen::VectorXd& x) {
  double lowest = x[2];
  for (Eigen::Index i = 2; i < x.size(); i += 3) lowest = std::min(lowest, x[i]);
  return lowest;
}

GarmentRun RunOne(const GarmentOptions& options, const Wardrobe& wardrobe,
                  const MaterialField& material, int draw, const std::string& folder,
                  const RunControl& control) {
  const auto seed = SeedOfStream(static_cast<uint64_t>(options.seed), draw);
  const std::string settings = SettingsText(options, wardrobe, material);
  fs::create_directories(folder);
  const std::string stored = folder + "/checkpoint.json";
  Checkpoint at;
  if (options.resume && fs::exists(stored)) {
    at = ReadCheckpoint(stored, settings, wardrobe.sewn.model->num_dofs());
  } else {
    at.state = StartToWear(wardrobe.sewn, *wardrobe.body, wardrobe.wear, seed);
    CheckStart(options, wardrobe, at.state);
    WriteObj(folder + "/garment.obj", wardrobe.garment.mesh, Unsewn(wardrobe, at.state.x));
    WriteObj(folder + "/body.obj",
             ObjSurface{wardrobe.body->Positions(0.0), wardrobe.body->triangles()});
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
  if (result.worst_vertex >= 0) run.wear.reason += ", " + VertexText(wardrobe, result.worst_vertex);
  run.wear.frames = at.frame + 1;
  run.vertices = wardrobe.sewn.model->mesh.num_vertices();
  run.faces = wardrobe.sewn.model->mesh.num_faces();
  run.hem_height = LowestPoint(at.state.x);
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

void WriteSummary(const GarmentOptions& options, const Wardrobe& wardrobe,
                  const GarmentResult& result, const std::string& path) {
  const WearOptions& wear = wardrobe.wear;
  Json json = {{"tool", "drape_garment"},
               {"status", result.cancelled ? "cancelled" : "done"},
               {"garment", options.garment},
               {"body", options.body},
               {"material", options.posterior.empty() ? options.material : options.posterior},
               {"draws", options.draws},
               {"seed", options.seed},
               {"min_relative_stiffness", options.min_relative_stiffness},
               {"law", options.law},
               {"edge_m", options.edge},
               {"time_step", wear.h},
               {"tolerance", wear.euler.tolerance},
               {"frames_per_second", kFrameRate},
               {"thickness_m", wear.thickness},
               {"skin_offset_m", wear.skin_offset},
               {"friction", wear.friction},
               {"creep_speed_m_s", wear.euler.creep_speed},
               {"friction_rounds", wear.euler.friction_rounds},
               {"self_contact", wear.self_contact},
               {"self_friction", wear.self_friction},
               {"start_noise_m", wear.start_noise},
               {"backend", wardrobe.device},
               {"runs", Json::array()}};
  for (const GarmentRun& run : result.runs) json["runs"].push_back(RunJson(run));
  WriteWithProvenance(path, std::move(json));
}

}  // namespace

GarmentResult RunGarments(const GarmentOptions& options, const RunControl& control) {
  const Wardrobe wardrobe = MakeWardrobe(options);
  const MaterialSource materials = MakeMaterials(options, *wardrobe.sewn.model);
  const OutputFolder out(options.out, {"summary.json"});
  control.Log("factorises on " + wardrobe.device);
  GarmentResult result;
  result.runs.resize(options.draws);
  for (int draw = 0; draw < options.draws; ++draw) {
    if (options.draws > 1) result.runs[draw].name = Format("draw_%d", draw + 1);
    result.runs[draw].wear.status = WearStatus::kCancelled;  // until it has run
  }
  std::mutex mutex;
  std::vector<double> done(options.draws, 0.0);
  RunInThreads(options.draws, CountThreads(options.threads), control.cancel, [&](int draw) {
    const std::string name = result.runs[draw].name;
    const RunControl part{
        .cancel = control.cancel, .progress = [&](double fraction, const std::string& note) {
          const std::scoped_lock lock(mutex);
          done[draw] = fraction;
          control.Report(std::accumulate(done.begin(), done.end(), 0.0) / options.draws,
                         name.empty() ? note : name + " " + note);
        }};
    GarmentRun run = RunOne(options, wardrobe, materials(draw), draw,
                            options.out + (name.empty() ? "" : "/" + name), part);
    run.name = name;
    result.runs[draw] = std::move(run);
  });
  result.cancelled = control.cancelled();
  WriteSummary(options, wardrobe, result, out.Staged("summary.json"));
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

namespace {

ToolOutcome Run(const GarmentOptions& options, const RunControl& control) {
  const GarmentResult result = RunGarments(options, control);
  return {.text = GarmentText(result),
          .cancelled = result.cancelled,
          .failure = GarmentFailure(result)};
}

}  // namespace

int GarmentMain(int argc, char** argv) { return ToolMain(argc, argv, GarmentTable, Run); }

}  // namespace drape
