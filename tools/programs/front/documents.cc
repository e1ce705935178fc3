// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/documents.h"

#include <filesystem>

#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "tools/cli/option_text.h"
#include "tools/programs/front/completion.h"
#include "tools/programs/front/man_page.h"
#include "tools/programs/front/programs.h"
#include "tools/programs/front/short_way.h"

namespace drape {
namespace {

// The programs of a folder, in the order of the list of verbs.
std::vector<ProgramTable> ReadTables(const std::string& folder) {
  std::vector<ProgramTable> tables;
  for (const Program& program : Programs()) {
    if (!HasProgram(folder, program.verb)) continue;
    const ProgramResult answer = RunProgram({ProgramPath(folder, program.verb), "--help=json"}, "");
    tables.push_back({program.verb, nlohmann::json::parse(answer.output)});
  }
  return tables;
}

// The verbs as a section of drapefit's page.
std::string VerbsSection(const std::vector<ProgramTable>& programs) {
  std::string text = ".SH VERBS\n";
  for (const ProgramTable& program : programs)
    text +=
        ".TP\n.B " + RoffText(program.verb) + "\n" + RoffText(program.table.at("summary")) + "\n";
  return text;
}

}  // namespace

void WriteDocuments(const std::string& programs_folder, const std::string& out) {
  ShortWayOptions options;
  const nlohmann::json front = nlohmann::json::parse(TableJson(ShortWayTable(options)));
  const std::vector<ProgramTable> programs = ReadTables(programs_folder);
  const std::string man = out + "/man/man1/", completions = out + "/bash-completion/completions/";
  std::filesystem::remove_all(out);  // pages of programs that are gone
  std::filesystem::create_directories(man);
  std::filesystem::create_directories(completions);
  WriteFileAtomically(completions + "drapefit", BashCompletion(front, programs));
  std::string names;
  for (const ProgramTable& program : programs) {
    const std::string tool = program.table.at("tool");
    names += (names.empty() ? "" : ", ") + tool + "(1)";
    WriteFileAtomically(man + tool + ".1", ManPage(program.table, "drapefit(1)"));
    // bash looks for a script of the program's name; all are in that of drapefit.
    WriteFileAtomically(completions + tool, ". \"${BASH_SOURCE[0]%/*}/drapefit\"\n");
  }
  WriteFileAtomically(man + "drapefit.1", ManPage(front, names, VerbsSection(programs)));
}

}  // namespace drape
