// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/cuda_backend.h"

#include <glog/logging.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "cuda/engine/equilibrium_engine.h"
#include "cuda/engine/history.h"
#include "cuda/engine/rollout_engine.h"
#include "cuda/factor/multifrontal.h"
#include "physics/util/errors.h"
#include "physics/util/run_control.h"

namespace drape {
namespace {

// What runs on one device.
struct DeviceEngine {
  DeviceEngine(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
               const DeviceInfo& device, int threads)
      : resources(std::move(model), plan, device, threads) {}

  DeviceResources resources;
  RolloutEngine rollouts{resources};
  EquilibriumEngine equilibria{resources};
};

// A part of a batch that one device works on.
struct Share {
  DeviceEngine* engine;
  std::size_t first, count;

  // Its part of a list over the batch.
  template <class List>
  auto Of(List& list) const {
    return std::span(list).subspan(first, count);
  }
};

// Throws InputError where air acts, or a rollout wants a derivative by it, in a scene without
// stretch: the device then has no faces.
void RequireNoAir(std::span<const RolloutInput> batch, bool has_faces,
                  bool (*wants_derivative)(const RolloutInput&)) {
  if (has_faces) return;
  for (const RolloutInput& input : batch)
    if (input.material->dynamics.air_drag != 0.0 || wants_derivative(input))
      throw InputError(
          "cuda",
          "found drag of air, or a derivative by it, in a scene without stretch, which "
          "only the CPU backend computes");
}
bool WantsNothing(const RolloutInput& /*input*/) { return false; }

// CHECKs the shapes of what the tangents of a batch begin with.
void CheckStartColumns(std::span<const RolloutInput> batch, int dofs) {
  for (const RolloutInput& input : batch) {
    if (input.tangent == nullptr) continue;
    const RowMatrix &dx = input.tangent->start_dx, &dv = input.tangent->start_dv;
    CHECK((dx.size() == 0 || dx.rows() == dofs) && (dv.size() == 0 || dv.rows() == dofs) &&
          (dx.size() == 0 || dv.size() == 0 || dx.cols() == dv.cols()))
        << "TangentOptions";
  }
}

class CudaBackend final : public Backend {
 public:
  CudaBackend(std::shared_ptr<const ClothModel> model, const std::vector<DeviceInfo>& devices,
              int threads)
      : model_(std::move(model)), host_(MakeCpuBackend(model_, threads)) {
    int shared_bytes = devices[0].shared_bytes;
    for (const DeviceInfo& device : devices)
      shared_bytes = std::min(shared_bytes, device.shared_bytes);
    const FrontPlan plan =
        MakeFrontPlan(model_->pattern, model_->mesh.uv, {.shared_bytes = shared_bytes});
    const int share = std::max(1, threads / static_cast<int>(devices.size()));
    for (const DeviceInfo& device : devices)
      engines_.push_back(std::make_unique<DeviceEngine>(model_, plan, device, share));
  }

