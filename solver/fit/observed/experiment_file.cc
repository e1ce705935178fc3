// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/experiment_file.h"

#include <algorithm>
#include <cctype>
#include <climits>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <utility>

#include "losses/camera/view.h"
#include "losses/image/segmentation.h"
#include "losses/outline/outline.h"
#include "losses/readout/cloud_readouts.h"
#include "losses/readout/observation_files.h"
#include "losses/readout/outline_readouts.h"
#include "losses/readout/scene_readouts.h"
#include "losses/readout/view_readouts.h"
#include "physics/cloth/scene_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/scan_io.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr int kStarts = 2, kStartsOverSupport = 8;  // folds over a support have many branches
constexpr double kLeastSigma = 1e-9, kMostSigma = 1e6;
constexpr double kMostLength = 100.0;  // [m]
constexpr int kMostModes = 50;
constexpr int kMostNumbers = 1 << 18;  // of a measurement: their Jacobian is dense

// A file that a key names, relative to the folder of the experiments.
std::string ResolvePath(const JsonInput& input, const std::string& folder) {
  const fs::path path = input.String();
  return path.is_absolute() || folder.empty() ? path.string() : (fs::path(folder) / path).string();
}

// What `read` makes; an error of another file also says what led to it.
template <class Read>
auto NamingKey(const std::string& key, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(key, error.what());
  }
}

// What `read` makes of the file that a key names.
template <class Read>
auto ReadNamed(const JsonInput& key, const std::string& folder, const Read& read) {
  return NamingKey(key.Name(), [&] { return read(ResolvePath(key, folder)); });
}

std::shared_ptr<ceres::LossFunction> ReadLoss(const JsonInput& input) {
  input.ExpectKeys({"huber", "cauchy", "tukey"});
  if (input.Size() != 1) input.Fail("one of huber, cauchy and tukey");
  const auto width = [&](const char* key) { return input.At(key).NumberWithin(1e-3, 1e3); };
  if (input.Has("huber")) return std::make_shared<ceres::HuberLoss>(width("huber"));
  if (input.Has("cauchy")) return std::make_shared<ceres::CauchyLoss>(width("cauchy"));
  return std::make_shared<ceres::TukeyLoss>(width("tukey"));
}

Camera ReadCameraOrFile(const JsonInput& input, const std::string& folder) {
  if (!input.value().is_string()) return ReadCamera(input);
  return ReadNamed(input, folder, [](const std::string& path) { return ReadCamera(path); });
}

View ReadView(const JsonInput& input, const std::string& folder) {
  if (!input.Has("position")) return ReadCameraOrFile(input, folder);
  input.ExpectKeys({"camera", "position", "target", "up"});
  return LookAt(ReadCameraOrFile(input.At("camera"), folder), input.At("position").Vector(3),
                input.At("target").Vector(3), input.At("up").Vector(3), input.Name());
}

std::vector<std::string> WithCommonKeys(std::vector<std::string> keys) {
  keys.insert(keys.end(), {"sigma", "loss", "step"});
  return keys;
}

Measurement MakeMarkerMeasurement(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys(WithCommonKeys({"markers"}));
  const std::string path = ResolvePath(input.At("markers"), folder);
  const auto markers =
      std::make_shared<const MeasuredMarkers>(ReadNamed(input.At("markers"), folder, ReadMarkers));
  return {
      .name = "markers of " + path,
      .readout =
          [=](const ClothModel& model) {
            return std::make_shared<MarkerReadout>(WeightsOfMarkers(model.mesh, *markers, path));
          },
      .data = markers->x,
      .by_vertex_numbers = !markers->vertices.empty()};
}

