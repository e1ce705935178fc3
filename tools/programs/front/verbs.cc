// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/verbs.h"

#include <algorithm>
#include <set>

#include "tools/cli/option_text.h"

namespace drape {
namespace {

struct Task {
  const char* title;
  std::vector<std::string> verbs;
};

// In which order a user meets them. What a program does is said by the program.
const std::vector<Task>& Tasks() {
  static const std::vector<Task> kTasks = {
      {"from a photograph to a report", {"photo", "fit", "predict", "report", "export"}},
      {"drapes and garments", {"simulate", "metrics", "equilibria", "garment"}},
      {"many fabrics and models", {"space", "compare"}},
      {"your own scene, and the solver", {"check", "validate"}},
      {"studies of accuracy and cost",
       {"bench", "speed", "stability", "gradients", "compare_optimisers"}}};
  return kTasks;
}

// At most so many columns of a text of UTF-8, cut at a word.
std::string Cut(const std::string& text, int columns) {
  std::size_t space = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ' ') space = i;
    if ((text[i] & 0xC0) != 0x80 && columns-- == 0) {
      std::string cut = text.substr(0, space);
      while (!cut.empty() && (cut.back() == ',' || cut.back() == ':')) cut.pop_back();
      return cut + " …";
    }
  }
  return text;
}

std::string Line(const Program& program) {
  constexpr std::size_t kVerb = 20;
  constexpr int kSummary = 74;
  std::string line = "  " + program.verb;
  line.resize(std::max(kVerb, line.size()) + 2, ' ');
  return line + Cut(program.table.at("summary").get<std::string>(), kSummary) + "\n";
}

}  // namespace

std::string VerbsText(const std::vector<Program>& programs) {
  std::string text, others;
  std::set<std::string> listed;
  for (const Task& task : Tasks()) {
    std::string lines;
    for (const std::string& verb : task.verbs) {
      listed.insert(verb);
      for (const Program& program : programs)
        if (program.verb == verb) lines += Line(program);
    }
    if (!lines.empty()) text += std::string(task.title) + ":\n" + lines + "\n";
  }
  for (const Program& program : programs)
    if (!listed.contains(program.verb)) others += Line(program);
  return text + (others.empty() ? "" : "others:\n" + others + "\n");
}

std::string UnknownVerbText(const std::string& verb, const std::vector<std::string>& verbs) {
  std::vector<std::string> names = verbs;
  names.insert(names.end(), {"help"});
  const std::string nearest = SuggestName(verb, names);
  return "command line: unknown verb '" + verb + "'" +
         (nearest.empty() ? "" : ", did you mean '" + nearest + "'?") +
         " (drapefit --help lists all)";
}

}  // namespace drape
