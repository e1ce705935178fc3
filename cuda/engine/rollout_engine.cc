// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/rollout_engine.h"

#include <algorithm>
#include <utility>

#include "cuda/engine/frames.h"
#include "cuda/engine/history.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.h"

namespace drape {
namespace {

// The columns of the tangents of a batch: by entries, padded, then by numbers of DynamicsEntry
// where a rollout wants them, and by the start.
struct TangentLayout {
  static constexpr int kFirstNumber = kPaddedEntries;
  bool dynamics = false;  // of some rollout
  int first_of_start = kPaddedEntries;
  int columns = kPaddedEntries;

  explicit TangentLayout(std::span<const RolloutInput> batch) {
    dynamics = std::ranges::any_of(batch, WantsTangent);
    if (dynamics) first_of_start += kDynamicsEntries;
    int most = 0;
    for (const RolloutInput& input : batch) most = std::max(most, CountOfStart(input));
    columns = PaddedColumns(first_of_start + most);
  }
  static int CountOfStart(const RolloutInput& input) {
    if (input.tangent == nullptr) return 0;
    return static_cast<int>(
        std::max(input.tangent->start_dx.cols(), input.tangent->start_dv.cols()));
  }
  // The columns that a rollout wants, of all, shape [3V, columns].
  RowMatrix Select(const RowMatrix& all, const RolloutInput& input) const {
    const int numbers = WantsTangent(input) ? kDynamicsEntries : 0;
    const int of_start = CountOfStart(input);
    RowMatrix wanted(all.rows(), kMaterialEntries + numbers + of_start);
    wanted.leftCols<kMaterialEntries>() = all.leftCols<kMaterialEntries>();
    wanted.middleCols(kMaterialEntries, numbers) = all.middleCols(kFirstNumber, numbers);
    wanted.rightCols(of_start) = all.middleCols(first_of_start, of_start);
    return wanted;
  }
};

struct TangentWorkspace {
  StepWorkspace step;
  DerivativeRecords derivatives;
  FactorRecords factors;
  double* blocks;   // [9·num_blocks] a slot
  double *dx, *dv;  // [3V, columns]
  double* vectors;  // [vector_size, columns]

  static TangentWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots,
                               const TangentLayout& layout) {
    const std::size_t n = slots, columns = layout.columns;
    const ClothView& view = cloth.view();
    TangentWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                     arena.Take<HingeDerivative>(n * view.num_hinges)};
    w.factors = {arena.Take<FaceFactors>(n * view.num_faces),
                 arena.Take<HingeFactors>(n * view.num_hinges)};
    w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    w.dx = arena.Take<double>(n * view.num_dofs() * columns);
    w.dv = arena.Take<double>(n * view.num_dofs() * columns);
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    return w;
  }
};

// Leaves the place of damped velocities empty where no material is damped by its stiffness.
void ForgetDamping(std::span<const RolloutInput> batch, StepWorkspace& w) {
  if (std::ranges::none_of(batch, [](const RolloutInput& input) {
        return input.material->dynamics.stiffness_damping != 0.0;
      }))
    w.damped = nullptr;
}
// The velocities of a group of slots as elements see them in derivatives, from w.
const double* LaunchDamping(const LaunchContext& on, const StepWorkspace& step, std::int64_t first,
                            const double* w, double h) {
  if (step.damped == nullptr) return w;
  double* damped = step.damped + first * on.cloth.num_dofs();
  LaunchDampVelocity(on, w, h, damped);
  return damped;
}

// Whether air acts in some rollout of a batch.
bool InAir(std::span<const RolloutInput> batch) {
  return std::ranges::any_of(
      batch, [](const RolloutInput& input) { return input.material->dynamics.air_drag != 0.0; });
}

// A step of a batch with its derivatives.
struct TangentStep {
  const TangentWorkspace& w;
  const TangentLayout& layout;
  const MaterialView* scales;
  double h;
  bool in_air;
};