Measurement MakeShapeMeasurement(const JsonInput& input, const std::string& folder,
                                 const Mesh& mesh) {
  input.ExpectKeys(WithCommonKeys({"shape"}));
  const std::string path = ResolvePath(input.At("shape"), folder);
  Measurement measurement{.name = "shape of " + path,
                          .readout = {},
                          .data = ReadNamed(input.At("shape"), folder, ReadVertices)};
  if (measurement.data.size() != mesh.rest_x.size())
    input.At("shape").Fail(Format("a file of the mesh's %d vertices, not of %d",
                                  mesh.num_vertices(), int(measurement.data.size() / 3)));
  measurement.start = measurement.data;
  // Places by their material coordinates, so that another mesh reads the same.
  const Eigen::Matrix2Xd places = mesh.uv;
  measurement.readout = [=](const ClothModel& model) {
    return std::make_shared<MarkerReadout>(WeightsOfPlaces(model.mesh, places, path));
  };
  return measurement;
}

std::vector<Measurement> MakePointMeasurements(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys(WithCommonKeys({"points", "spacing", "max_distance"}));
  const std::string path = ResolvePath(input.At("points"), folder);
  const Eigen::VectorXd points = ReadNamed(input.At("points"), folder, ReadPointCloud);
  std::vector<Measurement> measurements = {
      {.name = "points of " + path, .readout = [=](const ClothModel& model) {
         return std::make_shared<PointCloudReadout>(model.mesh, points);
       }}};
  if (!input.Has("spacing")) return measurements;
  UncoveredOptions options{.spacing = input.At("spacing").NumberWithin(0.0, kMostLength)};
  if (input.Has("max_distance"))
    options.max_distance = input.At("max_distance").NumberWithin(options.spacing, kMostLength);
  measurements.push_back(
      {.name = "cloth without points of " + path, .readout = [=](const ClothModel& model) {
         std::vector<int> vertices(model.mesh.num_vertices());
         std::iota(vertices.begin(), vertices.end(), 0);
         return std::make_shared<UncoveredReadout>(points, vertices, options);
       }});
  return measurements;
}

void RequireSize(const JsonInput& image, int width, int height, const Camera& camera) {
  if (width == camera.width && height == camera.height) return;
  image.Fail(Format("an image of the %d x %d px of its camera, not of %d x %d px", camera.width,
                    camera.height, width, height));
}

Measurement MakeDepthMeasurement(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys(WithCommonKeys({"depth", "metres_per_count", "background", "view"}));
  const std::string path = ResolvePath(input.At("depth"), folder);
  const double scale = input.At("metres_per_count").NumberWithin(1e-9, 1.0);
  const DepthMap map =
      NamingKey(input.At("depth").Name(), [&] { return ReadDepthMap(path, scale); });
  const View view = ReadView(input.At("view"), folder);
  RequireSize(input.At("depth"), map.width, map.height, view.camera);
  const double background = input.At("background").NumberWithin(0.0, kMostLength);
  Measurement measurement{.name = "depth of " + path, .readout = [=](const ClothModel& model) {
                            return std::make_shared<DepthReadout>(model.mesh, view, map.pixels,
                                                                  background);
                          }};
  measurement.data.resize(static_cast<Eigen::Index>(map.pixels.size()));
  for (std::size_t i = 0; i < map.pixels.size(); ++i)
    measurement.data[static_cast<Eigen::Index>(i)] = map.depth[map.pixels[i]];
  return measurement;
}

// Pixels beside one of another coverage. The others are the same for most drapes.
int CountAtOutline(const GrayImage& image) {
  int count = 0;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const auto differs = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < image.width && y < image.height &&
               image.at(x, y) != image.at(column, row);
      };
      count += differs(column - 1, row) || differs(column + 1, row) || differs(column, row - 1) ||
               differs(column, row + 1);
    }
  return count;
}

