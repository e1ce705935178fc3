// SPDX-License-Identifier: Apache-2.0
// drapefit._core: the library for Python, arrays with one row for each drape. drapefit/__init__.py
// gives them the shapes that it documents.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <utility>

#include "physics/cloth/scene_io.h"
#include "physics/cloth/state.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "solver/drapefit.h"
#include "solver/job/fit_report.h"
#include "solver/prediction/garment/wear_job.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/fit_options.h"
#include "tools/inputs/scene_input.h"

namespace py = pybind11;

namespace drape {
namespace {

constexpr std::chrono::milliseconds kPoll(50);

// Waits without the lock of the interpreter, so that other threads of Python run. False after
// Ctrl-C.
template <class Result>
bool Await(const std::future<Result>& result) {
  const auto is_done = [&] {
    const py::gil_scoped_release unlocked;
    return result.wait_for(kPoll) == std::future_status::ready;
  };
  while (!is_done())
    if (PyErr_CheckSignals() != 0) return false;
  return true;
}

// Ctrl-C cancels the work.
template <class Work>
auto RunUnlocked(const Work& work) {
  std::atomic<bool> cancel = false;
  auto result = std::async(std::launch::async, [&] { return work(cancel); });
  if (!Await(result)) {
    cancel = true;
    const py::gil_scoped_release unlocked;
    result.wait();
  }
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  return result.get();
}

// Runs work that owns what it reads and has parts that know no interruption: Ctrl-C turns *cancel
// true and leaves the work to its thread.
template <class Work>
auto RunApart(Work work, std::atomic<bool>* cancel = nullptr) {
  std::packaged_task<decltype(work())()> task(std::move(work));
  auto result = task.get_future();
  std::thread(std::move(task)).detach();
  if (Await(result)) return result.get();
  if (cancel != nullptr) *cancel = true;
  throw py::error_already_set();
}

// A function that knows no interruption, with copies of its arguments.
template <class Result, class... Args>
auto Alone(Result (*work)(Args...)) {
  return [=](const std::decay_t<Args>&... args) { return RunApart([=] { return work(args...); }); };
}

Mesh MeshFromArrays(const RowMatrix& vertices, const std::vector<std::array<int, 3>>& faces,
                    const RowMatrix& uv) {
  if (vertices.cols() != 3 || uv.cols() != 2 || uv.rows() != vertices.rows())
    throw InputError("mesh", "expected vertices of the shape [V, 3] and uv of the shape [V, 2]");
  return BuildMesh(vertices.reshaped<Eigen::RowMajor>(), uv.transpose(), faces, "mesh");
}

MeasuredImage MeasureFile(const std::string& path, const std::string& camera_file, double specimen,
                          double support) {
  const DrapeDiscs discs = FindDiscs({specimen, support}, {path});
  CameraInput camera;
  camera.file = camera_file;
  return MeasureImage(ReadSilhouette(path), camera, CentreMode::kOutline, discs, path);
}

Eigen::VectorXd ReadRadii(const MeasuredImage& image, int num_angles) {
  Outline outline;
  if (num_angles < 1 || !OutlineFromImage(image.image, image.camera, num_angles, &outline))
    throw InputError("outline", "expected one angle or more, with cloth at each");
  return outline.radius;
}

RowMatrix Coverage(const MeasuredImage& image) {
  RowMatrix coverage(image.image.height, image.image.width);
  std::copy(image.image.coverage.begin(), image.image.coverage.end(), coverage.data());
  return coverage;
}

void BindInputs(py::module_& m) {
  py::class_<Material>(m, "Material")
      .def(py::init([](const std::string& json, const std::string& name) {
        return ParseMaterial(json, name);
      }))
      .def_readonly("name", &Material::name)
      .def_readonly("warnings", &Material::warnings)
      .def("to_json", [](const Material& self) { return MaterialText(self); })
      .def("write",
           [](const Material& self, const std::string& path) { WriteMaterial(path, self); });
  m.def("read_material", [](const std::string& path) { return ReadMaterial(path); });
  py::class_<Mesh>(m, "Mesh")
      .def(py::init(&MeshFromArrays))
      .def_readonly("rest", &Mesh::rest_x)
      .def_property_readonly("uv",
                             [](const Mesh& self) -> RowMatrix { return self.uv.transpose(); })
      .def_property_readonly("faces", &ListTriangles)
      .def("write", [](const Mesh& self, const std::string& path, const Eigen::VectorXd& x) {
        if (x.size() != self.rest_x.size()) throw InputError("positions", "are of another mesh");
        WriteObj(path, self, x);
      });
  m.def("read_mesh", Alone(+[](const std::string& spec, bool round_to_float) {
          return ParseMeshSpec(spec, {.round_to_float = round_to_float});
        }));
  py::class_<Camera>(m, "Camera", "Looks down on the support; pixel centres are at integers.")
      .def_readwrite("width", &Camera::width, "px")
      .def_readwrite("height", &Camera::height, "px")
      .def_readwrite("cx", &Camera::cx, "column of the support's centre, px")
      .def_readwrite("cy", &Camera::cy, "row of the support's centre, px")
      .def_readwrite("scale", &Camera::scale, "of an orthographic camera, px/m")
      .def_property_readonly("pixels_per_metre",
                             [](const Camera& self) { return self.pixels_per_metre(); });
  m.def("camera_json", [](const Camera& camera) { return CameraJson(camera).dump(); });
  m.def("read_camera", py::overload_cast<const std::string&>(&ReadCamera));
  py::class_<MeasuredImage>(m, "Silhouette", "The silhouette of a drape and its camera.")
      .def_readonly("camera", &MeasuredImage::camera)
      .def_property_readonly("coverage", &Coverage, "of each pixel by cloth, 0 to 1, [H, W]")
      .def_property_readonly("notes", [](const MeasuredImage& self) { return self.quality.notes; })
      .def("outline", &ReadRadii, py::arg("num_angles") = 360,
           "Radii about the camera's centre at equal angles, px, [K].");
  m.def("read_silhouette", Alone(&MeasureFile));
}

// A cloth in a scene and what simulates it, which one thread at a time uses.
struct Simulator {
  SceneInput input;
  DrapeDiscs discs;
  std::shared_ptr<const ClothModel> model;
  std::string device;  // "2 CPU threads"
  std::unique_ptr<Backend> backend;
  std::timed_mutex in_use;

