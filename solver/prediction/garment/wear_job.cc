// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/wear_job.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

#include "cuda/make_backend.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/math/sha256.h"
#include "physics/util/options/names_file.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/tubes.h"

namespace drape {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kSignature[12] = "POINTCACHE2";
constexpr int32_t kVersion = 1;

struct Header {
  char signature[12];
  int32_t version;
  int32_t points;
  float start, rate;  // [frames]
  int32_t frames;
};
static_assert(sizeof(Header) == 32);

int64_t FrameBytes(int num_points) { return int64_t{12} * num_points; }

Header ParseHeader(std::string_view bytes, int64_t file_size, const std::string& path) {
  Header header;
  if (bytes.size() < sizeof(header) ||
      std::memcmp(bytes.data(), kSignature, sizeof(kSignature)) != 0)
    throw InputError(path, "not a point cache: expected a file that begins with POINTCACHE2");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.version != kVersion || header.points < 1 || header.frames < 0)
    throw InputError(path, Format("found version %d, %d points and %d frames, expected version 1 "
                                  "of a positive number of points",
                                  header.version, header.points, header.frames));
  if ((file_size - int64_t{sizeof(header)}) / FrameBytes(header.points) < header.frames)
    throw InputError(path, Format("found %lld bytes, expected %d frames of %d points",
                                  static_cast<long long>(file_size), header.frames, header.points));
  return header;
}

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kFrameRate = 25.0;  // [1/s]
constexpr StoredFormat kCheckpoint = {"drapefit-garment-run", 3};

// Whole numbers of steps in a frame and of frames in the time.
void ChooseSteps(WearSpec* spec) {
  WearOptions& wear = spec->wear;
  const double frame = 1.0 / kFrameRate;
  wear.frames = static_cast<int>(std::lround(spec->seconds * kFrameRate));
  wear.steps_per_frame = std::max(1, static_cast<int>(std::ceil(frame / wear.h - 1e-9)));
  wear.h = frame / wear.steps_per_frame;
}

// The bits of all numbers of a material.
std::string MaterialSum(const MaterialField& material) {
  std::string bytes;
  const auto add = [&](const double* numbers, int count) {
    bytes.append(reinterpret_cast<const char*>(numbers), count * sizeof(double));
  };
  add(&material.density, 1);
  for (const StretchTable& table : material.stretch) add(table.entries(), kStretchEntries);
  for (const BendTable& table : material.bend) add(table.entries(), kBendEntries);
  return Sha256(bytes);
}

Eigen::AlignedBox3d BoxAround(const Eigen::VectorXd& x) {
  const auto points = x.reshaped(3, x.size() / 3);
  return {Eigen::Vector3d(points.rowwise().minCoeff()),
          Eigen::Vector3d(points.rowwise().maxCoeff())};
}
std::string PlaceText(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d middle = box.center();
  return Format("(%.2f, %.2f, %.2f) m", middle.x(), middle.y(), middle.z());
}

// Some patterns have their origin in the hips, as SMPL's bodies have.
constexpr double kBelow = .15;  // no garment begins that far below the soles [m]
constexpr double kHips = .676;  // of the height: the origin of SMPL's mean body

double LowestCorner(const Pattern& pattern) {
  double low = HUGE_VAL;
  for (const Panel& panel : pattern.panels)
    for (const PatternEdge& edge : panel.outline) low = std::min(low, panel.Place(edge.begin).z());
  return low;
}

// Lifts a pattern from the hips that would hang below the body.
void LiftFromHips(const Eigen::AlignedBox3d& body, const std::string& where, Pattern* pattern) {
  const double below = body.min().z() - LowestCorner(*pattern), lift = kHips * body.sizes().z();
  if (below <= kBelow || below - lift > kBelow) return;
  for (Panel& panel : pattern->panels) panel.placement.pretranslate(Eigen::Vector3d(0, 0, lift));
  NoteInput(where,
            Format("the pattern reaches %.2f m below the soles: its origin is taken to be in the "
                   "hips, %.2f m above them (--body_offset moves the body)",
                   below, lift));
}