Measurement MakeSilhouetteMeasurement(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys(WithCommonKeys({"silhouette", "view", "half_width"}));
  const std::string path = ResolvePath(input.At("silhouette"), folder);
  const GrayImage image = NamingKey(input.At("silhouette").Name(), [&] { return ReadMask(path); });
  const View view = ReadView(input.At("view"), folder);
  RequireSize(input.At("silhouette"), image.width, image.height, view.camera);
  SoftSilhouetteOptions soft;
  if (input.Has("half_width")) soft.half_width = input.At("half_width").NumberWithin(0.1, 100.0);
  Measurement measurement{.name = "silhouette of " + path, .readout = [=](const ClothModel& model) {
                            return std::make_shared<SilhouetteReadout>(model.mesh, view, soft);
                          }};
  measurement.data.resize(Eigen::Index{image.width} * image.height);
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column)
      measurement.data[row * image.width + column] = image.at(column, row);
  measurement.num_telling = std::max(1, CountAtOutline(image));
  measurement.is_contour = true;
  return measurement;
}

// The outline of a drape on its support, in pixels of the picture.
Measurement MakeOutlineMeasurement(const JsonInput& input, const std::string& folder,
                                   const ClothModel& model) {
  constexpr int kAngles = 90;
  constexpr double kLift = 0.8;  // of the flaps
  input.ExpectKeys(WithCommonKeys({"outline", "camera_file"}));
  const JsonInput picture = input.At("outline");
  const std::string path = ResolvePath(picture, folder);
  const std::optional<double> support = SupportRadius(model.scene);
  if (!support) picture.Fail("none: the scene has no support");
  const double reach = model.mesh.uv.colwise().norm().maxCoeff();
  const DrapeDiscs discs{.specimen = std::round(1e4 * reach) / 1e4, .support = *support};
  CameraInput camera;
  if (input.Has("camera_file")) camera.file = ResolvePath(input.At("camera_file"), folder);
  const MeasuredImage seen = NamingKey(picture.Name(), [&] {
    return MeasureImage(ReadSilhouette(path), camera, CentreMode::kOutline, discs, path);
  });
  Outline outline;
  if (!OutlineFromImage(seen.image, seen.camera, kAngles, &outline))
    picture.Fail("a closed outline about the support");
  return {.name = "outline of " + path,
          .readout =
              [=, camera = seen.camera](const ClothModel& cloth) {
                return std::make_shared<OutlineReadout>(cloth.mesh, camera, kAngles);
              },
          .data = outline.radius,
          .sigma = seen.camera.pixels_per_metre(),
          .is_contour = true,
          .start = FlapsFromOutline(model.mesh, *support,
                                    VerticalProfile(outline.radius, seen.camera, discs), kLift),
          .quality = seen.quality};
}

// At least one number of a list.
std::vector<int> ReadNumbers(const JsonInput& input, int least, int most) {
  std::vector<int> numbers;
  for (int i = 0; i < input.ExpectArray().Size(); ++i)
    numbers.push_back(input.At(i).IntegerWithin(least, most));
  if (numbers.empty()) input.Fail("at least one number");
  return numbers;
}

Measurement MakeAngleMeasurement(const JsonInput& input, const Mesh& mesh) {
  input.ExpectKeys(WithCommonKeys({"angle", "tip", "clamp", "along"}));
  const std::vector<int> vertices = ReadNumbers(input.At("tip"), 0, mesh.num_vertices() - 1);
  const Eigen::Vector3d clamp = input.At("clamp").Vector(3), along = input.At("along").Vector(3);
  if (along.z() != 0.0 || !(along.norm() > 0.0)) input.At("along").Fail("a horizontal direction");
  return {.name = "angle",
          .readout =
              [=](const ClothModel&) {
                return std::make_shared<AngleReadout>(vertices, clamp, along.normalized());
              },
          .data = Eigen::VectorXd::Constant(1, input.At("angle").NumberWithin(-90.0, 90.0)),
          .by_vertex_numbers = true};
}

