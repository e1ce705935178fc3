// SPDX-License-Identifier: Apache-2.0
// drapefit <verb> runs drape_<verb>; drapefit <picture> runs all steps to a report.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/programs/front/child.h"
#include "tools/programs/front/documents.h"
#include "tools/programs/front/programs.h"
#include "tools/programs/front/short_way.h"
#include "tools/programs/front/verbs.h"

namespace drape {
namespace {

constexpr char kUsage[] =
    "usage: drapefit VERB [options]          runs drape_VERB\n"
    "       drapefit help VERB               its options\n"
    "       drapefit PICTURE --mass=G_PER_M2 from a photograph of a drape to a report: photo, "
    "fit,\n"
    "                                        predict, report (options: drapefit --help=all)\n\n";

int Fail(const std::string& message) {
  std::fprintf(stderr, "drapefit: error: %s\n", MakePrintableLine(message).c_str());
  return kExitBadInput;
}

int ShowVerbs(const std::string& folder) {
  const std::string text = "drapefit " + BuildVersion() + ": stiffness of fabrics from drapes\n\n" +
                           kUsage + VerbsText(ReadPrograms(folder));
  std::fputs(text.c_str(), stdout);
  return std::fflush(stdout) == 0 ? kExitOk : Fail("stdout: cannot be written");
}

int RunPicture(int argc, char** argv, const std::string& folder) {
  ShortWayOptions options;
  if (ParseCommandLine(ShortWayTable(options), argc, argv) == ParseOutcome::kHelpShown)
    return kExitOk;
  return RunShortWay(options, folder);
}

// A verb has no dot or slash, and is no file.
bool IsPicture(const std::string& word) {
  return word.starts_with("-") || word.find_first_of("./") != std::string::npos ||
         std::filesystem::exists(word);
}

int Run(int argc, char** argv) {
  const std::string folder = ProgramFolder();
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool asked = words.empty() || words[0] == "--help" || words[0] == "-h";
  if (asked || (words[0] == "help" && words.size() == 1)) return ShowVerbs(folder);
  constexpr char kDocuments[] = "--write_documents=";  // for the build
  if (words[0].starts_with(kDocuments)) {
    WriteDocuments(folder, words[0].substr(std::size(kDocuments) - 1));
    return kExitOk;
  }
  const bool help = words[0] == "help";
  if (help) {
    words.erase(words.begin());
    words.insert(words.begin() + 1, "--help");
  }
  const std::string verb = words[0], program = FindProgram(folder, verb);
  if (!program.empty()) Become(program, {words.begin() + 1, words.end()});
  if (!help && IsPicture(verb)) return RunPicture(argc, argv, folder);
  return Fail(UnknownVerbText(verb, FindVerbs(folder)));
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  try {
    return drape::Run(argc, argv);
  } catch (const std::exception& error) {
    return drape::Fail(error.what());
  }
}