// Launches the step of a group of slots, from `first` on.
void LaunchTangentStep(const LaunchContext& on, const Multifrontal& multifrontal,
                       const TangentStep& tangent, std::int64_t first) {
  const TangentWorkspace& w = tangent.w;
  const PlanView& plan = multifrontal.view();
  const int columns = tangent.layout.columns;
  const double h = tangent.h;
  const std::int64_t dofs = on.cloth.num_dofs();
  const double* found = w.step.solution + first * dofs;
  double *dx = w.dx + first * dofs * columns, *dv = w.dv + first * dofs * columns;
  double* blocks = w.blocks + first * 9 * on.cloth.num_blocks;
  const DerivativeRecords derivatives = w.derivatives.From(on.cloth, first);
  const FactorRecords factors = w.factors.From(on.cloth, first);
  LaunchSolveStep(on, multifrontal, w.step, static_cast<int>(first), h);
  const double* seen = LaunchDamping(on, w.step, first, found, h);
  LaunchDerivativeRecords(on, seen, h, derivatives);
  LaunchFactorRecords(on, tangent.scales + first, seen, h, factors);
  LaunchGatherDerivative(on, derivatives, found, h, blocks);
  const MovingStepView step{w.step.v + first * dofs, found, h};
  if (tangent.in_air) LaunchAddAirTangent(on, step, dx, dv, columns);
  LaunchTangentRhs(on, factors, blocks, dx, dv, columns);
  if (tangent.layout.dynamics)
    LaunchDynamicsColumns(
        on, step,
        {.matrix = dv, .columns = columns, .first = TangentLayout::kFirstNumber, .adds = true});
  multifrontal.Solve(w.step.factor.From(first, plan.factor_size),
                     {dv, dv, w.vectors + first * columns * plan.vector_size, columns},
                     on.batch.slots, on.stream, {dx, h});
  LaunchAdvanceGroup(on, w.step, static_cast<int>(first), h, BlockedMove::kFails,
                     {nullptr, nullptr, 0, nullptr});
}

// The derivatives of the starts of a batch, `part` of TangentOptions, to [3V, columns] a slot.
void UploadStartColumns(const DeviceCloth& cloth, std::span<const RolloutInput> batch,
                        const TangentLayout& layout, RowMatrix TangentOptions::*part, double* to) {
  const int columns = layout.columns;
  const std::size_t dofs = cloth.view().num_dofs();
  std::vector<double> host(batch.size() * dofs * columns);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const int count = TangentLayout::CountOfStart(batch[i]);
    if (count == 0 || (batch[i].tangent->*part).size() == 0) continue;
    RowMatrix all = RowMatrix::Zero(dofs, columns);
    all.middleCols(layout.first_of_start, count) = batch[i].tangent->*part;
    cloth.ToEliminationOrder(all.data(), columns, columns, host.data() + i * dofs * columns);
  }
  CopyToDevice<double>(host, to);
}

// The steps that were done. at_frame: sees the workspace there.
int RunTangents(DeviceResources& resources, TangentWorkspace w, const TangentLayout& layout,
                std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
                const RolloutOptions& options, const std::function<void(int frame)>& at_frame) {
  const DeviceCloth& cloth = resources.cloth();
  const int slots = static_cast<int>(batch.size()), dofs = cloth.view().num_dofs();
  const DeviceMaterials materials(CollectMaterials(batch)), scales(weights);
  resources.UploadStarts(batch, w.step.x, w.step.v);
  resources.Clear(w.step.failed, slots * sizeof(int));
  UploadStartColumns(cloth, batch, layout, &TangentOptions::start_dx, w.dx);
  UploadStartColumns(cloth, batch, layout, &TangentOptions::start_dv, w.dv);
  ForgetDamping(batch, w.step);
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  LaunchPushOut(resources.On(shapes), w.step.x);
  const TangentStep tangent{w, layout, scales.views(), options.h, InAir(batch)};
  const Streams& streams = resources.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchTangentStep(resources.On(SliceBatch(shapes, first, count, dofs), stream),
                        cloth.multifrontal(), tangent, first);
    });
  });
  const int done =
      RunToFrames(resources, step, options.steps, options, StopsForwards(options), at_frame);
  streams.Synchronize();
  return done;
}

static_assert(kDynamicsNumbers == kDynamicsEntries && kByDensity == 0 && kByMassDamping == 1 &&
              kByStiffnessDamping == 2 && kByAirDrag == 3 && kByWind == 4);

// Workspace of the adjoint pass through recorded rollouts by slot.
struct AdjointWorkspace {
  StepWorkspace step;     // x: of the present step; v: its end
  AdjointRecords single;  // for one column; for more:
  DerivativeRecords derivatives;
  double* blocks;                  // [9·num_blocks] a slot
  double *adj_x, *adj_v, *lambda;  // [3V, columns]
  double* vectors;                 // [vector_size, columns]
  double *start_v, *before;        // [3V], before the first and the present step
  double* numbers;                 // [3V, 7], by the numbers of DynamicsEntry
  double* dynamics;                // [7, columns], the gradient by them