// All three components, or that along a direction.
Measurement MakeForceMeasurement(const JsonInput& input, const ClothModel& model) {
  input.ExpectKeys(WithCommonKeys({"force", "along", "vertices"}));
  Eigen::Matrix3Xd axes = Eigen::Matrix3d::Identity();
  Measurement measurement{.name = "force", .readout = {}};
  const JsonInput force = input.At("force");
  if (input.Has("along")) {
    axes = Eigen::Vector3d(input.At("along").Vector(3));
    if (!(axes.norm() > 0.0)) input.At("along").Fail("a direction");
    axes.normalize();
    measurement.data.setConstant(1, force.Number());
  } else {
    measurement.data = force.Vector(3);
  }
  std::vector<int> vertices;  // none: all that are held
  if (input.Has("vertices"))
    vertices = ReadNumbers(input.At("vertices"), 0, model.mesh.num_vertices() - 1);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (std::ranges::count(model.held, vertices[i]) == 0)
      input.At("vertices").At(static_cast<int>(i)).Fail("a vertex that is held");
  if (model.held.empty()) force.Fail("none: the scene has no handles");
  measurement.by_vertex_numbers = !vertices.empty();
  measurement.readout = [=](const ClothModel& cloth) {
    return std::make_shared<HandleForceReadout>(cloth, vertices.empty() ? cloth.held : vertices,
                                                axes);
  };
  return measurement;
}

Measurement MakeFrequencyMeasurement(const JsonInput& input, const ClothModel& model) {
  input.ExpectKeys(WithCommonKeys({"frequencies", "modes"}));
  Measurement measurement{
      .name = "frequencies", .readout = {}, .data = input.At("frequencies").Vector()};
  const auto count = static_cast<int>(measurement.data.size());
  if (count == 0 || !(measurement.data.minCoeff() > 0.0))
    input.At("frequencies").Fail("at least one frequency, each more than 0");
  std::vector<int> modes(count);
  std::iota(modes.begin(), modes.end(), 1);
  if (input.Has("modes")) {
    input.At("modes").ExpectArray(count);
    modes = ReadNumbers(input.At("modes"), 1, std::min(kMostModes, model.num_dofs() - 1));
  }
  measurement.readout = [=](const ClothModel& cloth) {
    return std::make_shared<FrequencyReadout>(cloth, modes);
  };
  return measurement;
}

std::vector<Measurement> ReadMeasurement(const JsonInput& input, const std::string& folder,
                                         const ClothModel& model) {
  const Mesh& mesh = model.mesh;
  std::vector<Measurement> read;
  if (input.Has("markers"))
    read = {MakeMarkerMeasurement(input, folder)};
  else if (input.Has("shape"))
    read = {MakeShapeMeasurement(input, folder, mesh)};
  else if (input.Has("points"))
    read = MakePointMeasurements(input, folder);
  else if (input.Has("depth"))
    read = {MakeDepthMeasurement(input, folder)};
  else if (input.Has("silhouette"))
    read = {MakeSilhouetteMeasurement(input, folder)};
  else if (input.Has("outline"))
    read = {MakeOutlineMeasurement(input, folder, model)};
  else if (input.Has("angle"))
    read = {MakeAngleMeasurement(input, mesh)};
  else if (input.Has("force"))
    read = {MakeForceMeasurement(input, model)};
  else if (input.Has("frequencies"))
    read = {MakeFrequencyMeasurement(input, model)};
  else
    input.Fail(
        "one of markers, shape, points, depth, silhouette, outline, angle, force and frequencies");
  for (Measurement& each : read) {
    each.sigma *= input.At("sigma").NumberWithin(kLeastSigma, kMostSigma);
    if (input.Has("loss")) each.loss = ReadLoss(input.At("loss"));
    if (input.Has("step")) each.step = input.At("step").Integer();
  }
  return read;
}

void ReadMotion(const JsonInput& input, Experiment& experiment) {
  input.ExpectKeys(
      {"steps", "time_step", "velocity", "mass_damping", "stiffness_damping", "air_drag", "wind"});
  experiment.motion =
      RolloutOptions{.h = input.At("time_step").Number(), .steps = input.At("steps").Integer()};
  Dynamics& dynamics = experiment.dynamics;
  const auto read = [&](const char* key, double* value) {
    if (input.Has(key)) *value = input.At(key).Number();
  };
  read("mass_damping", &dynamics.mass_damping);
  read("stiffness_damping", &dynamics.stiffness_damping);
  read("air_drag", &dynamics.air_drag);
  if (input.Has("wind")) {
    const Eigen::VectorXd wind = input.At("wind").Vector(3);
    dynamics.wind = {wind[0], wind[1], wind[2]};
  }
  if (input.Has("velocity"))
    experiment.velocity =
        input.At("velocity").Vector(3).replicate(experiment.mesh.num_vertices(), 1);
}

