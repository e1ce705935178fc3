// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/speed_table.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "cuda/make_backend.h"
#include "physics/cloth/cloth_model.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/build.h"
#include "solver/studies/bench/cases/run_times.h"

namespace drape {
namespace {

using nlohmann::json;

std::vector<double> ReadSpeeds(const JsonInput& row, const char* key, std::size_t count) {
  if (!row.Has(key)) return {};
  const Eigen::VectorXd speeds = row.At(key).Vector(static_cast<int>(count));
  for (int i = 0; i < speeds.size(); ++i) row.At(key).At(i).NotNegative();
  return {speeds.begin(), speeds.end()};
}

NegativeEntries PolicyFor(const Law& law) {
  return law.rejects_negative_entries() ? NegativeEntries::kReject : NegativeEntries::kWarn;
}

std::shared_ptr<const ClothModel> MakeModel(const SpeedJob& job, const std::string& mesh) {
  const Law law = MakeLaw(job.law);
  return std::make_shared<ClothModel>(
      ParseMeshSpec(mesh, {.round_to_float = !law.rejects_negative_entries()}), CusickScene(), law);
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
        model_(MakeModel(job, mesh)),
        material_(ReadMaterial(job.material, {PolicyFor(model_->law)}).field),
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

// One process; false when cancelled.
bool MeasureInChild(const SpeedJob& job, bool gradient, double idle_bytes,
                    const RunControl& control, MeasuredSpeed* row) {
  const ChildResult child = RunInChild(
      [&] { return Timer(job, row->mesh, row->batch).Measure(gradient).dump(); }, control.cancel);
  if (child.cancelled || control.cancelled()) return false;
  const json found = json::parse(child.output);
  row->device = found.at("device");
  row->vertices = found.at("vertices");
  row->repeats = found.at("repeats");
  (gradient ? row->gradient : row->forward) = found.at("seconds");
  (gradient ? row->gradient_spread : row->forward_spread) = found.at("spread");
  (gradient ? row->gradient_mb : row->forward_mb) =
      (child.peak_bytes - idle_bytes) / kBytesPerMegabyte;
  return true;
}

}  // namespace

PublishedSpeeds ReadPublishedSpeeds(const std::string& path) {
  const json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  input.ExpectKeys({"vertices", "rows"});
  PublishedSpeeds speeds;
  const JsonInput vertices = input.At("vertices").ExpectArray(), rows = input.At("rows");
  for (int i = 0; i < vertices.Size(); ++i) {
    constexpr int kMostVertices = 10'000'000;
    speeds.vertices.push_back(vertices.At(i).IntegerWithin(3, kMostVertices));
  }
  for (int i = 0; i < rows.ExpectArray().Size(); ++i) {
    const JsonInput row =
        rows.At(i).ExpectKeys({"name", "machine", "source", "forward_s", "backward_s"});
    speeds.rows.push_back({row.At("name").String(), row.At("machine").String(),
                           row.At("source").String(),
                           ReadSpeeds(row, "forward_s", speeds.vertices.size()),
                           ReadSpeeds(row, "backward_s", speeds.vertices.size())});
  }
  return speeds;
}

SpeedTable MeasureSpeeds(const SpeedJob& job, const RunControl& control) {
  ReadMaterial(job.material, {PolicyFor(MakeLaw(job.law))});
  for (const std::string& mesh : job.meshes) ParseMeshSpec(mesh);
  SpeedTable table{.cpu = ProcessorName()};
  const double idle_bytes = RunInChild([] { return std::string(); }, nullptr).peak_bytes;
  const double count = 2.0 * static_cast<double>(job.meshes.size() * job.batches.size());
  double done = 0.0;
  for (const std::string& mesh : job.meshes)
    for (const int batch : job.batches) {
      MeasuredSpeed row{.mesh = mesh, .batch = batch};
      for (const bool gradient : {false, true}) {
        control.Report(done++ / count, mesh + (gradient ? ", gradient" : ", forward"));
        table.cancelled = !MeasureInChild(job, gradient, idle_bytes, control, &row);
        if (table.cancelled) return table;
      }
      table.rows.push_back(row);
    }
  return table;
}

}  // namespace drape