  static AdjointWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots, int columns) {
    const std::size_t n = slots;
    const ClothView& view = cloth.view();
    AdjointWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    if (columns == 1) {
      w.single = {arena.Take<DeformationGradient<double>>(n * view.num_faces),
                  arena.Take<BendAdjoint>(n * view.num_hinges)};
    } else {
      w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                       arena.Take<HingeDerivative>(n * view.num_hinges)};
      w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    }
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    w.adj_x = arena.Take<double>(n * view.num_dofs() * columns);
    w.adj_v = arena.Take<double>(n * view.num_dofs() * columns);
    w.lambda = arena.Take<double>(n * view.num_dofs() * columns);
    w.start_v = arena.Take<double>(n * view.num_dofs());
    w.before = arena.Take<double>(n * view.num_dofs());
    w.numbers = arena.Take<double>(n * view.num_dofs() * kDynamicsNumbers);
    w.dynamics = arena.Take<double>(n * kDynamicsNumbers * columns);
    return w;
  }
};

// One step back of a batch.
struct AdjointStep {
  const AdjointWorkspace& w;
  const HistorySlot* history;
  DeviceGradient& sums;
  double h;
  int columns;
  bool factors_kept;
  bool dynamics, in_air;
};

// Launches the step back of a group of slots, from `first` on.
void LaunchAdjointStep(const LaunchContext& on, const Multifrontal& multifrontal,
                       const AdjointStep& back, int first) {
  const AdjointWorkspace& w = back.w;
  const PlanView& plan = multifrontal.view();
  const int m = back.columns;
  const std::int64_t dofs = on.cloth.num_dofs(), columns = dofs * m;
  double *adj_x = w.adj_x + first * columns, *adj_v = w.adj_v + first * columns;
  double *lambda = w.lambda + first * columns, *end_v = w.step.v + first * dofs;
  LaunchLoadHistory(on, back.history + first, w.step.step, w.step.x + first * dofs, end_v);
  double* before = w.before + first * dofs;
  if (back.dynamics || back.in_air)
    LaunchLoadBefore(on, back.history + first, w.start_v + first * dofs, w.step.step, before);
  const MovingStepView step{before, end_v, back.h};
  LaunchAdjointRhs(on, adj_x, adj_v, back.h, lambda, m);
  // A single right-hand side is solved for during a new factorisation.
  if (!back.factors_kept)
    LaunchFactorStep(on, multifrontal, w.step, back.in_air ? before : nullptr, first, back.h,
                     m == 1 ? lambda : nullptr);
  if (back.factors_kept || m > 1)
    multifrontal.Solve(w.step.factor.From(first, plan.factor_size),
                       {lambda, lambda, w.vectors + 1LL * first * m * plan.vector_size, m},
                       on.batch.slots, on.stream);
  if (back.dynamics) {
    double* numbers = w.numbers + first * dofs * kDynamicsNumbers;
    LaunchDynamicsColumns(on, step, {.matrix = numbers});
    LaunchDynamicsGradient(on, numbers, lambda, w.dynamics + 1LL * first * kDynamicsNumbers * m, m);
  }
  const double* seen = LaunchDamping(on, w.step, first, end_v, back.h);
  if (m == 1) {
    const AdjointRecords records = w.single.From(on.cloth, first);
    LaunchAdjointRecords(on, seen, back.h, lambda, records, back.sums.From(first));
    LaunchGatherAdjoint(on, records, end_v, back.h, lambda, adj_x, adj_v);
  } else {
    double* blocks = w.blocks + first * 9LL * on.cloth.num_blocks;
    const DerivativeRecords derivatives = w.derivatives.From(on.cloth, first);
    LaunchDerivativeRecords(on, seen, back.h, derivatives);
    LaunchGatherDerivative(on, derivatives, end_v, back.h, blocks);
    LaunchAdjointPosition(on, blocks, lambda, adj_x, adj_v, m);
    LaunchAdjointMaterial(on, seen, back.h, lambda, back.sums.From(first), m);
  }
  if (back.in_air) LaunchAddAirAdjoint(on, step, lambda, adj_x, adj_v, m);
}