Mesh ReadMesh(const JsonInput& input, const std::string& folder) {
  const std::string mesh = input.String();
  const bool is_file = mesh.find(':') == std::string::npos;
  return NamingKey(input.Name(),
                   [&] { return ParseMeshSpec(is_file ? ResolvePath(input, folder) : mesh); });
}

Scene ReadSceneOrFile(const JsonInput& input, const std::string& folder) {
  if (!input.value().is_string()) return ReadScene(input, folder);
  return ReadNamed(input, folder, [](const std::string& path) { return ReadScene(path); });
}

Eigen::Vector3d BeginVelocity(const Experiment& experiment) {
  if (experiment.velocity.size() == 0) return Eigen::Vector3d::Zero();
  return experiment.velocity.head<3>();
}

void Require(bool holds, const std::string& where, const std::string& found,
             const std::string& expected) {
  if (!holds) throw InputError(where, "found " + found + ", expected " + expected);
}

void RequireWithin(double value, double least, double most, const std::string& where,
                   const char* key) {
  Require(value >= least && value <= most, where, Format("%s %.9g", key, value),
          Format("%.9g … %.9g", least, most));
}

// A name that files can have.
bool IsPlainName(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

void CheckMeasurement(const Measurement& measurement, const Experiment& experiment,
                      const ClothModel& model, const std::string& where) {
  Require(measurement.readout != nullptr, where, "no readout", "one");
  // Builds it, since a place off the cloth is an error of the input.
  const auto readout = NamingKey(where, [&] { return measurement.readout(model); });
  const int size = readout->size(), given = static_cast<int>(measurement.data.size());
  Require(size <= kMostNumbers, where, Format("%d numbers", size),
          Format("at most %d: thin them out", kMostNumbers));
  Require(given == 0 || (given == size && measurement.data.allFinite()), where,
          Format("data of %d numbers", given), Format("%d that are finite", size));
  RequireWithin(measurement.sigma, kLeastSigma, kMostSigma, where, "sigma");
  const int last = experiment.motion ? experiment.motion->steps : 0;
  RequireWithin(measurement.step, 0, last, where, "step");
  Require(!experiment.motion || !readout->reads_material(), where, "a motion", "a cloth at rest");
}

ClothModel MakeModel(const Experiment& experiment) {
  return {experiment.mesh, experiment.scene, MakeLaw("smooth")};
}

// Checks that all that is measured can be read of the mesh of the search.
void CheckSearchMesh(const Experiment& experiment, const std::string& where) {
  if (experiment.search_mesh.num_vertices() == 0) return;
  const std::string at = where + ": key 'search_mesh'";
  Require(!experiment.motion, at, "a motion, whose branch is not sought", "a cloth at rest");
  Require(IsSameCloth(experiment.search_mesh, experiment.mesh), at, "another cloth than 'mesh'",
          "one of its area and size");
  Require(experiment.search_mesh.num_vertices() < experiment.mesh.num_vertices(), at,
          Format("%d vertices", experiment.search_mesh.num_vertices()),
          Format("fewer than the %d of 'mesh'", experiment.mesh.num_vertices()));
  const std::optional<Handles>& handles = experiment.scene.handles;
  Require(!handles || handles->vertices.empty(), at, "handles by numbers of vertices",
          "regions, or no search_mesh");
  const ClothModel model = NamingKey(
      at, [&] { return ClothModel(experiment.search_mesh, experiment.scene, MakeLaw("smooth")); });
  for (const Measurement& each : experiment.measurements) {
    Require(!each.by_vertex_numbers, at, each.name + " by numbers of vertices", "no search_mesh");
    (void)NamingKey(at, [&] { return each.readout(model); });
  }
}

// Checks an experiment and lists the frames that are seen.
void Complete(Experiment& experiment, const std::string& where) {
  Require(IsPlainName(experiment.name), where, "name '" + MakePrintableLine(experiment.name) + "'",
          "1 to 64 letters, digits, - and _");
  const int dofs = static_cast<int>(experiment.mesh.rest_x.size());
  Require(dofs > 0, where, "no mesh", "one");
  for (const Eigen::VectorXd* each : {&experiment.start, &experiment.velocity})
    Require(each->size() == 0 || (each->size() == dofs && each->allFinite()), where,
            Format("a start or velocity of %d numbers", static_cast<int>(each->size())),
            Format("%d that are finite", dofs));
  if (experiment.random_starts < 0)
    experiment.random_starts = SupportRadius(experiment.scene) ? kStartsOverSupport : kStarts;
  RequireWithin(experiment.random_starts, 0, 100, where, "random_starts");
  if (experiment.motion) {
    RequireWithin(experiment.motion->h, 1e-6, 10.0, where, "time_step");
    RequireWithin(experiment.motion->steps, 1, 100000, where, "steps");
    RequireWithin(experiment.dynamics.mass_damping, 0.0, 1e3, where, "mass_damping");
    RequireWithin(experiment.dynamics.stiffness_damping, 0.0, 1e3, where, "stiffness_damping");
    RequireWithin(experiment.dynamics.air_drag, 0.0, 1e3, where, "air_drag");
  }
  experiment.in_newtons |= experiment.scene.load.has_value();
  Require(!experiment.measurements.empty(), where, "none", "at least one measurement");
  const ClothModel model = NamingKey(where, [&] { return MakeModel(experiment); });
  std::set<int> frames;
  for (const Measurement& each : experiment.measurements) {
    CheckMeasurement(each, experiment, model, where + ": " + each.name);
    frames.insert(each.step);
  }
  if (experiment.motion) experiment.motion->frames.assign(frames.begin(), frames.end());
  CheckSearchMesh(experiment, where);
}

// Throws InputError where no motion shows fitted number i.
void RequireSeen(const ExperimentFile& file, std::size_t i, const std::string& where) {
  const FreeNumber number = file.fitted[i];
  const auto require = [&](bool holds, const char* expected) {
    Require(holds, where, std::string("\"") + ToString(number) + "\"", expected);
  };
  require(std::ranges::count(std::span(file.fitted).first(i), number) == 0, "each number once");
  if (number == FreeNumber::kDensity) return;
  const Experiment* first = nullptr;
  for (const Experiment& each : file.experiments) {
    if (!each.motion) continue;
    if (first == nullptr) first = &each;
    MaterialField start;
    start.dynamics = each.dynamics;
    const std::span<double> values = FindNumbers(number, start);
    require(IsVector(number) || values[0] > 0.0, "motions with a start value of it, more than 0");
    require(number != FreeNumber::kWind || each.dynamics.air_drag > 0.0,
            "motions with an air_drag, since wind acts by it alone");
    const Vec3<double> d = each.dynamics.wind - first->dynamics.wind;
    require(!IsVector(number) || (Dot(d, d) == 0.0 && BeginVelocity(each) == BeginVelocity(*first)),
            "motions that begin with one wind and one velocity");
  }
  require(first != nullptr, "none without a motion");
}

// Lets the branch of a fine strip be sought on one of half its edges, where all can be read of it.
void SearchCoarserStrip(const std::string& spec, Experiment& experiment) {
  constexpr int kFine = 300;  // vertices
  const std::size_t edges = spec.rfind('x') + 1;
  if (!spec.starts_with("strip:") || experiment.mesh.num_vertices() < kFine || experiment.motion)
    return;
  experiment.search_mesh =
      ParseMeshSpec(spec.substr(0, edges) + std::to_string(std::stoi(spec.substr(edges)) / 2));
  try {
    CheckSearchMesh(experiment, "");
  } catch (const InputError&) {
    experiment.search_mesh = {};
  }
}

Experiment ReadExperiment(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys(
      {"name", "mesh", "search_mesh", "scene", "start", "random_starts", "motion", "measurements"});
  Experiment experiment;
  if (input.Has("name")) experiment.name = input.At("name").String();
  experiment.mesh = ReadMesh(input.At("mesh"), folder);
  if (input.Has("search_mesh")) experiment.search_mesh = ReadMesh(input.At("search_mesh"), folder);
  const JsonInput scene = input.At("scene");
  experiment.scene = ReadSceneOrFile(scene, folder);
  if (input.Has("start"))
    experiment.start = ReadNamed(input.At("start"), folder, [&](const std::string& path) {
      return ReadStart(path, experiment.mesh, SupportRadius(experiment.scene).value_or(0.0)).x;
    });
  if (input.Has("random_starts"))
    experiment.random_starts = input.At("random_starts").IntegerWithin(0, INT_MAX);
  if (input.Has("motion")) ReadMotion(input.At("motion"), experiment);
  const JsonInput measurements = input.At("measurements").ExpectArray();
  const ClothModel model = NamingKey(scene.Name(), [&] { return MakeModel(experiment); });
  for (int i = 0; i < measurements.Size(); ++i)
    for (Measurement& each : ReadMeasurement(measurements.At(i), folder, model)) {
      if (experiment.motion) measurements.At(i).At("step");
      experiment.in_newtons |= measurements.At(i).Has("force");
      if (!experiment.motion && experiment.start.size() == 0) experiment.start = each.start;
      experiment.measurements.push_back(std::move(each));
    }
  if (!input.Has("search_mesh")) SearchCoarserStrip(input.At("mesh").String(), experiment);
  return experiment;
}

}  // namespace

