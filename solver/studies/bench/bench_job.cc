// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_job.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr double kBytesPerMegabyte = 1e6;

// Which reference a cell is compared with.
std::string ClothKey(const BenchSetting& setting) {
  return fs::path(setting.material).stem().string() + " " + setting.law + " " + setting.model;
}

class Bench {
 public:
  Bench(const BenchJob& job, const RunControl& control)
      : job_(job),
        control_(control),
        cells_(ListRuns(job.work, job.axes)),
        file_(job.out + "/runs.csv", job.common, job.resume) {
    CheckInput();
  }

  BenchResult Run() {
    idle_bytes_ = RunInChild([] { return std::string(); }, nullptr).peak_bytes;
    if (job_.work != BenchWork::kFit) FindReferences();
    for (const BenchSetting& cell : cells_) {
      if (result_.cancelled) break;
      RunOne(cell);
    }
    return std::move(result_);
  }

 private:
  // Bad names are found before hours are spent.
  void CheckInput() {
    for (const BenchSetting& cell : cells_) {
      if (job_.work == BenchWork::kFit) {
        CheckFitCell(cell);
      } else if (IsDistribution(cell)) {
        throw InputError("axis 'model'", "found " + cell.model + ", which only fits have");
      }
      if (!vertices_.contains(cell.mesh))
        vertices_[cell.mesh] = ParseMeshSpec(cell.mesh).num_vertices();
    }
    for (const std::string& mesh : {job_.reference.fine, job_.reference.coarse})
      vertices_[mesh] = ParseMeshSpec(mesh).num_vertices();
    for (const BenchSetting& cell : cells_) {
      total_ += Guess(cell);
      if (job_.work != BenchWork::kFit && !references_.contains(ClothKey(cell))) {
        references_[ClothKey(cell)] = {};
        total_ += GuessOfReference();
      }
    }
  }

  // Work of a cell in steps of a cloth of one vertex, for the time left.
  double Guess(const BenchSetting& cell) const {
    constexpr double kNewtonSteps = 40.0, kGrowth = 1.4;
    const double steps = (cell.integrator == "static" ? 0 : cell.steps()) +
                         (cell.integrator == "dynamic" ? 0 : kNewtonSteps);
    return cell.batch * steps * std::pow(vertices_.at(cell.mesh), kGrowth);
  }
  double GuessOfReference() const {
    BenchSetting setting;
    setting.integrator = "static";
    setting.mesh = job_.reference.fine;
    const double fine = Guess(setting);
    setting.mesh = job_.reference.coarse;
    return (fine + Guess(setting)) / job_.cell.repeats;
  }

  void Done(double guess, const std::string& note) {
    done_ += guess;
    control_.Report(done_ / total_, note);
  }

  // nullptr when cancelled.
  const BenchReference* FindReference(const BenchSetting& cell) {
    const std::string cloth = ClothKey(cell);
    std::string name = cloth;
    for (char& c : name)
      if (c == ' ') c = '_';
    const std::string path = job_.out + "/reference_" + name + ".json";
    std::string text;
    if (file_.continues() && fs::exists(path)) {
      text = ReadWholeFile(path);
    } else {
      ChildResult child = RunInChild(
          [&] {
            return ReferenceText(cell, job_.problem, job_.reference, job_.work, control_.cancel);
          },
          control_.cancel);
      if (child.cancelled) return nullptr;
      text = std::move(child.output);
      WriteFileAtomically(path, text);
    }
    BenchReference& reference = references_[cloth];
    reference = ParseReference(text, job_.reference, path);
    result_.reference_errors[cloth] = reference.ErrorEstimate(job_.work);
    return &reference;
  }

  void FindReferences() {
    for (const BenchSetting& cell : cells_) {
      if (result_.reference_errors.contains(ClothKey(cell))) continue;
      if (FindReference(cell) == nullptr) {
        result_.cancelled = true;
        return;
      }
      Done(GuessOfReference(), "reference of " + ClothKey(cell));
    }
  }

  BenchRecord Measure(const BenchSetting& cell) const {
    if (job_.work == BenchWork::kFit)
      return RunFitCell(cell, job_.fit, job_.out + "/fits", control_.cancel);
    return RunBenchSetting(job_.work, cell, job_.problem, references_.at(ClothKey(cell)), job_.cell,
                           control_.cancel);
  }

  void RunOne(const BenchSetting& cell) {
    const std::string identity = CheckpointKey(job_.work, cell);
    if (const BenchRecord* known = file_.Find(identity)) {
      result_.cells.push_back({cell, *known});
      total_ -= Guess(cell);
      return;
    }
    const ChildResult child =
        RunInChild([&] { return RecordLine(Measure(cell)); }, control_.cancel);
    result_.cancelled = child.cancelled || control_.cancelled();
    if (result_.cancelled) return;
    BenchRecord record = ParseRecordLine(child.output, identity);
    record[kPeakMegabytes] = (child.peak_bytes - idle_bytes_) / kBytesPerMegabyte;
    file_.Add(job_.work, cell, record);
    result_.cells.push_back({cell, record});
    Done(Guess(cell), MakeLabel(cell, job_.axes));
  }

  const BenchJob& job_;
  const RunControl& control_;
  std::vector<BenchSetting> cells_;
  BenchFile file_;
  std::map<std::string, int> vertices_;               // by mesh
  std::map<std::string, BenchReference> references_;  // by ClothKey
  double idle_bytes_ = 0.0, total_ = 0.0, done_ = 0.0;
  BenchResult result_;
};

}  // namespace

BenchResult RunBench(const BenchJob& job, const RunControl& control) {
  return Bench(job, control).Run();
}

}  // namespace drape
