// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

struct ReportOptions {
  std::vector<std::string> folders;
  std::string out = "report.html";
  double max_mb = 2.0;  // size of the page [MB]
};

OptionTable ReportTable(ReportOptions& options) {
  return {
      .tool = "drape_report",
      .summary = "makes one page of finished results: verdict, images, material, drapes, charts",
      .example = "drape_report out/fit out/predict --out=out/report.html",
      .notes =
          "FOLDER is the output folder of any program of drapefit, or a JSON file of "
          "drape_metrics. Several are shown side by side.\n"
          "The page is one file for any browser. It needs no network, its charts and tables are "
          "complete without scripts, and it prints. Nothing is computed again.\n",
      .options = {PathOption("out", &options.out, "file of the page"),
                  NumberOption(
                      "max_mb", &options.max_mb, 1.2, 1000,
                      "largest size of the page; what would make it larger is named instead",
                      "MB")},
      .operands = &options.folders,
      .operand_names = "FOLDER..."};
}

// The script takes over this process, with its streams. It lets signals in once it can answer them.
ToolOutcome Run(const ReportOptions& options, const RunControl& control) {
  if (options.folders.empty())
    throw InputError("FOLDER", "expected at least one folder of results");
  CheckReplaceable(options.out);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(options.out, ignored) &&
      !ReadOwnFile(options.out).starts_with("<!doctype html>"))
    throw InputError(options.out, "is no page, expected an earlier page or no file of this name");
  const std::string script = "report/python/drape_report.py";
  std::vector<std::string> words = ScriptCommand(script, "tools/programs/results/" + script);
  if (words.back().empty()) throw InputError(script, "is not installed");
  words.insert(words.end(), {options.out, Format("%.17g", options.max_mb)});
  words.insert(words.end(), options.folders.begin(), options.folders.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (control.cancelled()) return {.cancelled = true};
  execvp(arguments[0], arguments.data());
  throw InputError(words[0], std::string("cannot be run: ") + std::strerror(errno));
}

}  // namespace

int ReportMain(int argc, char** argv) { return ToolMain(argc, argv, ReportTable, Run); }

}  // namespace drape