  Simulator(const Mesh& mesh, const std::string& scene, const std::string& law,
            const std::string& contact, double specimen, double support,
            const std::string& backend_name, int threads)
      : discs(FindDiscs({specimen, support})) {
    input.mesh = "mesh";
    input.start = "start";
    input.law = law;
    input.scene = scene;
    input.contact.model = ParseName<ContactModel>(contact, "contact");
    model = MakeSceneModel(input, mesh, discs);
    if (threads < 0) throw InputError("threads", "expected 0, all cores, or more");
    backend = MakeBackend(backend_name, model, CountThreads(threads), &device);
  }
  // Another thread may have the simulator for long.
  std::unique_lock<std::timed_mutex> Take(const std::atomic<bool>& cancel) {
    std::unique_lock lock(in_use, std::defer_lock);
    while (!lock.try_lock_for(kPoll))
      if (cancel) throw InputError("simulator", "is in use");
    return lock;
  }
  double support_radius() const {
    const std::optional<double> radius = SupportRadius(model->scene);
    if (!radius) throw InputError("start", "is made for a support, which the scene does not have");
    return *radius;
  }
};

void BindSimulator(py::module_& m) {
  py::class_<Simulator, std::shared_ptr<Simulator>>(m, "Simulator")
      .def(py::init(Alone(+[](const Mesh& mesh, const std::string& scene, const std::string& law,
                              const std::string& contact, double specimen, double support,
                              const std::string& backend, int threads) {
        return std::make_shared<Simulator>(mesh, scene, law, contact, specimen, support, backend,
                                           threads);
      })))
      .def_readonly("device", &Simulator::device, "what it runs on")
      .def_property_readonly("camera",
                             [](const Simulator& self) { return CameraAbove(self.discs); })
      .def("random_start",
           [](const Simulator& self, uint64_t seed, double hem_rms) {
             if (!(hem_rms >= 0.0)) throw InputError("hem_rms", "expected 0 m or more");
             return ApplyStartShape(self.model->mesh, self.support_radius(),
                                    RandomStartShape(seed, hem_rms));
           })
      .def("read_start",
           [](const Simulator& self, const std::string& path) {
             const State start = ReadStart(path, self.model->mesh, self.support_radius());
             return std::make_pair(start.x, start.v);
           })
      .def("start_from_outline",
           [](const Simulator& self, const Eigen::VectorXd& outline, double lift) {
             if (outline.size() < 3 || !outline.allFinite() || !(lift > 0.0 && lift <= 1.0))
               throw InputError("start", "expected 3 finite radii or more and a lift in (0, 1]");
             return FlapsFromOutline(self.model->mesh, self.support_radius(), outline, lift);
           });
}

// The class Drapes of Python, which keeps its simulator.
struct Drapes {
  std::shared_ptr<Simulator> simulator;
  DrapeBatch batch;