// What a batch leaves on the device, in the resources' memory: valid until their next batch.
struct RolloutRun {
  StepWorkspace workspace;                 // x, v: the ends
  std::shared_ptr<DeviceHistory> history;  // empty unless recorded
  FrameStates frames;
  int steps;  // done
};
struct AdjointRun {
  double *adj_x, *adj_v;  // ∂L/∂start, [3V, columns] a slot
  double* dynamics;       // [7, columns] a slot
  DeviceGradient sums;
  std::vector<int> failed;  // of each slot
  int steps;                // done
};

RolloutRun RunRollouts(DeviceResources& resources, std::span<const RolloutInput> batch,
                       const RolloutOptions& options, HistoryChoice choice, bool record) {
  const DeviceCloth& cloth = resources.cloth();
  const int slots = static_cast<int>(batch.size()), dofs = cloth.view().num_dofs();
  StepWorkspace w{};
  resources.Allocate(slots, [&](Arena& arena, int n) { w = StepWorkspace::Take(arena, cloth, n); });
  auto history = std::make_shared<DeviceHistory>();
  history->device = resources.device().index;
  history->slots = slots;
  HistoryView kept{nullptr, nullptr, static_cast<std::int64_t>(slots) * dofs, w.step};
  if (record) {
    history->x = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * slots * dofs);
    history->v = DeviceBuffer<double>(history->x.size());
    if (choice.with_factors) {
      const std::int64_t stride = slots * cloth.multifrontal().view().factor_size;
      history->factor = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * stride);
      w.factor = {history->factor.data(), w.step, stride};
    }
    kept.x = history->x.data();
    kept.v = history->v.data();
  }
  const DeviceMaterials materials(CollectMaterials(batch));
  resources.UploadStarts(batch, w.x, w.v);
  resources.Clear(w.failed, slots * sizeof(int));
  resources.Clear(w.step, sizeof(int));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.x};
  LaunchPushOut(resources.On(shapes), w.x);
  // A recording is for derivatives, which a shortened move has not.
  const BlockedMove blocked = record ? BlockedMove::kFails : BlockedMove::kEnds;
  const Streams& streams = resources.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      const LaunchContext on = resources.On(SliceBatch(shapes, first, count, dofs), stream);
      LaunchSolveStep(on, cloth.multifrontal(), w, first, options.h);
      LaunchAdvanceGroup(on, w, first, options.h, blocked, kept);
    });
    LaunchCountStep(w.step, 1, streams.main());
  });
  FrameStates frames(cloth.view(), slots, options);
  const int done = RunToFrames(resources, step, options.steps, options, StopsForwards(options),
                               [&](int) { frames.Keep(resources, w.x, w.v); });
  streams.Synchronize();
  return {w, history, std::move(frames), done};
}

void CollectEnds(DeviceResources& resources, const StepWorkspace& w, int steps, int wanted_steps,
                 std::span<RolloutResult* const> results, std::span<char> failed) {
  resources.DownloadEnds(w.x, w.v, results);
  const std::vector<int> flags = Download(w.failed, results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    failed[i] = flags[i] != 0;
    RolloutResult& result = *results[i];
    result.status = steps < wanted_steps ? RolloutStatus::kCancelled : RolloutStatus::kOk;
    result.steps = steps;
  }
}

// place(i): the matrix of slot i.
template <class Place>
void DownloadTangents(const DeviceResources& resources, const double* from,
                      const TangentLayout& layout, std::span<const RolloutInput> batch,
                      const Place& place) {
  const std::int64_t dofs = resources.view().num_dofs(), columns = dofs * layout.columns;
  const std::vector<double> host = Download(from, batch.size() * columns);
#pragma omp parallel for num_threads(resources.threads())
  for (std::size_t i = 0; i < batch.size(); ++i) {
    RowMatrix all(dofs, layout.columns);
    resources.cloth().ToMeshOrder(host.data() + i * columns, layout.columns, layout.columns,
                                  all.data());
    place(i) = layout.Select(all, batch[i]);
  }
}

