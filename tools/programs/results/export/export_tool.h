// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "physics/material/laws/law_kind.h"
#include "physics/util/run_control.h"
#include "solver/prediction/exchange/exchange_record.h"
#include "solver/prediction/exchange/targets/export_material.h"
#include "tools/cli/option_table.h"

namespace drape {

// The options of drape_export.
struct ExportToolOptions {
  FabricInput fabric;
  std::vector<std::string> to;  // names of ExportTarget, "all", "csv"
  LinearPoint point = LinearPoint::kDrape;
  ExportOptions target;
  double thickness = 0.0;  // [m]; 0: not known
  LawKind law = LawKind::kSmooth;
  std::string mesh = "disc:600";    // of the round trip
  DiscsInput discs;                 // of the round trip; not given: those of the fit
  int starts = 3;                   // of the round trip; 0: none
  int seed = 1;                     // of the first start and of the samples of a posterior
  PosteriorTableOptions posterior;  // of "csv"; its seed is `seed`
  int threads = 0;
  std::string out;
};

OptionTable ExportTable(ExportToolOptions& options);

// How drapes change when a fabric is replaced by what another program takes of it: both draped here
// from the same random starts.
struct RoundTrip {
  int starts = 0;  // of each fabric
  int pairs = 0;   // with a stable drape of both
  // Means over the pairs.
  double dc_original = 0.0, dc_exported = 0.0;        // drape coefficient, 0 … 1
  double nodes_original = 0.0, nodes_exported = 0.0;  // number of folds
};

struct ExportedTarget {
  ExportTarget target;
  ExportedMaterial material;
  std::optional<RoundTrip> round_trip;
};
struct ExportRun {
  std::string out;
  ExchangeRecord record;
  std::vector<ExportedTarget> targets;
  std::vector<std::string> posterior_files;
  bool cancelled = false;  // then no file is written
};

// Writes a file for each target and summary.json. Throws InputError.
ExportRun RunExport(const ExportToolOptions& options, const RunControl& control);

// The program drape_export.
int ExportMain(int argc, char** argv);

}  // namespace drape