  Drapes(std::shared_ptr<Simulator> from, const std::vector<Material>& materials,
         const DrapeInputs& inputs, const DrapeBatchOptions& options)
      : simulator(std::move(from)), batch(*simulator->backend, Tables(materials), inputs, options) {
    for (Eigen::Index i = 0; i < inputs.start.rows(); ++i)
      RequireFreeStart(simulator->input, *simulator->model, {inputs.start.row(i), {}});
    RunUnlocked([&](const std::atomic<bool>& cancel) {
      const auto lock = simulator->Take(cancel);
      batch.Run(&cancel);
    });
  }
  static std::vector<MaterialField> Tables(const std::vector<Material>& materials) {
    std::vector<MaterialField> tables;
    for (const Material& material : materials) tables.push_back(material.field);
    return tables;
  }
  // use(cancel)
  template <class Use>
  auto WithFrames(const Use& use) const {
    return RunUnlocked([&](const std::atomic<bool>& cancel) {
      const auto lock = simulator->Take(cancel);
      return use(cancel);
    });
  }
  // use(readout, cancel)
  template <class Use>
  auto With(const ReadoutChoice& choice, const Use& use) const {
    return RunUnlocked([&](const std::atomic<bool>& cancel) {
      if (choice.of == "features") RequireDiscs(*simulator->model, simulator->discs, "mesh");
      const auto readout = MakeReadout(choice, simulator->model->mesh, simulator->discs);
      const auto lock = simulator->Take(cancel);
      return use(*readout, cancel);
    });
  }
};

void BindFrames(py::class_<Drapes>& drapes) {
  drapes
      .def("read_frames",
           [](const Drapes& self) {
             const DrapeFrames frames = self.batch.Frames();
             return std::make_pair(frames.x, frames.v);
           })
      .def("jvp_frames",
           [](const Drapes& self, const DrapeInputs& change) {
             return self.WithFrames([&](const std::atomic<bool>& cancel) {
               const DrapeFrames frames = self.batch.FrameJvp(change, &cancel);
               return std::make_pair(frames.x, frames.v);
             });
           })
      .def("vjp_frames", [](const Drapes& self, const RowMatrix& dL_dx, const RowMatrix& dL_dv) {
        return self.WithFrames([&](const std::atomic<bool>& cancel) {
          return self.batch.FrameVjp({dL_dx, dL_dv}, &cancel);
        });
      });
}

void BindDrapes(py::module_& m) {
  py::class_<DrapeInputs>(m, "DrapeInputs")
      .def(py::init<RowMatrix, RowMatrix, RowMatrix, RowMatrix>())
      .def_readonly("log_factors", &DrapeInputs::log_factors)
      .def_readonly("start", &DrapeInputs::start)
      .def_readonly("velocity", &DrapeInputs::velocity)
      .def_readonly("dynamics", &DrapeInputs::dynamics);
  py::class_<ReadoutChoice>(m, "ReadoutChoice").def(py::init<std::string, Camera, int, double>());
  py::class_<Drapes> drapes(m, "Drapes");
  drapes
      .def(py::init([](std::shared_ptr<Simulator> simulator, const std::vector<Material>& materials,
                       const DrapeInputs& inputs, double h, int steps, const std::string& solve,
                       bool record, const std::vector<int>& frames) {
        if (solve != "dynamic" && solve != "hybrid")
          throw InputError("solve", "found '" + solve + "', expected dynamic or hybrid");
        const SolveMode mode = solve == "hybrid" ? SolveMode::kStatic : SolveMode::kDynamic;
        return std::make_unique<Drapes>(std::move(simulator), materials, inputs,
                                        DrapeBatchOptions{h, steps, mode, record, frames});
      }))
      .def_property_readonly("positions", [](const Drapes& self) { return self.batch.Positions(); })
      .def_property_readonly("velocities",
                             [](const Drapes& self) { return self.batch.Velocities(); })
      .def_property_readonly("found", [](const Drapes& self) { return self.batch.IsFound(); })
      .def_property_readonly("status", [](const Drapes& self) { return self.batch.status(); })
      .def_property_readonly("residual", [](const Drapes& self) { return self.batch.Residuals(); })
      .def("read",
           [](const Drapes& self, const ReadoutChoice& choice) {
             return self.With(choice, [&](const Readout& readout, const std::atomic<bool>&) {
               return self.batch.Read(readout);
             });
           })
      .def("jvp",
           [](const Drapes& self, const ReadoutChoice& choice, const DrapeInputs& change) {
             return self.With(choice, [&](const Readout& readout, const std::atomic<bool>& cancel) {
               return self.batch.Jvp(readout, change, &cancel);
             });
           })
      .def("vjp", [](const Drapes& self, const ReadoutChoice& choice, const RowMatrix& dL_dr) {
        return self.With(choice, [&](const Readout& readout, const std::atomic<bool>& cancel) {
          return self.batch.Vjp(readout, dL_dr, &cancel);
        });
      });
  BindFrames(drapes);
}

// A fabric of this name, of means where it has a table for each element.
Material NameFabric(const std::string& name, const MaterialField& field) {
  return {.name = name, .field = MeanTables(field)};
}

// Options of drape_fit as text.
using GivenOptions = std::map<std::string, std::string>;

// Sets the options but those of files and `others`.
FitSpec SetOptions(const GivenOptions& given, const std::set<std::string>& others,
                   FitToolOptions* options) {
  static const std::set<std::string> kOfFiles = {
      "images", "each",        "lab_tests", "experiment",    "fabric",  "ground_truth",
      "out",    "resume",      "data",      "data_fabric",   "samples", "captures",
      "face",   "data_source", "accuracy",  "accuracy_table"};
  OptionTable table = FitTable(*options);
  std::erase_if(table.options, [&](const Option& each) {
    return kOfFiles.contains(each.key) || others.contains(each.key);
  });
  for (const auto& [key, text] : given) table.Set(key, text, "fit");
  return MakeFitSpec(*options);
}

// use(spec, data, control)
template <class Use>
auto WithExperiment(const std::string& file, const GivenOptions& given, const Use& use) {
  FitToolOptions options;
  const FitSpec spec =
      SetOptions(given, {std::begin(kClothOptions), std::end(kClothOptions)}, &options);
  options.data.experiment = file;
  return RunUnlocked([&](const std::atomic<bool>& cancel) {
    return use(spec, options.data, RunControl{.cancel = &cancel});
  });
}

DrapeFit FitExperiment(const std::string& file, const GivenOptions& given) {
  return WithExperiment(file, given,
                        [](const FitSpec& spec, const FitData& data, const RunControl& control) {
                          return FitDrapes(spec, data, control);
                        });
}

std::unique_ptr<FitResiduals> MakeResiduals(const std::string& file, const GivenOptions& given) {
  return WithExperiment(file, given,
                        [](const FitSpec& spec, const FitData& data, const RunControl& control) {
                          return std::make_unique<FitResiduals>(spec, data, control);
                        });
}

// Residuals and their Jacobian; none: a cloth is not found.
using Linearised = std::optional<std::pair<Eigen::VectorXd, Eigen::MatrixXd>>;

DrapeFit FitImages(const std::vector<std::string>& images, const Material& start,
                   const GivenOptions& given) {
  FitToolOptions options;
  const FitSpec spec = SetOptions(given, {}, &options);
  ObservedFabric fabric{.drapes = {},
                        .start = start.field,
                        .density = options.data.density,
                        .specimens = options.data.specimens};
  return RunUnlocked([&](const std::atomic<bool>& cancel) {
    for (const std::string& image : images)
      if (!cancel) fabric.drapes.push_back(ReadImageObservation(image, spec.observation));
    return FitDrapes(spec, std::move(fabric), {.cancel = &cancel});
  });
}

// Shapes of one mesh as rows.
RowMatrix Rows(const std::vector<Eigen::VectorXd>& shapes) {
  RowMatrix rows(shapes.size(), shapes.empty() ? 0 : shapes[0].size());
  for (std::size_t i = 0; i < shapes.size(); ++i) rows.row(static_cast<int>(i)) = shapes[i];
  return rows;
}

void BindQuantities(py::module_& m) {
  py::class_<LaboratoryRow>(m, "Quantity", "A number of a laboratory's sheet.")
      .def_readonly("key", &LaboratoryRow::key)
      .def_readonly("name", &LaboratoryRow::name)
      .def_readonly("value", &LaboratoryRow::value)
      .def_readonly("unit", &LaboratoryRow::unit)
      .def_readonly("source", &LaboratoryRow::source, "measured, from the prior, given, ...")
      .def_readonly("standard", &LaboratoryRow::standard)
      .def_property_readonly("measured", &LaboratoryRow::measured)
      .def("__str__", &LaboratoryRow::Text)
      .def_property_readonly(
          "interval",
          [](const LaboratoryRow& self) -> std::optional<std::pair<double, double>> {
            if (!self.interval) return std::nullopt;
            return std::make_pair(self.interval->low, self.interval->high);
          },
          "of 90 %, or None; an infinite end: the value is a bound");
  py::class_<PosteriorQuantity, LaboratoryRow>(m, "PosteriorQuantity")
      .def_property_readonly("samples", [](const PosteriorQuantity& self) {
        return Eigen::VectorXd::Map(self.samples.data(), std::ssize(self.samples)).eval();
      });
}

void BindFits(py::module_& m) {
  py::class_<DrapeFit>(m, "Fit", "What a fit has found.")
      .def_property_readonly("fitted", &DrapeFit::fitted)
      .def_readonly("notes", &DrapeFit::notes)
      .def_property_readonly("sheet", [](const DrapeFit& self) { return self.sheet.rows; })
      .def_property_readonly("grade",
                             [](const DrapeFit& self) { return ToString(self.verdict.grade); })
      .def_property_readonly("reasons", [](const DrapeFit& self) { return self.verdict.reasons; })
      .def_property_readonly("lamps",
                             [](const DrapeFit& self) {
                               const FitVerdict& verdict = self.verdict;
                               return std::map<std::string, std::string>{
                                   {"measurement", ToString(verdict.measurement.grade)},
                                   {"shape", ToString(verdict.shape.grade)},
                                   {"bending", ToString(verdict.bending.grade)}};
                             })
      .def_property_readonly("material",
                             [](const DrapeFit& self) {
                               if (!self.fitted()) throw InputError("fit", "has found no material");
                               return NameFabric("fitted", self.material);
                             })
      .def_property_readonly("_measurements",
                             [](const DrapeFit& self) {
                               py::list rows;
                               for (const MeasurementReport& each : self.report->measurements)
                                 rows.append(py::make_tuple(each.experiment, each.name, each.count,
                                                            each.misfit, each.largest));
                               return rows;
                             })
      .def_property_readonly(
          "_dynamics",
          [](const DrapeFit& self) {
            py::list rows;
            for (const DynamicsReport& each : self.report->dynamics)
              rows.append(py::make_tuple(ToString(each.number), each.values, each.sd));
            return rows;
          })
      .def_property_readonly("_mesh", [](const DrapeFit& self) { return self.cloth->mesh; })
      .def_property_readonly("_drapes", [](const DrapeFit& self) { return Rows(self.drapes); });
  m.def("fit", &FitImages);
  m.def("fit_experiment", &FitExperiment);
}

void BindResiduals(py::module_& m) {
  py::class_<FitResiduals>(m, "Residuals")
      .def(py::init(&MakeResiduals))
      .def_property_readonly("num_parameters", &FitResiduals::num_parameters)
      .def("start_from_last", &FitResiduals::StartFromLast)
      .def("evaluate",
           [](FitResiduals& self, const Eigen::VectorXd& theta) {
             return RunUnlocked([&](const std::atomic<bool>&) -> std::optional<Eigen::VectorXd> {
               Eigen::VectorXd residual;
               if (!self.Evaluate(theta, &residual, nullptr)) return std::nullopt;
               return residual;
             });
           })
      .def("linearise", [](FitResiduals& self, const Eigen::VectorXd& theta) {
        return RunUnlocked([&](const std::atomic<bool>&) -> Linearised {
          Linearised::value_type found;
          if (!self.Evaluate(theta, &found.first, &found.second)) return std::nullopt;
          return found;
        });
      });
}

void BindPosteriors(py::module_& m) {
  py::class_<Posterior>(m, "Posterior", "Samples of the posterior of a fabric.")
      .def_readonly("pareto_k", &Posterior::pareto_k, "below 0.7 the samples are reliable")
      .def_property_readonly("fabrics",
                             [](const Posterior& self) {
                               std::vector<Material> fabrics;
                               for (const MaterialField& field : self.fabrics)
                                 fabrics.push_back(NameFabric("sample", field));
                               return fabrics;
                             })
      .def_readonly("_quantities", &Posterior::quantities);
  m.def("sample_posterior", Alone(&SamplePosterior));
}

using Faces = std::vector<std::array<int, 3>>;

// The times of all frames [s], positions [m] and faces of the garment, those of the body, the
// smallest gap between them [m], and how many faces have met.
std::tuple<std::vector<double>, RowMatrix, Faces, RowMatrix, Faces, double, int> WearPattern(
    const std::string& file, const Material& fabric, const std::string& body, double edge,
    int frames, double friction, bool self_contact, const std::string& law, int threads) {
  WearSpec spec{.garment = file, .body = body, .edge = edge, .seconds = .04 * frames, .law = law};
  spec.wear.friction = friction;
  spec.wear.self_contact = self_contact;
  const auto cancel = std::make_shared<std::atomic<bool>>(false);
  const auto work = [=] {
    std::vector<double> time;
    std::vector<Eigen::VectorXd> cloth, bodies;
    Faces faces, body_faces;
    double gap = std::numeric_limits<double>::infinity();
    int met = 0;
    const auto add = [&](const SewnGarment& sewn, const Body& wearer, const WornFrame& frame) {
      faces = ListTriangles(sewn.model->mesh);
      body_faces = wearer.triangles();
      time.push_back(frame.time);
      cloth.push_back(frame.cloth.x);
      bodies.push_back(frame.body);
      gap = std::min(gap, frame.smallest_gap);
      met += frame.body_intersections + frame.self_intersections;
    };
    const GarmentResult result =
        RunWearJob(spec, {.step_threads = CountThreads(threads), .backend = "cpu", .on_frame = add},
                   [&](const ClothModel&) { return [&](int) { return fabric.field; }; },
                   {.cancel = cancel.get()});
    const WearResult& wear = result.runs[0].wear;
    if (wear.status == WearStatus::kFailed) throw std::runtime_error(wear.reason);
    return std::make_tuple(time, Rows(cloth), faces, Rows(bodies), body_faces, gap, met);
  };
  return RunApart(work, cancel.get());
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      std::rethrow_exception(std::move(error));
    } catch (const InputError& bad) {
      PyErr_SetString(PyExc_ValueError, bad.what());
    }
  });
  BindInputs(m);
  BindSimulator(m);
  BindDrapes(m);
  BindQuantities(m);
  BindFits(m);
  BindResiduals(m);
  BindPosteriors(m);
  m.def("wear", &WearPattern);
  m.attr("FEATURES") =
      std::vector<std::string>(kShapeFeatureNames.begin(), kShapeFeatureNames.end());
}

}  // namespace drape
