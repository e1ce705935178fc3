// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <string>

#include "physics/util/errors.h"
#include "solver/studies/bench/cases/bench_drape.h"
#include "solver/studies/bench/cases/bench_record.h"

namespace drape {

// Work against precision: what a drape or its derivative costs with some setting, and how far it is
// from the exact answer of the model: the drape at rest on an infinitely fine mesh.

struct ReferenceOptions {
  std::string fine = "disc:4800", coarse = "disc:2400";  // the two finest meshes
  std::string relax_mesh = "disc:1200";  // on which the start relaxes; Newton continues from there,
                                         // so that both are on one branch
  double h = 0.05, relax_seconds = 10.0;
  double order = 2.0;  // of the error in the size of the elements
};

// The drape and its derivative on two meshes. Newton leaves no error of the time step.
struct BenchReference {
  BenchDrape fine, coarse;
  Mesh fine_mesh, coarse_mesh;
  double ratio = 0.0, order = 2.0;  // of the elements' sizes

  // The limit of an infinitely fine mesh (Extrapolate), positions at points of the cloth, shape
  // [2, N]: [3N].
  Eigen::VectorXd PositionsAt(const Eigen::Matrix2Xd& points) const;
  Eigen::VectorXd outline() const, gradient() const;
  double area() const;  // of the silhouette [m²]
  RowMatrix jacobian() const;
  // The same measures of the fine mesh's own drape: an estimate of the error of the reference.
  BenchRecord ErrorEstimate(BenchWork work) const;
};

// As text, and back: what a child process finds for its parent, and a resumed run for itself.
std::string ReferenceText(const BenchSetting& setting, const BenchProblem& problem,
                          const ReferenceOptions& options, BenchWork work,
                          const std::atomic<bool>* cancel);
// A cloth that has no reference, since a drape of it was not found.
class NoReference : public InputError {
 public:
  // reason: "the drape on disc:600 is 'slow'".
  NoReference(const std::string& where, const std::string& reason)
      : InputError(where, "no reference: " + reason +
                              ", expected a drape at rest (another start or mesh?)"),
        reason_(reason) {}
  const std::string& reason() const { return reason_; }

 private:
  std::string reason_;
};

// Throws InputError (prefix `where`) for text that is none, NoReference where a drape was not
// found.
BenchReference ParseReference(const std::string& text, const ReferenceOptions& options,
                              const std::string& where);

// Fills the errors of a drape, of which the measures above are known, against a reference.
void MeasureErrors(const BenchReference& reference, const Mesh& mesh, const BenchDrape& drape,
                   BenchWork work, BenchRecord* record);

struct MeasuringOptions {
  int repeats = 3;          // at most
  double seconds = 10.0;    // and no more runs once so many seconds of wall clock are spent
  double branch_mm = 15.0;  // a drape with other folds than the reference's fine one, or whose
                            // outline, turned to match, is further from it (root mean square),
                            // is on another branch
};

// Measures one setting of a forward, gradient or jacobian work in this process. Throws what
// SettingSolver throws.
BenchRecord RunBenchSetting(BenchWork work, const BenchSetting& setting,
                            const BenchProblem& problem, const BenchReference& reference,
                            const MeasuringOptions& options, const std::atomic<bool>* cancel);

}  // namespace drape
