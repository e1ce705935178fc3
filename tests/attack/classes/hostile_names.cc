// SPDX-License-Identifier: Apache-2.0
// Good files with hostile names: none may run a command, break a message or lose a result.
#include <nlohmann/json.hpp>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

constexpr double kHostileNamesSeconds = 15.0;

const std::vector<std::string>& HostileNames() {
  static const std::vector<std::string> kNames = {"a`touch PLANTED1`b",
                                                  "$(touch PLANTED2)",
                                                  "q\n!touch PLANTED3\n",
                                                  "q\"; !touch PLANTED4; #",
                                                  "'; system('touch PLANTED5'); '",
                                                  "q\" ; set output \"PLANTED6",
                                                  "\x1b[31mred",
                                                  "\xff\xfe",
                                                  "a#b",
                                                  "a,b",
                                                  "a b",
                                                  "%s%n%d",
                                                  "{/Symbol a}_^@",
                                                  "\\n\\\\",
                                                  "-x",
                                                  "\xe2\x80\xae"
                                                  "fdp",
                                                  "\xc3\xa4",
                                                  "a\tb\r",
                                                  std::string(230, 'L'),
                                                  std::string(245, 'L'),
                                                  "\"",
                                                  "'",
                                                  "a;b",
                                                  "&&",
                                                  "a\\",
                                                  "..x",
                                                  "@@~~"};
  return kNames;
}

// A command with `flag` of a good file under a hostile name, below "in"; a flag without "=" is an
// operand.
struct NamedInput {
  std::string program, flag, valid, kind;  // "--fabric=", "wool.json", ".json"
  std::vector<std::string> more = {};
  bool with_plain = false;  // a plain one beside it, so that the names become labels
};

std::vector<NamedInput> NamedInputs() {
  return {{"drape_simulate", "--fabric=", "wool.json", ".json"},
          {"drape_simulate", "--start=", "waves.json", ".json"},
          {"drape_simulate", "--mesh=", "disc.obj", ".obj"},
          {"drape_fit", "--fabric=", "wool.json", ".json"},
          {"drape_fit", "--images=", "drape.png", ".png"},
          {"drape_fit",
           "--images=",
           "drape.png",
           ".png",
           {"--model=heterogeneous", "--field_iterations=1", "--field_restarts=0"}},
          {"drape_metrics", "", "drape.png", ".png"},
          {"drape_equilibria", "--fabric=", "wool.json", ".json"},
          {"drape_predict", "--fabric=", "wool.json", ".json"},
          {"drape_check", "--fabric=", "wool.json", ".json"},
          {"drape_compare", "--fabric=", "wool.json", ".json"},
          {"drape_bench", "--fabric=", "wool.json", ".json", {}, true},
          {"drape_bench", "--start=", "waves.json", ".json"},
          {"drape_speed", "--fabric=", "wool.json", ".json"},
          {"drape_stability", "--fabric=", "wool.json", ".json"},
          {"drape_gradients", "--fabric=", "wool.json", ".json"},
          {"drape_compare_optimisers", "--twins=", "wool.json", ".json", {}, true},
          {"drape_compare_optimisers", "--fabric=", "wool.json", ".json"},
          {"drape_space", "--new=", "wool.json", ".json"}};
}

// The name of a fabric is then that of its file, which shows in tables and charts.
std::string WithoutName(const std::string& text) {
  nlohmann::json file = nlohmann::json::parse(text, nullptr, false, true);
  if (!file.is_object()) return text;
  file.erase("name");
  return file.dump();
}

void TryName(const Campaign& campaign, const NamedInput& input, const std::string& name,
             Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  const std::string file = "in/" + name + input.kind;
  const std::string content = ReadText(campaign.options().work + "/valid/" + input.valid);
  sandbox.Write(file, input.kind == ".json" ? WithoutName(content) : content);
  std::vector<std::string> command = QuickCommand(input.program, input.more);
  const std::string plain = input.with_plain ? "," + std::string(kValid) + input.valid : "";
  if (input.flag.empty())
    command = {input.program, file, "--overlay=out/overlay.png", "--csv=out/drapes.csv",
               "--out=out/metrics.json"};
  else
    command.push_back(input.flag + file + plain);
  Request request = MakeRequest(campaign, command);
  request.limits.seconds = kHostileNamesSeconds;
  sandbox.Run(request);
}

void TryOut(const Campaign& campaign, const std::string& program, const std::string& name,
            Sandbox& sandbox) {
  Request request = MakeRequest(campaign, QuickCommand(program, {"--out=results/" + name}));
  if (program == "drape_check") request.command.pop_back();
  sandbox.Write("results/notes.txt", "earlier");
  request.limits.seconds = kHostileNamesSeconds;
  sandbox.Run(request, {.results = {"results"}});
}

}  // namespace

void AddHostileNames(Campaign* campaign, std::vector<Attack>* attacks) {
  for (const std::string& name : HostileNames()) {
    for (const NamedInput& input : NamedInputs())
      attacks->push_back({input.program + " " + input.flag + name,
                          [=](Sandbox& sandbox) { TryName(*campaign, input, name, sandbox); }});
    for (const std::string& program : ProgramNames())
      attacks->push_back({program + " --out=" + name,
                          [=](Sandbox& sandbox) { TryOut(*campaign, program, name, sandbox); }});
  }
}

}  // namespace drape::attack