// Appends states and tangents at a frame to those of the results, or hands the tangents on. Slots
// that have failed are left to the host, which calls for their frames again.
void CollectTangentFrame(DeviceResources& resources, const TangentWorkspace& w,
                         const TangentLayout& layout, int frame,
                         std::span<const RolloutInput> batch, std::span<TangentResult> results,
                         std::span<RolloutResult* const> ends) {
  resources.DownloadEnds(w.step.x, w.step.v, ends);
  for (RolloutResult* end : ends) end->frames.push_back(end->end);
  for (TangentResult& result : results) result.frames.emplace_back();
  const auto at = [&](std::size_t i) -> FrameTangent& { return results[i].frames.back(); };
  DownloadTangents(resources, w.dx, layout, batch,
                   [&](std::size_t i) -> RowMatrix& { return at(i).dx; });
  DownloadTangents(resources, w.dv, layout, batch,
                   [&](std::size_t i) -> RowMatrix& { return at(i).dv; });
  const std::vector<int> failed = Download(w.step.failed, results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (batch[i].tangent == nullptr || !batch[i].tangent->on_frame) continue;
    if (failed[i] == 0) batch[i].tangent->on_frame(frame, ends[i]->end, at(i).dx, at(i).dv);
    results[i].frames.pop_back();
  }
}

// dL_dx: of the ends, [3V, columns] a slot, of which the first m have seeds.
AdjointRun RunAdjoint(DeviceResources& resources, std::span<const RolloutInput> batch,
                      std::span<const Recording* const> recordings, int m, int columns,
                      const std::vector<double>& dL_dx, const RolloutOptions& options) {
  const DeviceCloth& cloth = resources.cloth();
  const int slots = static_cast<int>(batch.size()), steps = CountSteps(*recordings[0]);
  const int dofs = cloth.view().num_dofs();
  AdjointWorkspace w{};
  resources.Allocate(
      slots, [&](Arena& arena, int n) { w = AdjointWorkspace::Take(arena, cloth, n, columns); });
  const DeviceMaterials materials(CollectMaterials(batch));
  const HistoryTable history(cloth, recordings, steps);
  DeviceGradient sums(batch, cloth.view().num_faces, cloth.view().num_hinges, columns);
  CopyToDevice<double>(dL_dx, w.adj_x);
  resources.Clear(w.adj_v, sizeof(double) * slots * columns * dofs);
  resources.Clear(w.step.failed, slots * sizeof(int));
  ForgetDamping(batch, w.step);
  resources.Clear(w.dynamics, sizeof(double) * slots * kDynamicsNumbers * columns);
  const bool dynamics = std::ranges::any_of(batch, WantsAdjoint), in_air = InAir(batch);
  if (dynamics || in_air) resources.UploadStarts(batch, w.step.x, w.start_v);
  const std::vector<int> last_step{steps - 1};
  CopyToDevice<int>(last_step, w.step.step);
  const FactorPlace kept =
      FindKeptFactors(recordings, cloth.multifrontal().view().factor_size, w.step.step);
  if (kept.base != nullptr) w.step.factor = kept;
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  const AdjointStep back{w,       history.slots(),      sums,     options.h,
                         columns, kept.base != nullptr, dynamics, in_air};
  const Streams& streams = resources.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchAdjointStep(resources.On(SliceBatch(shapes, first, count, dofs), stream),
                        cloth.multifrontal(), back, first);
    });
    LaunchCountStep(w.step.step, -1, streams.main());
  });
  SeedUpload seeds(resources, batch, m, columns);
  const int done =
      RunToFrames(resources, step, steps, options, StopsBackwards(options, steps),
                  [&](int frame) { seeds.Add(resources.On(shapes), frame, w.adj_x, w.adj_v); });
  streams.Synchronize();
  return {w.adj_x, w.adj_v, w.dynamics, std::move(sums), Download(w.step.failed, slots), done};
}

}  // namespace

void RolloutEngine::Rollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                             std::span<Recording> recordings, std::span<RolloutResult> results,
                             std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  const bool record = !recordings.empty();
  const HistoryChoice choice =
      record ? ChooseHistory(resources_, batch.size(), options.steps) : HistoryChoice();
  const std::size_t history = (record ? HistoryBytes(cloth, options.steps) : 0) +
                              (choice.with_factors ? FactorBytes(cloth, options.steps) : 0) +
                              FrameStates::Bytes(cloth.view(), options);
  std::vector<RolloutResult*> ends;
  for (RolloutResult& result : results) ends.push_back(&result);
  resources_.ForEachChunk(
      batch.size(), [&](Arena& arena, int slots) { StepWorkspace::Take(arena, cloth, slots); },
      history,
      [&](std::size_t first, std::size_t count) {
        const auto chunk = batch.subspan(first, count);
        const RolloutRun run = RunRollouts(resources_, chunk, options, choice, record);
        const auto chunk_ends = std::span(ends).subspan(first, count);
        run.frames.Download(resources_, chunk_ends);
        CollectEnds(resources_, run.workspace, run.steps, options.steps, chunk_ends,
                    failed.subspan(first, count));
        if (!record) return;
        const auto kept = recordings.subspan(first, count);
        if (!choice.on_device)
          return DownloadRecordings(cloth, *run.history, chunk, run.steps, kept);
        std::ranges::move(MakeRecordings(run.history, run.steps), kept.begin());
      });
}