void CompleteExperiments(ExperimentFile& file, const std::string& where) {
  if (file.density != 0.0) {
    RequireWithin(file.density, 1e-4, 10.0, where, "density");
    CheckUsual(where + ": key 'density'", file.density, "kg/m2", 0.01, 1.5);
  }
  Require(!file.experiments.empty(), where, "none", "at least one experiment");
  for (std::size_t i = 0; i < file.experiments.size(); ++i) {
    Experiment& each = file.experiments[i];
    if (each.name.empty()) each.name = "experiment_" + std::to_string(i + 1);
    Complete(each, Format("%s: key 'experiments[%zu]'", where.c_str(), i));
  }
  for (std::size_t i = 0; i < file.fitted.size(); ++i)
    RequireSeen(file, i, Format("%s: key 'fit[%zu]'", where.c_str(), i));
}

ExperimentFile ReadExperiments(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  input.ExpectKeys({"material", "density", "lab_tests", "fit", "experiments"});
  const std::string folder = fs::path(path).parent_path().string();
  ExperimentFile file;
  if (input.Has("material")) file.material = ResolvePath(input.At("material"), folder);
  if (input.Has("density")) file.density = input.At("density").NumberWithin(1e-4, 10.0);
  if (input.Has("lab_tests"))
    for (int i = 0; i < input.At("lab_tests").ExpectArray().Size(); ++i)
      file.lab_measurements.push_back(ResolvePath(input.At("lab_tests").At(i), folder));
  for (int i = 0; input.Has("fit") && i < input.At("fit").ExpectArray().Size(); ++i) {
    const JsonInput name = input.At("fit").At(i);
    file.fitted.push_back(ParseName<FreeNumber>(name.String(), name.Name()));
  }
  const JsonInput experiments = input.At("experiments");
  for (int i = 0; i < experiments.ExpectArray().Size(); ++i)
    file.experiments.push_back(ReadExperiment(experiments.At(i), folder));
  CompleteExperiments(file, path);
  return file;
}

}  // namespace drape
