#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# drapefit lists and runs the programs beside it, its manual pages and completion are sound, and the
# way from a picture to a report stops at a failure and continues there.
# usage: front_test.sh <source folder> <build folder>
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "$*"; exit 1; }
drapefit=$build/bin/drapefit

# The list agrees with the programs: each is in it with a line of at most 100 columns, and runs by its
# verb and by its name.
"$drapefit" >"$scratch/list"
long=$(LC_ALL=C.UTF-8 grep -E '.{101}|…$' "$scratch/list") && fail "too long for the list: $long"
mkdir "$scratch/man"
"$drapefit" --help=man >"$scratch/man/drapefit.1"
links=0
for program in "$build"/bin/drape_*; do
  if [ -L "$program" ]; then links=$((links + 1)); fi
  name=${program##*/}
  grep -qE "^  ${name#drape_}  +[a-z].* .* " "$scratch/list" ||
    fail "drapefit --help lacks $name or its description"
  "$program" --help >"$scratch/by_name"
  grep -q "^$name " "$scratch/by_name" || fail "$name runs another program"
  "$drapefit" "${name#drape_}" --help | cmp - "$scratch/by_name" ||
    fail "drapefit ${name#drape_} is not $name"
  "$program" --help=man >"$scratch/man/$name.1"
done
[ "$links" -ge 10 ] || fail "only $links programs are links to drapefit"
"$drapefit" help fit | grep '^drape_fit ' >/dev/null || fail "help fit is not that of drape_fit"
if "$drapefit" fti 2>"$scratch/err"; then fail "ran an unknown verb"; else [ $? -eq 2 ]; fi
grep -q "unknown verb 'fti', did you mean 'fit'" "$scratch/err"

# The fabrics that programs know by name.
"$drapefit" fabrics --starts=0 >"$scratch/fabrics"
for file in "$source"/configs/fabrics/*.json; do
  name=$(basename "$file" .json)
  grep -q "^$name  *[0-9]" "$scratch/fabrics" || fail "drapefit fabrics lacks $name"
done
"$drapefit" simulate --fabric=synthetic_knit --mesh=disc:100 --steps=2 --out="$scratch/knit" \
  >"$scratch/log" 2>&1 || fail "knows no fabric by its name: $(cat "$scratch/log")"
grep -q 'fabrics/synthetic_knit.json' "$scratch/knit/summary.json" || fail "took another fabric"

# Manual pages.
if command -v groff >/dev/null; then
  for page in "$scratch"/man/*.1; do
    warnings=$(groff -k -man -Tutf8 -ww "$page" 2>&1 >"$scratch/page")
    [ -z "$warnings" ] || fail "$page: $warnings"
    grep -q OPTIONS <(sed 's/.\x08//g' "$scratch/page") || fail "$page shows no options"
  done
else
  echo "no groff here: manual pages are not formatted"
fi

# Completion, as bash calls it.
# shellcheck disable=SC1091
. "$source/tools/programs/front/completion.bash"
complete_line() {
  COMP_LINE=$1 COMP_POINT=${#1} COMPREPLY=()
  _drapefit "$build/bin/${1%% *}" 2>/dev/null || true
  [ "${COMPREPLY[*]}" = "$2" ] || fail "completes '$1' to '${COMPREPLY[*]}', expected '$2'"
}
complete_line "drapefit fi" "fit"
complete_line "drapefit help fi" "fit"
complete_line "drapefit fit --dens" "--density="
complete_line "drape_fit --model=bay" "bayes"
complete_line "drapefit fit --resu" "--resume"
complete_line "drapefit --picture=sil" "silhouette"
complete_line "drapefit drape.jpg --picture=sil" "silhouette"
complete_line "drape_fit --images=$source/tools/quick" "$source/tools/quickstart"

# From a picture to a report, with programs that only tell how they were called.
mkdir "$scratch/bin" "$scratch/configs" "$scratch/configs/programs"
cp "$drapefit" "$scratch/bin"
echo '{}' >"$scratch/configs/programs/fit_bayes.json"
for verb in fit predict report photo; do
  cat >"$scratch/bin/drape_$verb" <<END
#!/bin/sh
echo "$verb \$*" >>"$scratch/calls"
[ ! -e "$scratch/fail_$verb" ] || { echo "drape_$verb: error: no" >&2; exit 3; }
for word; do case \$word in --out=*.html) : >"\${word#--out=}" ;;
  --out=*) mkdir -p "\${word#--out=}"
    hash=\$(sha256sum <"$scratch/input_$verb" | cut -d' ' -f1)
    echo "{\"words\": \"\$*\", \"provenance\": {\"configs\": [], \"inputs\":
      [{\"path\": \"$scratch/input_$verb\", \"sha256\": \"\$hash\"}]}}" \
      >"\${word#--out=}/summary.json" ;; esac; done
END
  chmod +x "$scratch/bin/drape_$verb"
  echo "$verb" >"$scratch/input_$verb"
done
cd "$scratch"
called() {
  [ "$(cut -d' ' -f1 calls | tr '\n' ' ')" = "$1" ] || fail "called: $(cat calls), expected: $1"
  : >calls
}
# A picture of one black pixel in white, as PNG.
base64 -d >drape.png <<'END'
iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAADklEQVR4nGNg+P//PwMABf4C/gzqvhsAAAAASUVORK5CYII=
END
touch fail_predict
code=0
bin/drapefit drape.png --picture=silhouette --mass=150 >log 2>err || code=$?
[ $code -eq 3 ] || fail "exit code $code of a step that failed with 3: $(cat err)"
grep -q 'density=0.15' calls || fail "mass is not in kg/m2: $(cat calls)"
called "fit predict "
rm fail_predict
bin/drapefit drape.png --picture=silhouette --mass=150 >log
grep -q 'done before: drapefit fit' log || fail "does not say that the fit is done"
called "predict report "
bin/drapefit drape.png --picture=silhouette --mass=150 >log
called ""
echo changed >input_predict  # such as the table that a config names
bin/drapefit drape.png --picture=silhouette --mass=150 >log
called "predict report "
bin/drapefit drape.png --picture=silhouette --mass=160 >log
called "fit predict report "
bin/drapefit drape.png --picture=photo --mass=150 >log
grep -q 'camera_file=out/drape/photo/camera.json' calls || fail "fit has no camera: $(cat calls)"
called "photo fit predict report "
bin/drapefit drape.png --picture=photo --mass=150 --specimen=0.24 >log
[ "$(grep -c 'specimen=0.24 --support=0.18' calls)" -eq 3 ] || fail "lost the size: $(cat calls)"
called "photo fit predict report "
if bin/drapefit drape.png 2>err; then fail "took no mass"; else [ $? -eq 2 ]; fi
grep -q "option 'mass': is missing" err
# Another picture of the same name does not replace the results of the first.
mkdir cotton
{ cat drape.png; echo other; } >cotton/drape.png
if bin/drapefit cotton/drape.png --picture=silhouette --mass=150 2>err; then
  fail "wrote over the results of another picture"
else [ $? -eq 2 ]; fi
grep -q 'out/drape: holds the results of another picture, drape.png' err || fail "$(cat err)"
called ""
# The printed commands can be pasted: the shell reads the words that the programs have got.
name=$(printf "it's a \033[1m \303\274 %0210d.png" 7)
cp drape.png "$name"
bin/drapefit "$name" --picture=silhouette --mass=150 --out=out/pasted >log
if grep -q "$(printf '\033')" log; then fail "sends control characters to the terminal"; fi
sed -n 's/^drapefit: drapefit fit/drape_fit/p' log >command
head -1 calls >expected
: >calls
PATH=$scratch/bin:$PATH
# shellcheck disable=SC1091
. ./command
cmp calls expected || fail "pasted: $(cat calls), expected: $(cat expected)"

# A signal ends the step that runs, even one that succeeds then, and no other is begun. A script ends
# what it runs, too.
printf '#!/bin/sh\necho "fit $*" >>calls\ntrap "exit 0" INT TERM\nsleep 9 &\nwait\n' >bin/drape_fit
mkdir -p share/drapefit
mkdir scripts
printf '#!/bin/sh\nsleep 9 &\necho $! >started\nwait\n' >scripts/drapefit
chmod +x scripts/drapefit
interrupt() {  # signal, what shows that it runs, command: exit code
  rm -f "$2"
  "${@:3}" >log 2>&1 &
  for _ in $(seq 300); do
    [ -s "$2" ] && break
    sleep 0.01
  done
  kill -"$1" $!
  code=0
  wait $! || code=$?
  [ "$code" = 130 ] || fail "$3 ended with exit code $code after SIG$1: $(cat log)"
}
set -m  # otherwise commands in the background ignore SIGINT
for number in INT TERM; do
  interrupt $number calls bin/drapefit drape.png --picture=silhouette --mass=170
  called "fit "
  PATH=$scratch/scripts:$PATH interrupt $number share/drapefit/started \
    "$source/tools/quickstart" --installed "$scratch/quick"
  for i in $(seq 101); do
    case $(ps -o stat= -p "$(cat share/drapefit/started)") in '' | Z*) break ;; esac
    [ "$i" -le 100 ] || fail "the quickstart left a process after SIG$number"
    sleep 0.01
  done
done
