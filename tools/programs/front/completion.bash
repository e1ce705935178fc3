# SPDX-License-Identifier: Apache-2.0
# Completion for bash of the program that this file is named like when it is installed: verbs,
# options, their choices, and files. Options and choices are read from --help=all.

# A word is read from COMP_LINE, because bash divides "--key=value" into three.
_drapefit() {
  local line=${COMP_LINE:0:COMP_POINT} command=("$1") verb='' word words=''
  word=${line##*[[:space:]]}
  COMPREPLY=()
  if [[ ${1##*/} == drapefit ]]; then
    read -r _ verb _ <<<"$line"
    if [[ $word != -* && ($word == "$verb" || $verb == help) ]]; then
      words="help $("$1" | sed -n 's/^  \([a-z_]*\)  .*/\1/p')"
    elif [[ $verb != -* ]]; then
      command+=("$verb")
    fi
  fi
  if [[ $word == -* ]]; then
    words=$({ printf '%s\n' --help --version --config=; "${command[@]}" --help=all; } | awk '
      /^--[a-z]*=?$/ { print }
      /^  --/ { type = substr($2, 2); sub(/>.*/, "", type); print $1 (type == "switch" ? "" : "=")
                if (type ~ /\|/) for (i = split(type, choice, "|"); i > 0; --i) print $1 "=" choice[i] }
      ' | if [[ $word == *=* ]]; then
      sed -n "s/^${word%%=*}=\(.\)/\1/p"
    else
      sed 's/=.*/=/' | uniq
    fi)
    if [[ $word == *=* ]]; then word=${word#*=}; fi
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  if [[ ${#COMPREPLY[@]} -eq 0 || $word == "$verb" ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$word")
  elif [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then
    compopt -o nospace 2>/dev/null
  fi
}
complete -F _drapefit "${BASH_SOURCE[0]##*/}"
