// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_job.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Which reference a run is compared with.
std::string ClothKey(const BenchSetting& setting) {
  return MaterialLabel(setting.material) + " " + setting.law + " " + setting.model;
}

std::string ReferenceName(const BenchSetting& setting) {
  std::string name = ClothKey(setting);
  std::replace(name.begin(), name.end(), ' ', '_');
  return "reference_" + name + ".json";
}

class Bench {
 public:
  Bench(const BenchJob& job, const RunControl& control)
      : job_(job),
        control_(control),
        settings_(ListRuns(job.work, job.axes)),
        cells_(job.out + "/cells", job.common) {
    KeepShare();
    CheckInput();
    const std::optional<BenchSetting>& ground_truth = job.fit.ground_truth;
    std::string image;
    if (ground_truth && !control.cancelled())
      image =
          RunInChild([&] { return RenderGroundTruth(*ground_truth, job.problem); }, control.cancel)
              .output;
    if (job.share) {
      cells_.Create();
    } else {
      file_.emplace(job.out + "/runs.csv", job.common, job.resume);
      for (const char* kept : {"/fits", "/cells"}) RemoveTemporaries(job.out + kept);
    }
    if (!image.empty()) WriteGroundTruth(image, job.fit.data.images.front());
  }

  BenchResult Run() {
    idle_bytes_ = RunInChild([] { return std::string(); }, nullptr).peak_bytes;
    if (job_.work != BenchWork::kFit) FindReferences();
    for (const BenchSetting& setting : settings_) {
      if (result_.cancelled) break;
      RunOne(setting);
    }
    return std::move(result_);
  }

 private:
  void KeepShare() {
    if (!job_.share) return;
    std::vector<BenchSetting> kept;
    for (std::size_t k = 0; k < settings_.size(); ++k)
      if (job_.share->Has(k)) kept.push_back(std::move(settings_[k]));
    settings_ = std::move(kept);
  }

  // Bad names are found before hours are spent.
  void CheckInput() {
    if (job_.work == BenchWork::kFit) CheckBenchImages(job_.fit);
    if (const auto& ground_truth = job_.fit.ground_truth) {
      ReadMaterial(ground_truth->material, {NegativeEntries::kWarn});
      ParseMeshSpec(ground_truth->mesh);
    }
    for (const BenchSetting& setting : settings_) {
      if (job_.work == BenchWork::kFit) {
        CheckBenchFit(setting);
      } else if (IsDistribution(setting)) {
        throw InputError("axis 'model'", "found " + setting.model + ", which only fits have");
      } else {
        CheckNameLength(setting.material, ReferenceName(setting));
      }
      ReadMaterial(setting.material, {NegativeEntries::kWarn});
      if (!vertices_.contains(setting.mesh))
        vertices_[setting.mesh] = ParseMeshSpec(setting.mesh).num_vertices();
    }
    for (const std::string& mesh : {job_.problem.coarse_mesh, job_.reference.relax_mesh})
      ParseMeshSpec(mesh);
    for (const std::string& mesh : {job_.reference.fine, job_.reference.coarse})
      vertices_[mesh] = ParseMeshSpec(mesh).num_vertices();
    for (const BenchSetting& setting : settings_) {
      total_ += Guess(setting);
      if (job_.work != BenchWork::kFit && !references_.contains(ClothKey(setting))) {
        references_[ClothKey(setting)] = {};
        total_ += GuessOfReference();
      }
    }
  }

  // Work of a run in steps of a cloth of one vertex, for the time left.
  double Guess(const BenchSetting& setting) const {
    constexpr double kNewtonSteps = 40.0, kGrowth = 1.4;
    const double steps = (setting.integrator == "static" ? 0 : setting.steps()) +
                         (setting.integrator == "dynamic" ? 0 : kNewtonSteps);
    return setting.batch * steps * std::pow(vertices_.at(setting.mesh), kGrowth);
  }
  double GuessOfReference() const {
    BenchSetting setting;
    setting.integrator = "static";
    setting.mesh = job_.reference.fine;
    const double fine = Guess(setting);
    setting.mesh = job_.reference.coarse;
    return (fine + Guess(setting)) / job_.measuring.repeats;
  }

  void Done(double guess, const std::string& note) {
    done_ += guess;
    control_.Report(done_ / total_, note);
  }

