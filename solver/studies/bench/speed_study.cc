// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/speed_study.h"

#include <memory>
#include <optional>

#include "cuda/make_backend.h"
#include "physics/cloth/cloth_model.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/build.h"
#include "solver/studies/bench/bench_drape.h"

namespace drape {
namespace {

using nlohmann::json;

void CheckSpeeds(const JsonInput& row, const char* key, int count) {
  if (!row.Has(key)) return;
  row.At(key).Vector(count);
  for (int i = 0; i < count; ++i) row.At(key).At(i).NotNegative();
}

void Require(RolloutStatus status, const std::string& mesh) {
  if (status != RolloutStatus::kOk)
    throw InputError(mesh, std::string("the rollout failed: ") + ToString(status) +
                               ", expected a cloth, law and time step that can be simulated");
}

// Rollouts of one mesh and batch, in the process that calls it.
class Timer {
 public:
  Timer(const SpeedJob& job, const std::string& mesh, int batch)
      : job_(job),
        mesh_(mesh),
        model_(MakeBenchModel(mesh, MakeLaw(job.law))),
        material_(ReadMaterial(job.material, ReadingPolicy(model_->law)).field),
        backend_(MakeBackend(job.backend, model_, job.threads, &device_)),
        start_(model_->RestState()),
        batch_(batch, {&material_, &start_}),
        // The scalar is the sum of the heights at the end.
        seeds_(batch, HeightSum(model_->mesh)) {
    options_.h = job.h;
    options_.steps = job.steps;
  }

  void Forward() {
    for (const RolloutResult& drape : backend_->Rollouts(batch_, options_, nullptr))
      Require(drape.status, mesh_);
  }

  void Gradient() {
    for (const RolloutResult& drape : backend_->Rollouts(batch_, options_, &recordings_))
      Require(drape.status, mesh_);
    for (const AdjointResult& adjoint : backend_->Adjoints(batch_, recordings_, seeds_, options_)) {
      Require(adjoint.status, mesh_);
      adjoint.material.Contract(material_);
    }
  }

  json Measure(bool gradient) {
    const RunTimes times =
        TimeRuns([&] { gradient ? Gradient() : Forward(); }, job_.repeats, job_.seconds);
    const double runs = static_cast<double>(batch_.size()) * job_.steps;
    return {{"device", device_},
            {"processor", ProcessorName()},
            {"vertices", model_->mesh.num_vertices()},
            {"repeats", times.wall.size()},
            {"seconds", MedianTime(times.wall) / runs},
            {"spread", TimeSpread(times.wall) / runs}};
  }

 private:
  static RowMatrix HeightSum(const Mesh& mesh) {
    RowMatrix weights = RowMatrix::Zero(mesh.rest_x.size(), 1);
    for (int i = 0; i < mesh.num_vertices(); ++i) weights(3 * i + 2, 0) = 1.0;
    return weights;
  }

  const SpeedJob& job_;
  std::string mesh_, device_;
  std::shared_ptr<const ClothModel> model_;
  MaterialField material_;
  std::unique_ptr<Backend> backend_;
  State start_;
  std::vector<RolloutInput> batch_;
  std::vector<RowMatrix> seeds_;
  std::vector<Recording> recordings_;
  RolloutOptions options_;
};

}  // namespace

json ReadPublishedSpeeds(const std::string& path) {
  json file = ReadJsonFile(path);
  const JsonInput input = JsonInput(file, path).ExpectKeys({"vertices", "rows"});
  const JsonInput vertices = input.At("vertices").ExpectArray(), rows = input.At("rows");
  for (int i = 0; i < vertices.Size(); ++i) {
    constexpr int kMostVertices = 10'000'000;
    vertices.At(i).IntegerWithin(3, kMostVertices);
  }
  for (int i = 0; i < rows.ExpectArray().Size(); ++i) {
    const JsonInput row =
        rows.At(i).ExpectKeys({"name", "machine", "source", "forward_s", "backward_s"});
    for (const char* text : {"name", "machine", "source"}) row.At(text).String();
    for (const char* speeds : {"forward_s", "backward_s"})
      CheckSpeeds(row, speeds, vertices.Size());
  }
  return file;
}

Study MakeSpeedStudy(const SpeedJob& job) {
  struct Measurement {
    std::string mesh;
    int batch;
    bool gradient;
  };
  Study study;
  study.name = "speed";
  study.settings = job.settings;
  std::vector<Measurement> measurements;
  for (const std::string& mesh : job.meshes)
    for (const int batch : job.batches)
      for (const bool gradient : {false, true}) {
        const std::string part = gradient ? "gradient" : "forward";
        const std::string cloth = NameWithoutFolder(mesh);
        study.cells.push_back(
            CheckedCell(cloth + ", batch " + std::to_string(batch) + ", " + part,
                        {{"mesh", NameInKey(mesh)}, {"batch", batch}, {"part", part}}, [&] {
                          ReadMaterial(job.material, ReadingPolicy(MakeLaw(job.law)));
                          ParseMeshSpec(mesh);
                        }));
        study.cells.back().names["mesh"] = cloth;
        measurements.push_back({mesh, batch, gradient});
      }
  study.run = [job, measurements](std::size_t cell, const RunControl&) -> std::optional<json> {
    const auto& [mesh, batch, gradient] = measurements[cell];
    return Timer(job, mesh, batch).Measure(gradient);
  };
  return study;
}

}  // namespace drape