void RolloutEngine::Tangents(std::span<const RolloutInput> batch,
                             std::span<const MaterialField* const> weights,
                             const RolloutOptions& options, std::span<TangentResult> results,
                             std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  std::vector<RolloutResult*> ends;
  for (TangentResult& result : results) ends.push_back(&result.rollout);
  const TangentLayout layout(batch);
  TangentWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = TangentWorkspace::Take(arena, cloth, n, layout);
  };
  resources_.ForEachChunk(batch.size(), take, 0, [&](std::size_t first, std::size_t count) {
    resources_.Allocate(static_cast<int>(count), take);
    const auto chunk = batch.subspan(first, count);
    const auto found = results.subspan(first, count);
    const auto chunk_ends = std::span(ends).subspan(first, count);
    const int done = RunTangents(
        resources_, w, layout, chunk, weights.subspan(first, count), options,
        [&](int k) { CollectTangentFrame(resources_, w, layout, k, chunk, found, chunk_ends); });
    CollectEnds(resources_, w.step, done, options.steps, chunk_ends, failed.subspan(first, count));
    DownloadTangents(resources_, w.dx, layout, chunk,
                     [&](std::size_t i) -> RowMatrix& { return found[i].dx; });
    DownloadTangents(resources_, w.dv, layout, chunk,
                     [&](std::size_t i) -> RowMatrix& { return found[i].dv; });
  });
}

void RolloutEngine::Adjoints(std::span<const RolloutInput> batch,
                             std::span<const Recording* const> recordings,
                             std::span<const RowMatrix* const> dL_dx, const RolloutOptions& options,
                             std::span<AdjointResult> results, std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  const int used = static_cast<int>(dL_dx[0]->cols()), m = PaddedColumns(used);
  const int steps = CountSteps(*recordings[0]);
  const std::int64_t dofs = cloth.view().num_dofs(), columns = dofs * m;
  const auto take = [&](Arena& arena, int n) { AdjointWorkspace::Take(arena, cloth, n, m); };
  const std::size_t seeds = options.frames.empty() ? 0 : columns * sizeof(double);
  const std::size_t bytes = GradientBytes(cloth.view(), m) + HistoryBytes(cloth, steps) + seeds;
  resources_.ForEachChunk(batch.size(), take, bytes, [&](std::size_t first, std::size_t count) {
    std::vector<double> host(count * columns);
    for (std::size_t i = 0; i < count; ++i)
      cloth.ToEliminationOrder(dL_dx[first + i]->data(), used, m, host.data() + i * columns);
    AdjointRun run = RunAdjoint(resources_, batch.subspan(first, count),
                                recordings.subspan(first, count), used, m, host, options);
    const auto collect = [&](const double* from, RowMatrix AdjointResult::*part) {
      CopyToHost<double>(from, host);
      for (std::size_t i = 0; i < count; ++i) {
        RowMatrix& to = results[first + i].*part;
        to.resize(dofs, used);
        cloth.ToMeshOrder(host.data() + i * columns, used, m, to.data());
      }
    };
    collect(run.adj_x, &AdjointResult::x0);
    collect(run.adj_v, &AdjointResult::v0);
    const std::vector<double> numbers = Download(run.dynamics, count * kDynamicsNumbers * m);
    for (std::size_t i = 0; i < count; ++i) {
      AdjointResult& result = results[first + i];
      failed[first + i] = run.failed[i] != 0;
      if (WantsAdjoint(batch[first + i]))
        result.dynamics = Eigen::Map<const RowMatrix>(numbers.data() + i * kDynamicsNumbers * m,
                                                      kDynamicsNumbers, m)
                              .leftCols(used);
      result.material = run.sums.Collect(batch[first + i], static_cast<int>(i), used);
      if (run.steps < steps) result = {RolloutStatus::kCancelled, {}, {}, {}};
    }
  });
}

}  // namespace drape
