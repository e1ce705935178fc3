#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Each check of tests/repository/rules is silent on a clean repository and finds every fault planted in it.
# usage: rules_test.sh
set -euo pipefail
checks=$(realpath "$(dirname "$0")/rules")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
status=0

# A clean repository, as small as the checks allow; Start makes a copy of it to plant a fault in.
Make() {
  mkdir -p "$scratch"/clean/{physics/util,losses/outline,solver/fit,configs}
  cd "$scratch/clean"
  git init -q .
  printf 'physics/util\nlosses/outline\nsolver/fit !losses/outline +losses/outline/ray.h\n' >rooms
  printf 'prose \\bforetell(s)?\\b => predict\ncode \\b[A-Z]\\w*Of(?=\\() => ComputeX\n' >word_list
  : >allowed
  printf 'BasedOnStyle: Google\n' >.clang-format
  printf '#pragma once\n// Of one edge [Gong 2024, eq. 12], [MODEL, M1].\n' >physics/util/vec.h
  printf '#pragma once\n#include "physics/util/vec.h"\n' >losses/outline/ray.h
  printf '#pragma once\n' >losses/outline/outline.h
  printf '#include "losses/outline/ray.h"\n#include "physics/util/vec.h"\n\nint Fit() { return 0; }\n' >solver/fit/fit.cc
  printf '# Model\n**(M1)** F = ma\n\n- **[Gong 2024]** A title.\n' >physics/MODEL.md
  printf '# Methods\n' >solver/METHODS.md
  git add .
  git -c user.name=n -c user.email=e commit -q -m 'Add a fit' -m 'The reason.'
}
Make

Start() {
  rm -rf "$scratch/repo"
  cp -r "$scratch/clean" "$scratch/repo"
  cd "$scratch/repo"
}

Run() {
  case $1 in
    layers) "$checks/layers.sh" . rooms ;;
    words) "$checks/words.sh" . word_list allowed ;;
    commits) "$checks/commits.sh" . ;;
    *) "$checks/$1.sh" . ;;
  esac
}

# Finds <check> <text of the finding> <what is planted>; the fault is on standard input as commands.
Finds() {
  Start
  # shellcheck source=/dev/null
  source /dev/stdin
  if Run "$1" >"$scratch/out" 2>&1; then
    echo "$1.sh does not find $3"
    status=1
  elif ! grep -qF -- "$2" "$scratch/out"; then
    echo "$1.sh finds $3 but says:"
    cat "$scratch/out"
    status=1
  fi
}

for check in layers words markdown_width bibliography format commits; do
  Start
  result=0
  Run "$check" >"$scratch/out" 2>&1 || result=$?
  if [ $result != 0 ] && [ $result != 77 ]; then
    echo "$check.sh finds in a clean repository:"
    cat "$scratch/out"
    status=1
  fi
  if [ $result = 77 ]; then skipped="${skipped:-} $check"; fi
done

Finds layers 'physics/util/vec.h:3: includes losses/outline/outline.h, but losses/outline is above' 'an arrow that runs back' <<'X'
echo '#include "losses/outline/outline.h"' >>physics/util/vec.h
X
Finds layers 'may not include losses/outline' 'a forbidden room' <<'X'
echo '#include "losses/outline/outline.h"' >>solver/fit/fit.cc
X
Finds layers 'solver/job/job.cc: in no room' 'a file in no room' <<'X'
mkdir solver/job && echo >solver/job/job.cc
X
Finds layers 'does not exist' 'an include of nothing' <<'X'
echo '#include "physics/util/none.h"' >>solver/fit/fit.cc
X
Finds layers 'path from the root' 'an include without its folder' <<'X'
echo '#include "fit.h"' >>solver/fit/fit.cc
X
Finds layers 'solver/fit: shows 10 things' 'ten things in a folder' <<'X'
for i in 1 2 3 4 5 6 7 8 9; do echo >solver/fit/unit_$i.h; echo >solver/fit/unit_$i.cc; done
X
Finds layers 'holds no source' 'a room that is gone' <<'X'
echo 'solver/gone' >>rooms
X
Finds words 'README.md:2: "foretells"; write: predict' 'a word in Markdown' <<'X'
printf '# Title\nIt Foretells.\n' | sed s/Foretells/foretells/ >README.md
X
Finds words 'solver/fit/fit.cc:7: "foretell"' 'a word in a comment and not in a name' <<'X'
printf 'int foretell;\nint a;  /* to\nforetell */\n' >>solver/fit/fit.cc
X
Finds words 'solver/fit/fit.cc:5: "foretells"' 'a word in a string' <<'X'
echo 'const char* s = "it \" foretells";' >>solver/fit/fit.cc
X
Finds words '"MeanOf"' 'a name' <<'X'
echo 'int a = MeanOf(1);' >>solver/fit/fit.cc
X
Finds words 'no longer contains' 'a use that is allowed and gone' <<'X'
echo 'README.md: foretells' >allowed
X
Finds markdown_width 'README.md:3: 105 columns' 'a long line' <<'X'
printf '# T\n\n%s ü€ é\n' "$(printf '%0100d' 0)" >README.md
X
Finds bibliography 'physics/util/vec.h:3: [Li 2020, eq. 1]: no entry' 'a key without an entry' <<'X'
echo '// As [Li 2020, eq. 1] has it.' >>physics/util/vec.h
X
Finds bibliography '[Li et al. 2020]: no entry' 'a key over two lines' <<'X'
printf '// As [Li et al.\n// 2020] has it.\n' >>physics/util/vec.h
X
Finds bibliography '[MODEL, M2]: physics/MODEL.md has no' 'an anchor that is not there' <<'X'
echo '// [MODEL, M2]' >>physics/util/vec.h
X
Finds bibliography '"SPEC"' 'a document elsewhere' <<'X'
echo '// SPEC section 5' >>physics/util/vec.h
X
Finds bibliography '"fact" with a number' 'a numbered fact' <<'X'
echo '// as fact 7 says' >>physics/util/vec.h
X
Finds bibliography '"the paper"' 'a paper without a name' <<'X'
echo "// the paper's table" >>physics/util/vec.h
X
if [[ "${skipped:-}" != *format* ]]; then
  Finds format 'solver/fit/fit.cc:5: not formatted' 'a file that is not formatted' <<'X'
echo 'int  Bad( ){return 1;}' >>solver/fit/fit.cc
X
fi

# FindsCommit <text of the finding> <subject> [<body>]
FindsCommit() {
  Finds commits "$1" "a commit \"$2\"" <<X
git -c user.name=n -c user.email=e commit -q --allow-empty -m $(printf '%q' "$2") ${3:+-m $(printf '%q' "$3")}
X
}
FindsCommit '61 characters' "Add $(printf '%057d' 0)" 'The reason.'
FindsCommit 'no verb in the imperative' 'Words of the README' 'The reason.'
FindsCommit 'no verb in the imperative' 'Added a test' 'The reason.'
FindsCommit 'no verb in upper case' 'solver: add a fit' 'The reason.'
FindsCommit 'has no body' 'Add a test'
FindsCommit 'several topics' 'Add a test; mend a fit' 'The reason.'

if [ -n "${skipped:-}" ]; then echo "Skipped here:$skipped"; fi
exit $status
