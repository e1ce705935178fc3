// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/completion.h"

namespace drape {
namespace {

using nlohmann::json;

// What the shell does; the lists are made from the option tables. A word of the command line is
// read from COMP_LINE, because bash divides "--key=value" into three.
constexpr char kFunctions[] = R"bash(
_drapefit_files() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -f -- "$1")
}

_drapefit() {
  local line=${COMP_LINE:0:COMP_POINT} program=${1##*/} verb word key
  word=${line##*[[:space:]]}
  COMPREPLY=()
  if [[ $program == drapefit ]]; then
    read -r _ verb _ <<<"$line"
    if [[ $word == "$verb" && $word != -* ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$_drapefit_verbs help" -- "$word"; compgen -f -- "$word")
      return
    fi
    if [[ $verb == help ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$_drapefit_verbs" -- "$word")
      return
    fi
    [[ " $_drapefit_verbs " == *" ${verb//-/_} "* ]] && program=drape_${verb//-/_}
  fi
  if [[ $word == --*=* ]]; then
    key=${word%%=*}
    word=${word#*=}
    local values
    values=$(_drapefit_values "$program$key")
    if [[ -n $values ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
    else
      _drapefit_files "$word"
    fi
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_drapefit_options "$program")" -- "$word")
    [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace 2>/dev/null
  else
    _drapefit_files "$word"
  fi
}
)bash";

void AddTable(const json& table, std::string* options, std::string* values) {
  const std::string tool = table.at("tool");
  *options += "    " + tool + ") echo '--help --version --config=";
  for (const json& section : table.at("sections")) {
    for (const json& option : section.at("options")) {
      const std::string key = option.at("key");
      const bool is_switch = option.at("is_switch");
      *options += " --" + key + (is_switch ? "" : "=");
      std::string choices = is_switch ? " true false" : "";
      for (const std::string choice : option.at("choices")) choices += " " + choice;
      if (!choices.empty())
        *values += "    " + tool + "--" + key + ") echo '" + choices.substr(1) + "' ;;\n";
    }
  }
  *options += "' ;;\n";
}

}  // namespace

std::string BashCompletion(const json& front, const std::vector<ProgramTable>& programs) {
  std::string verbs, names = "drapefit", options, values;
  AddTable(front, &options, &values);
  for (const ProgramTable& program : programs) {
    verbs += (verbs.empty() ? "" : " ") + program.verb;
    names += " " + program.table.at("tool").get<std::string>();
    AddTable(program.table, &options, &values);
  }
  return "# Completion of drapefit and its programs for bash, made from their option tables.\n"
         "_drapefit_verbs='" +
         verbs + "'\n\n_drapefit_options() {\n  case $1 in\n" + options +
         "  esac\n}\n\n_drapefit_values() {\n  case $1 in\n" + values + "  esac\n}\n" + kFunctions +
         "\ncomplete -F _drapefit " + names + "\n";
}

}  // namespace drape