  // False when cancelled.
  bool FindReference(const BenchSetting& setting) {
    const std::string cloth = ClothKey(setting);
    const std::string path = job_.out + "/" + ReferenceName(setting);
    std::string text;
    const bool continues = cells_.continues() || (file_ && file_->continues());
    const bool stored = continues && fs::exists(path);
    if (stored) {
      text = ReadOwnFile(path);
    } else {
      ChildResult child = RunInChild(
          [&] {
            return ReferenceText(setting, job_.problem, job_.reference, job_.work, control_.cancel);
          },
          control_.cancel);
      if (child.cancelled) return false;
      text = std::move(child.output);
    }
    BenchReference& reference = references_[cloth];
    try {
      reference = ParseReference(text, job_.reference, path);
    } catch (const NoReference& none) {
      if (stored) throw;  // only references that are there are stored
      result_.no_references[cloth] = none.reason();
      return true;
    }
    if (!stored) WriteFileAtomically(path, text);
    RequireDerivative(reference, path);
    result_.reference_errors[cloth] = reference.ErrorEstimate(job_.work);
    return true;
  }

  void RequireDerivative(const BenchReference& reference, const std::string& path) const {
    for (const BenchDrape* drape : {&reference.fine, &reference.coarse})
      if ((job_.work == BenchWork::kGradient && drape->gradient.size() == 0) ||
          (job_.work == BenchWork::kJacobian && drape->jacobian.size() == 0))
        throw InputError(path, std::string("has no ") + ToString(job_.work) +
                                   ", expected a reference of this work");
  }

  void FindReferences() {
    for (const BenchSetting& setting : settings_) {
      const std::string cloth = ClothKey(setting);
      if (result_.reference_errors.contains(cloth) || result_.no_references.contains(cloth))
        continue;
      if (!FindReference(setting)) {
        result_.cancelled = true;
        return;
      }
      Done(GuessOfReference(), "reference of " + cloth);
    }
  }

  BenchRecord Measure(const BenchSetting& setting) const {
    if (job_.work == BenchWork::kFit)
      return RunBenchFit(setting, job_.fit, job_.out + "/fits", control_.cancel);
    return RunBenchSetting(job_.work, setting, job_.problem, references_.at(ClothKey(setting)),
                           job_.measuring, control_.cancel);
  }

  // A run that has ended: of runs.csv, or of a share, which is then added there.
  std::optional<BenchRecord> FindKnown(const BenchSetting& setting, const std::string& identity) {
    if (file_)
      if (const BenchRecord* known = file_->Find(identity)) return *known;
    const std::optional<std::string> line = cells_.Read(identity);
    if (!line) return std::nullopt;
    const BenchRecord record = ParseRecordLine(*line, cells_.Path(identity));
    if (file_) file_->Add(job_.work, setting, record);
    return record;
  }

  void RunOne(const BenchSetting& setting) {
    if (result_.no_references.contains(ClothKey(setting))) {
      BenchRecord record;
      record.status = kRunNoReference;
      result_.runs.push_back({setting, record});
      total_ -= Guess(setting);
      return;
    }
    const std::string identity = CheckpointKey(job_.work, setting);
    if (const std::optional<BenchRecord> known = FindKnown(setting, identity)) {
      result_.runs.push_back({setting, *known});
      total_ -= Guess(setting);
      return;
    }
    const ChildResult child =
        RunInChild([&] { return RecordLine(Measure(setting)); }, control_.cancel);
    result_.cancelled = child.cancelled || control_.cancelled();
    if (result_.cancelled) return;
    BenchRecord record = ParseRecordLine(child.output, identity);
    record[kPeakMegabytes] = (child.peak_bytes - idle_bytes_) / kBytesPerMegabyte;
    if (job_.share) {
      cells_.Write(identity, RecordLine(record));
    } else {
      file_->Add(job_.work, setting, record);
    }
    result_.runs.push_back({setting, record});
    Done(Guess(setting), MakeLabel(setting, job_.axes));
  }

  const BenchJob& job_;
  const RunControl& control_;
  std::vector<BenchSetting> settings_;
  CellFolder cells_;                                  // of shares
  std::optional<BenchFile> file_;                     // begun when the input is known to be good
  std::map<std::string, int> vertices_;               // by mesh
  std::map<std::string, BenchReference> references_;  // by ClothKey
  double idle_bytes_ = 0.0, total_ = 0.0, done_ = 0.0;
  BenchResult result_;
};

}  // namespace

std::vector<std::string> ListBenchCells(const BenchJob& job) {
  std::vector<std::string> cells;
  for (const BenchSetting& setting : ListRuns(job.work, job.axes))
    cells.push_back(CheckpointKey(job.work, setting));
  return cells;
}

BenchResult RunBench(const BenchJob& job, const RunControl& control) {
  return Bench(job, control).Run();
}

}  // namespace drape
