// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/bench/bench_job.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_bench sets.
struct BenchToolOptions {
  BenchJob job;
  CellChoice cells;
  std::string work = "forward";                                      // ParseBenchWork
  std::string start;                                                 // ReadStartShape
  std::vector<std::string> references = {"disc:2400", "disc:4800"};  // coarse, fine
  std::string clock = "wall";                 // by which charts and the table count
  std::vector<std::string> images, held_out;  // of fits (ExpandImages)
  std::string ground_truth;                   // without images: whose silhouette is fitted
  std::string ground_truth_mesh = "disc:1200";
  std::string published;  // of other programs (ReadPublishedSpeeds); empty: none
  std::string table;      // accuracy table to write; empty: none
  double safety = 1.25;   // factor on the errors that it promises
  std::string out;        // folder, made when missing
};

// Points into `options`, which outlives it.
OptionTable BenchTable(BenchToolOptions& options);

struct BenchToolResult {
  bool cancelled = false;
  bool is_list = false;       // of cells, or a share of them, instead of measurements
  int measured = 0;           // runs with a result
  std::string table;          // for a person
  std::string no_table = {};  // why there is no --table
};

// Runs the benchmark, a share of its runs, or lists them; all runs together, it writes runs.csv (as
// runs end), bench.json, and the charts front_<error> and growth as PNG and SVG; a cancelled run
// writes what it has. Throws InputError.
BenchToolResult RunBenchTool(const BenchToolOptions& options, const RunControl& control);

// The program drape_bench.
int BenchMain(int argc, char** argv);

}  // namespace drape