// Why a garment is not worn at the end: of its vertices those that have dropped least hold it. x, v
// and start: [3V]; motion: of the pelvis since the start, and `speed` its own upwards [m/s].
std::string WhyNotWorn(const State& now, const Eigen::VectorXd& start,
                       const Eigen::Isometry3d& motion, double speed) {
  constexpr double kShare = .02;                 // of the vertices
  constexpr double kFar = .25, kSome = .1;       // [m]
  constexpr double kFast = .2;                   // [m/s]
  std::vector<std::pair<double, double>> drops;  // [m], downwards [m/s]
  for (Eigen::Index i = 0; i < start.size(); i += 3)
    drops.emplace_back((motion * start.segment<3>(i)).z() - now.x[i + 2], speed - now.v[i + 2]);
  std::sort(drops.begin(), drops.end());
  drops.resize(
      std::max<size_t>(1, static_cast<size_t>(kShare * static_cast<double>(drops.size()))));
  double drop = 0, fall = 0;
  for (const auto& [far, fast] : drops) {
    drop += far / static_cast<double>(drops.size());
    fall += fast / static_cast<double>(drops.size());
  }
  if (drop > kFar) return Format("the garment has slid down: all of it by %.2f m and more", drop);
  if (drop > kSome && fall > kFast)
    return Format("the garment slides down: all of it by %.2f m so far, at %.2f m/s", drop, fall);
  return "";
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

// Where a run can go on: the state at a frame, and what has been measured up to it.
struct Checkpoint {
  int frame = -1;  // none yet
  State state;
  GarmentRun run;

  nlohmann::json ToJson(const nlohmann::json& key) const {
    return {{"settings", key},
            {"frame", frame},
            {"x", state.x},
            {"v", state.v},
            {"body_intersections", run.body_intersections},
            {"self_intersections", run.self_intersections},
            {"newton_steps", run.newton_steps},
            {"smallest_gap", run.smallest_gap},
            {"largest_stretch", run.largest_stretch},
            {"seconds", run.seconds}};
  }

  static Checkpoint Read(const std::string& path, const nlohmann::json& key, int dofs) {
    const nlohmann::json stored = ReadStoredJson(path, kCheckpoint);
    const JsonInput input(stored, path);
    if (input.At("settings").ExpectObject().value() != key)
      throw InputError(path,
                       "found another garment, body, material or setting, expected the "
                       "present one: run without --resume, or undo the change");
    constexpr int kMostCount = 1'000'000'000;
    Checkpoint at;
    at.frame = input.At("frame").IntegerWithin(0, kMostCount);
    at.state = {input.At("x").Vector(dofs), input.At("v").Vector(dofs)};
    constexpr double kMost = 1000.0;  // [m], [m/s]
    for (const auto& [key_of, vector] : {std::pair("x", &at.state.x), {"v", &at.state.v}})
      if (vector->cwiseAbs().maxCoeff() > kMost)
        input.At(key_of).Fail(Format("numbers of at most %g", kMost));
    at.run.body_intersections = input.At("body_intersections").IntegerWithin(0, kMostCount);
    at.run.self_intersections = input.At("self_intersections").IntegerWithin(0, kMostCount);
    at.run.newton_steps = input.At("newton_steps").IntegerWithin(0, kMostCount);
    at.run.smallest_gap = input.At("smallest_gap").Number();
    at.run.largest_stretch = input.At("largest_stretch").NotNegative();
    at.run.seconds = input.At("seconds").NotNegative();
    return at;
  }
};

class WearJob {
 public:
  WearJob(const WearSpec& spec, const WearRunOptions& options, const MaterialMaker& make_materials);

  GarmentResult Run(const RunControl& control) const;

 private:
  std::string VertexText(int sewn_vertex) const;
  Eigen::VectorXd Unsewn(const Eigen::VectorXd& x) const;
  [[noreturn]] void RefuseStart(const State& start, int vertex, const std::string& found,
                                const std::string& expected) const;
  void CheckStart(const State& start) const;
  nlohmann::json Key(const MaterialField& material, int draw) const;
  GarmentRun RunOne(const MaterialField& material, int draw, const std::string& folder,
                    const RunControl& control) const;
  GarmentRun Conclude(const Checkpoint& at, const WearResult& result) const;
  const ClothModel& model() const { return *sewn_.model; }

  WearSpec spec_;  // with the time step and the frames of the runs
  WearRunOptions options_;
  Pattern pattern_;
  std::unique_ptr<Body> body_;
  GarmentMesh garment_;
  SewnGarment sewn_;
  std::string device_;
  std::function<MaterialField(int draw)> materials_;
  std::string read_sum_;  // of the sums of all files that were read
};

WearJob::WearJob(const WearSpec& spec, const WearRunOptions& options,
                 const MaterialMaker& make_materials)
    : spec_(spec), options_(options) {
  CheckFields(spec);
  const ReadRecord read;
  pattern_ = ReadPattern(spec.garment);
  body_ = ParseBody(spec.body, pattern_.arm_angle, spec.body_files);
  if (body_->num_files() > 0) spec_.body_files = body_->files();
  if (pattern_.arm_angle == 0)
    LiftFromHips(BoxAround(body_->Positions(kGrowSeconds)), spec.garment, &pattern_);
  garment_ = MakeGarmentMesh(pattern_, spec.edge, spec.garment);
  if (spec.wear.self_contact) CheckSeams(garment_, pattern_, spec.garment);
  sewn_ = Sew(garment_, MakeLaw(spec.law));
  body_->ReachInto(FindTubes(sewn_, DrawSeams(sewn_)));
  ChooseSteps(&spec_);
  // Where other programs have the cores, threads that wait for one another cost more than they
  // gain.
  ImplicitEulerOptions& euler = spec_.wear.euler;
  euler.threads = std::max(1, options.step_threads / spec.draws);
  euler.linear_solver =
      MakeStepLinearSolver(options.backend, sewn_.model->pattern, euler.threads, &device_);
  materials_ = make_materials(model());
  std::string sums;
  for (const ReadRecord::File& file : read.files()) sums += file.sha256;
  read_sum_ = Sha256(sums);
}

nlohmann::json WearJob::Key(const MaterialField& material, int draw) const {
  nlohmann::json key = {{"draw", draw}, {"material", MaterialSum(material)}, {"files", read_sum_}};
  VisitFields(spec_, [&](const auto& value, const Field& field) {
    if (field.in_key && !NamesFile(value, field)) key[field.key] = value;
  });
  return key;
}

// The places of the unsewn vertices, which the OBJ file and the cache have.
Eigen::VectorXd WearJob::Unsewn(const Eigen::VectorXd& x) const {
  Eigen::VectorXd all(3 * sewn_.vertex_of.size());
  for (std::size_t i = 0; i < sewn_.vertex_of.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = x.segment<3>(3 * sewn_.vertex_of[i]);
  return all;
}

// The first vertex of garment.obj that is this one of the sewn garment, counted from 1 as in that
// file, and its panel.
std::string WearJob::VertexText(int sewn_vertex) const {
  const std::vector<int>& vertex_of = sewn_.vertex_of;
  const auto i = static_cast<int>(std::find(vertex_of.begin(), vertex_of.end(), sewn_vertex) -
                                  vertex_of.begin());
  const std::vector<int>& begin = garment_.panel_begin;
  const auto panel = std::upper_bound(begin.begin(), begin.end(), i) - begin.begin() - 1;
  return Format("vertex %d of garment.obj in panel '%s'", i + 1,
                pattern_.panels[panel].name.c_str());
}

void WearJob::RefuseStart(const State& start, int vertex, const std::string& found,
                          const std::string& expected) const {
  const Eigen::Vector3d place = 100.0 * start.x.segment<3>(3 * vertex);
  throw InputError(spec_.garment,
                   Format("found cloth that %s before the first step, near (%.1f, %.1f, %.1f) cm, ",
                          found.c_str(), place.x(), place.y(), place.z()) +
                       VertexText(vertex) + ", expected " + expected +
                       (options_.out.empty() ? "" : "; see body.obj"));
}

// Contact keeps cloth out of itself and the body out of cloth, but takes neither out.
void WearJob::CheckStart(const State& start) const {
  const Eigen::AlignedBox3d cloth = BoxAround(start.x), body = BoxAround(body_->Positions(0.0));
  if (!cloth.intersects(body))
    throw InputError(spec_.garment, "found a garment about " + PlaceText(cloth) +
                                        " and a body about " + PlaceText(body) +
                                        ", expected them to meet: move one, or set --body_offset");
  if (const auto vertex = FindStartPiercing(sewn_, *body_, spec_.wear, start))
    RefuseStart(start, *vertex, "the body passes through",
                "panels around it: set a smaller --edge, or move them apart");
  if (!spec_.wear.self_contact) return;
  if (const auto faces = FindStartIntersection(sewn_, start))
    RefuseStart(start, model().mesh.faces[faces->first].vertex[0], "passes through itself",
                "panels that do not: set a smaller --edge, move them apart, or set "
                "--self_contact=false");
}

GarmentRun WearJob::RunOne(const MaterialField& material, int draw, const std::string& folder,
                           const RunControl& control) const {
  const nlohmann::json key = Key(material, draw);
  const bool writes = !options_.out.empty();
  if (writes) fs::create_directories(folder);
  const std::string stored = folder + "/checkpoint.json";
  if (writes) CheckStored(stored, kCheckpoint);
  Checkpoint at;
  if (options_.resume && fs::exists(stored)) {
    at = Checkpoint::Read(stored, key, model().num_dofs());
  } else {
    at.state = StartToWear(sewn_, *body_, spec_.wear,
                           SeedOfStream(static_cast<uint64_t>(spec_.seed), draw));
    if (writes) {
      WriteObj(folder + "/garment.obj", garment_.mesh, Unsewn(at.state.x));
      WriteObj(folder + "/body.obj", ObjSurface{body_->Positions(0.0), body_->triangles()});
    }
    CheckStart(at.state);
  }
  std::optional<GeometryCacheWriter> cloth, body;
  if (writes) {
    cloth.emplace(folder + "/garment.pc2", garment_.mesh.num_vertices(), at.frame + 1);
    body.emplace(folder + "/body.pc2", body_->num_vertices(), at.frame + 1);
  }
  const auto on_frame = [&](const WornFrame& frame) {
    if (frame.index <= at.frame) return;
    AddFrame(frame, &at.run);
    at.frame = frame.index;
    at.state = frame.cloth;
    if (options_.on_frame) options_.on_frame(sewn_, *body_, frame);
    if (!writes) return;
    cloth->Append(Unsewn(frame.cloth.x));
    body->Append(frame.body);
    WriteStoredJson(stored, kCheckpoint, at.ToJson(key));
  };
  const WearResult result =
      Wear(sewn_, material, *body_, spec_.wear, at.state, std::max(0, at.frame), control, on_frame);
  return Conclude(at, result);
}

// The run, which fails where the garment is not worn at its end.
GarmentRun WearJob::Conclude(const Checkpoint& at, const WearResult& result) const {
  GarmentRun run = at.run;
  run.wear = result;
  if (result.worst_vertex >= 0) run.wear.reason += ", " + VertexText(result.worst_vertex);
  run.wear.frames = at.frame + 1;
  run.vertices = model().mesh.num_vertices();
  run.faces = model().mesh.num_faces();
  const Eigen::AlignedBox3d last = BoxAround(at.state.x);
  run.hem_height = last.min().z();
  if (run.wear.status != WearStatus::kDone) return run;
  const double end = at.frame / kFrameRate, before = end - 1 / kFrameRate;
  const Eigen::Isometry3d motion = body_->PelvisMotion(end);
  const Eigen::Vector3d hips = BoxAround(sewn_.start_x).center();
  const double speed = kFrameRate * (motion * hips - body_->PelvisMotion(before) * hips).z();
  run.wear.reason = last.max().z() < BoxAround(body_->Positions(end)).min().z()
                        ? "the garment has dropped off: all of it is below the body"
                        : WhyNotWorn(at.state, sewn_.start_x, motion, speed);
  if (!run.wear.reason.empty()) run.wear.status = WearStatus::kFailed;
  return run;
}

GarmentResult WearJob::Run(const RunControl& control) const {
  control.Log("factorises on " + device_);
  GarmentResult result{.spec = spec_,
                       .device = device_,
                       .body_files = body_->num_files(),
                       .body_rests_after = body_->rests_after()};
  result.runs.resize(spec_.draws);
  for (int draw = 0; draw < spec_.draws; ++draw) {
    if (spec_.draws > 1) result.runs[draw].name = Format("draw_%d", draw + 1);
    result.runs[draw].wear.status = WearStatus::kCancelled;  // until it has run
  }
  std::mutex mutex;
  std::vector<double> done(spec_.draws, 0.0);
  RunInThreads(spec_.draws, options_.threads, control.cancel, [&](int draw) {
    const std::string name = result.runs[draw].name;
    const RunControl part{
        .cancel = control.cancel, .progress = [&](double fraction, const std::string& note) {
          const std::scoped_lock lock(mutex);
          done[draw] = fraction;
          control.Report(std::accumulate(done.begin(), done.end(), 0.0) / spec_.draws,
                         name.empty() ? note : name + " " + note);
        }};
    GarmentRun run =
        RunOne(materials_(draw), draw, options_.out + (name.empty() ? "" : "/" + name), part);
    run.name = name;
    result.runs[draw] = std::move(run);
  });
  result.cancelled = control.cancelled();
  return result;
}

}  // namespace

GeometryCacheWriter::GeometryCacheWriter(std::string path, int num_points, int kept_frames)
    : path_(std::move(path)), num_points_(num_points), num_frames_(kept_frames), descriptor_(-1) {
  CHECK_GE(num_points, 1);
  CHECK_GE(kept_frames, 0);
  if (kept_frames == 0) {
    const Header header = {"POINTCACHE2", kVersion, num_points, 0, 1, 0};
    WriteFileAtomically(path_, {reinterpret_cast<const char*>(&header), sizeof(header)});
  }
  descriptor_ = open(path_.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor_ < 0) throw IoError(path_, std::strerror(errno));
  try {
    char bytes[sizeof(Header)];
    const ssize_t count = pread(descriptor_, bytes, sizeof(bytes), 0);
    const Header header = ParseHeader({bytes, size_t(std::max<ssize_t>(count, 0))},
                                      lseek(descriptor_, 0, SEEK_END), path_);
    if (header.points != num_points || header.frames < kept_frames)
      throw InputError(path_, Format("found %d frames of %d points, expected %d frames of %d",
                                     header.frames, header.points, kept_frames, num_points));
    WriteHeader();
    if (ftruncate(descriptor_, sizeof(Header) + kept_frames * FrameBytes(num_points)) != 0)
      throw IoError(path_, std::strerror(errno));
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

GeometryCacheWriter::~GeometryCacheWriter() { close(descriptor_); }

void GeometryCacheWriter::WriteAt(int64_t offset, const void* data, size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = pwrite(descriptor_, next, size, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw IoError(path_, std::strerror(written < 0 ? errno : ENOSPC));
    next += written;
    offset += written;
    size -= written;
  }
}

void GeometryCacheWriter::WriteHeader() {
  const Header header = {"POINTCACHE2", kVersion, num_points_, 0, 1, num_frames_};
  WriteAt(0, &header, sizeof(header));
}

void GeometryCacheWriter::Append(const Eigen::VectorXd& x) {
  CHECK_EQ(x.size(), 3 * num_points_);
  const Eigen::VectorXf frame = x.cast<float>();
  WriteAt(sizeof(Header) + num_frames_ * FrameBytes(num_points_), frame.data(),
          FrameBytes(num_points_));
  fdatasync(descriptor_);
  ++num_frames_;
  WriteHeader();
}

GarmentResult RunWearJob(const WearSpec& spec, const WearRunOptions& options,
                         const MaterialMaker& make_materials, const RunControl& control) {
  return WearJob(spec, options, make_materials).Run(control);
}

Json WearSummary(const GarmentResult& result) {
  const bool failed =
      std::any_of(result.runs.begin(), result.runs.end(),
                  [](const GarmentRun& run) { return run.wear.status == WearStatus::kFailed; });
  Json json = {{"tool", "drape_garment"},
               {"status", result.cancelled ? "cancelled"
                          : failed         ? "failed"
                                           : "done"}};
  VisitFields(result.spec, [&](const auto& value, const Field& field) { json[field.key] = value; });
  json["frames_per_second"] = kFrameRate;
  json["backend"] = result.device;
  if (result.body_files > 0) {
    json["body_files"] = result.body_files;
    json["body_rests_after_s"] = result.body_rests_after;
  }
  json["runs"] = Json::array();
  for (const GarmentRun& run : result.runs) json["runs"].push_back(RunJson(run));
  return json;
}

}  // namespace drape