  std::string name() const override { return "cuda"; }
  const ClothModel& model() const override { return *model_; }
  int threads() const override { return host_->threads(); }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options,
                                      std::vector<Recording>* recordings) override {
    options.Check();
    RequireNoAir(batch, model_->scene.stretch, WantsNothing);
    std::vector<RolloutResult> results(batch.size());
    std::vector<char> failed(batch.size());
    if (recordings != nullptr) recordings->assign(batch.size(), {});
    const std::span<Recording> kept =
        recordings == nullptr ? std::span<Recording>() : std::span(*recordings);
    SplitOverDevices(batch.size(), [&](const Share& s) {
      s.engine->rollouts.Rollouts(s.Of(batch), options, kept.empty() ? kept : s.Of(kept),
                                  s.Of(results), s.Of(failed));
    });
    for (const std::size_t i : Indices(failed)) {
      std::vector<Recording> recording;
      results[i] = std::move(
          host_->Rollouts(batch.subspan(i, 1), options, kept.empty() ? nullptr : &recording)[0]);
      if (!kept.empty()) kept[i] = std::move(recording[0]);
    }
    return results;
  }

  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions& options) override {
    options.Check();
    RequireNoAir(batch, model_->scene.stretch, WantsTangent);
    CheckStartColumns(batch, model_->num_dofs());
    CHECK_EQ(weights.size(), batch.size());
    std::vector<TangentResult> results(batch.size());
    std::vector<char> failed(batch.size());
    SplitOverDevices(batch.size(), [&](const Share& s) {
      s.engine->rollouts.Tangents(s.Of(batch), s.Of(weights), options, s.Of(results), s.Of(failed));
    });
    for (const std::size_t i : Indices(failed))
      results[i] =
          std::move(host_->Tangents(batch.subspan(i, 1), weights.subspan(i, 1), options)[0]);
    return results;
  }

  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording> recordings,
                                      std::span<const RowMatrix> dL_dx,
                                      const RolloutOptions& options) override {
    options.Check();
    RequireNoAir(batch, model_->scene.stretch, WantsAdjoint);
    for (const RolloutInput& input : batch)
      CHECK(input.adjoint == nullptr || input.adjoint->frames.empty() ||
            input.adjoint->frames.size() == options.frames.size())
          << "AdjointOptions";
    CHECK_EQ(recordings.size(), batch.size());
    CHECK_EQ(dL_dx.size(), batch.size());
    std::vector<AdjointResult> results(batch.size());
    std::vector<char> failed(batch.size());
    std::map<DeviceEngine*, std::vector<std::vector<std::size_t>>> of_engine;
    for (auto& [key, members] : GroupAdjoints(recordings, dL_dx))
      of_engine[key.engine].push_back(members);
    std::vector<std::function<void()>> work;
    for (const auto& [engine, groups] : of_engine)
      work.push_back([&, engine = engine, &groups = groups] {
        for (const std::vector<std::size_t>& members : groups)
          RunAdjoints(*engine, members, batch, recordings, dL_dx, options, results, failed);
      });
    RunConcurrently(work);
    for (const std::size_t i : Indices(failed))
      results[i] = AdjointOnHost(batch[i], dL_dx[i], options);
    return results;
  }

  std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                            const EquilibriumOptions& options) override {
    std::vector<EquilibriumResult> results(batch.size());
    SplitOverDevices(batch.size(), [&](const Share& s) {
      s.engine->equilibria.Equilibria(s.Of(batch), options, s.Of(results));
    });
    return results;
  }

  std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) override {
    CHECK_EQ(weights.size(), batch.size());
    std::vector<RowMatrix> results(batch.size());
    SplitOverDevices(batch.size(), [&](const Share& s) {
      s.engine->equilibria.Tangents(s.Of(batch), s.Of(weights), s.Of(results));
    });
    return results;
  }

  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    CHECK_EQ(changes.size(), batch.size());
    std::vector<Eigen::VectorXd> results(batch.size());
    SplitOverDevices(batch.size(), [&](const Share& s) {
      s.engine->equilibria.Jvp(s.Of(batch), s.Of(changes), s.Of(results));
    });
    return results;
  }

  std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix> dL_dx) override {
    CHECK_EQ(dL_dx.size(), batch.size());
    std::vector<std::optional<MaterialGradient>> results(batch.size());
    std::map<Eigen::Index, std::vector<std::size_t>> groups;  // by the number of columns
    for (std::size_t i = 0; i < dL_dx.size(); ++i) groups[dL_dx[i].cols()].push_back(i);
    for (const auto& [columns, members] : groups) {
      std::vector<RolloutInput> inputs;
      std::vector<const RowMatrix*> of_inputs;
      for (const std::size_t i : members) {
        inputs.push_back(batch[i]);
        of_inputs.push_back(&dL_dx[i]);
      }
      std::vector<std::optional<MaterialGradient>> found(members.size());
      SplitOverDevices(members.size(), [&](const Share& s) {
        s.engine->equilibria.Adjoints(s.Of(inputs), s.Of(of_inputs), s.Of(found));
      });
      for (std::size_t k = 0; k < members.size(); ++k) results[members[k]] = std::move(found[k]);
    }
    return results;
  }

 private:
  static std::vector<std::size_t> Indices(const std::vector<char>& flags) {
    std::vector<std::size_t> set;
    for (std::size_t i = 0; i < flags.size(); ++i)
      if (flags[i] != 0) set.push_back(i);
    return set;
  }

  // Runs each work on a thread of its own, waits for all and rethrows an exception of one.
  static void RunConcurrently(const std::vector<std::function<void()>>& work) {
    if (work.size() == 1) return work[0]();
    const int count = static_cast<int>(work.size());
    RunInThreads(count, count, nullptr, [&](int i) { work[i](); });
  }

  // Splits a batch evenly over the devices.
  void SplitOverDevices(std::size_t count, const std::function<void(const Share&)>& work) {
    std::vector<std::function<void()>> shares;
    const std::size_t devices = std::min(engines_.size(), count);
    for (std::size_t d = 0; d < devices; ++d) {
      const std::size_t first = count * d / devices, last = count * (d + 1) / devices;
      shares.push_back([&, d, first, last] { work({engines_[d].get(), first, last - first}); });
    }
    RunConcurrently(shares);
  }

  // Adjoints that run as one batch: on the device that has the recording, as many columns.
  struct AdjointKey {
    DeviceEngine* engine;
    Eigen::Index columns;
    int steps;
    auto operator<=>(const AdjointKey&) const = default;
  };
  std::map<AdjointKey, std::vector<std::size_t>> GroupAdjoints(
      std::span<const Recording> recordings, std::span<const RowMatrix> dL_dx) {
    std::map<AdjointKey, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < dL_dx.size(); ++i) {
      const auto* own = dynamic_cast<const DeviceRecording*>(recordings[i].backend.get());
      DeviceEngine* engine = engines_[i * engines_.size() / dL_dx.size()].get();
      if (own != nullptr)
        for (const auto& e : engines_)
          if (e->resources.device().index == own->history->device) engine = e.get();
      const int steps = own != nullptr ? own->steps : static_cast<int>(recordings[i].factor.size());
      groups[{engine, dL_dx[i].cols(), steps}].push_back(i);
    }
    return groups;
  }

  void RunAdjoints(DeviceEngine& engine, const std::vector<std::size_t>& members,
                   std::span<const RolloutInput> batch, std::span<const Recording> recordings,
                   std::span<const RowMatrix> dL_dx, const RolloutOptions& options,
                   std::vector<AdjointResult>& results, std::vector<char>& failed) {
    std::vector<RolloutInput> inputs;
    std::vector<const Recording*> kept;
    std::vector<const RowMatrix*> columns;
    for (const std::size_t i : members) {
      inputs.push_back(batch[i]);
      kept.push_back(&recordings[i]);
      columns.push_back(&dL_dx[i]);
    }
    std::vector<AdjointResult> found(members.size());
    std::vector<char> flags(members.size());
    engine.rollouts.Adjoints(inputs, kept, columns, options, found, flags);
    for (std::size_t k = 0; k < members.size(); ++k) {
      results[members[k]] = std::move(found[k]);
      failed[members[k]] = flags[k];
    }
  }

  AdjointResult AdjointOnHost(const RolloutInput& input, const RowMatrix& dL_dx,
                              const RolloutOptions& options) {
    std::vector<Recording> recording;
    host_->Rollouts({&input, 1}, options, &recording);
    return std::move(host_->Adjoints({&input, 1}, recording, {&dL_dx, 1}, options)[0]);
  }

  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<Backend> host_;  // what a device cannot decide
  std::vector<std::unique_ptr<DeviceEngine>> engines_;
};

}  // namespace

std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel> model, int threads) {
  std::string why;
  const std::vector<DeviceInfo> devices = FindDevices(&why);
  if (devices.empty()) throw NoDevice(why);
  return std::make_unique<CudaBackend>(std::move(model), devices, threads);
}

std::unique_ptr<LinearSolver> MakeCudaSolver(const BlockPattern& pattern) {
  std::string why;
  const std::vector<DeviceInfo> devices = FindDevices(&why);
  if (devices.empty()) throw NoDevice(why);
  return MakeDeviceSolver(pattern, devices.front());
}

CudaSurvey SurveyCuda() {
  std::string why;
  const std::vector<DeviceInfo> devices = FindDevices(&why);
  if (devices.empty()) return {false, why};
  std::string text = devices[0].name;
  if (devices.size() > 1) text += " and " + std::to_string(devices.size() - 1) + " more";
  return {true, text};
}

void WakeCuda() {
  for (const DeviceInfo& device : FindDevices())
    if (cudaSetDevice(device.index) == cudaSuccess) cudaFree(nullptr);
}

}  // namespace drape
