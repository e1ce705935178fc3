// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/runner/study.h"
#include "tools/cli/option_table.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/fit_options.h"

namespace drape {

// How a program becomes a study: its options hold a StudyOptions, whose rows are
// StudyOptionList; its run makes a Study and calls RunStudyProgram, which does the rest. The
// program writes numbers; tables and pictures are made of them by scripts/<study>.py, which the
// program starts at its end and which anyone can start again:
//   python3 tools/programs/studies/scripts/<study>.py OUT
// A script begins with `from study import …` (scripts/study.py): it reads OUT/<study>.json, writes
// its files to OUT, and prints what the program is to say.

// ScriptCommand of scripts/<name>.py.
std::vector<std::string> StudyScriptCommand(const std::string& name);

// --out, --list and --share.
std::vector<Option> StudyOptionList(StudyOptions& options);

// The options of drape_fit that all fits of a study have in common, without those that each fit
// sets for itself and those of `except`.
std::vector<Option> FitOptionsOfCells(FitToolOptions& fit,
                                      const std::set<std::string>& except = {});

// The file OUT/<study>.json without its provenance, once the cells have ended; of a study that was
// cancelled some have no result.
using SummariseStudy = std::function<nlohmann::ordered_json(const StudyResult& result)>;

// {"study", "outcome", "settings", "cells": [{"name", "input", "result"}, …]}.
nlohmann::ordered_json SummariseCells(const Study& study, const StudyResult& result);

// Lists the cells, runs a share, or runs all, writes <study>.json, and starts the script. No
// `summarise`: SummariseCells. Throws InputError and IoError; earlier files are unchanged then.
ToolOutcome RunStudyProgram(const Study& study, const StudyOptions& options,
                            const RunControl& control, const SummariseStudy& summarise = {});

// Starts scripts/<name>.py for a folder and returns what it prints, or why it did not, with an end
// of line. `folder` is where <name>.json was staged.
std::string RunStudyScript(const std::string& name, const std::string& folder);

}  // namespace drape
