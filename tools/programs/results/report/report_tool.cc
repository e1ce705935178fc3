// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/report_tool.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

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

// The script beside the installed programs, or in the source tree above the build folder.
std::string FindScript() {
  const std::string file = "report/python/drape_report.py";
  std::error_code ignored;
  const fs::path programs = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::vector<fs::path> places = {programs.parent_path() / "share/drapefit" / file};
  for (fs::path folder = programs; folder.has_relative_path(); folder = folder.parent_path())
    places.push_back(folder / "tools/programs/results" / file);
  for (const fs::path& place : places)
    if (fs::exists(place, ignored)) return place;
  throw InputError(places.front().string(),
                   "is not installed, expected the script of drape_report");
}

// The script takes over this process, with its streams and signals.
ToolOutcome Run(const ReportOptions& options, const RunControl& /*control*/) {
  if (options.folders.empty())
    throw InputError("FOLDER", "expected at least one folder of results");
  CheckReplaceable(options.out);
  const char* python = fs::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  std::vector<std::string> words = {python, "-B", FindScript(), options.out,
                                    Format("%.17g", options.max_mb)};
  words.insert(words.end(), options.folders.begin(), options.folders.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execvp(python, arguments.data());
  throw InputError(python, std::string("cannot be run: ") + std::strerror(errno));
}

}  // namespace

int ReportMain(int argc, char** argv) { return ToolMain(argc, argv, ReportTable, Run); }

}  // namespace drape
