#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The Debian packages of a build: lintian finds nothing, they install into a clean Debian 12, the
# quickstart passes with the installed programs, the consumer builds with the installed library, and
# nothing is left when they are purged.
# usage: package_test.sh <source folder> <build folder> <cpack>
# CHROOT=FILE: the tar of the clean system, made there if it is missing; otherwise it is made each time.
set -euo pipefail
source=$1 build=$2 cpack=$3
skip() { printf 'tests/repository/package_test.sh: Skipped\n%s\n' "$*"; exit 77; }
fail() { echo "$*"; exit 1; }
for tool in lintian mmdebstrap dpkg-shlibdeps unshare; do
  command -v "$tool" >/dev/null || skip "no $tool here: tools/setup/install_packages packaging"
done
[ "$(id -u)" -eq 0 ] || skip "the clean system needs root"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
root=$scratch/root

(cd "$build" && "$cpack" -B "$scratch/packages") >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
debs=("$scratch"/packages/*.deb)
ls -l "${debs[@]}"
lintian --allow-root --fail-on error,warning --tag-display-limit 0 "${debs[@]}"

# A clean system, with the sources of mmdebstrap's mirror.
tar=${CHROOT:-$scratch/root.tar}
if [ ! -e "$tar" ] && ! mmdebstrap --quiet --variant=minbase bookworm "$tar" 2>"$scratch/log"; then
  skip "mmdebstrap makes no clean system here: $(tail -n 1 "$scratch/log")"
fi
mkdir "$root"
tar -xf "$tar" -C "$root"
cp /etc/resolv.conf "$root/etc/"
mkdir "$root/packages" "$root/source"
cp "${debs[@]}" "$root/packages"
cp -r --parents "$source/tools/quickstart" "$source/tests/repository/consumer" "$scratch"
mv "$scratch$source"/* "$root/source"
# Mounts end with the command.
Inside() {
  unshare --mount --propagation private bash -c '
    mount -t proc proc "$0/proc"
    mount --rbind /dev "$0/dev"
    exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
      DEBIAN_FRONTEND=noninteractive chroot "$0" "$@"' "$root" "$@"
}
Install() {
  Inside apt-get install -qq -y --no-install-recommends "$@" >"$scratch/log" 2>&1 ||
    { cat "$scratch/log"; exit 1; }
}
# The package of that name as the clean system sees it; fails where there is none.
Package() { (cd "$root" && ls -1 packages/"$1"_*.deb 2>/dev/null | sed 's~^~/~' | grep .); }
# All files but those of dpkg, apt and the loader, which change with any package.
Files() {
  (cd "$root" && find etc opt srv usr var -not -path 'var/lib/dpkg/*' -not -path 'var/lib/apt/*' \
    -not -path 'var/cache/*' -not -path 'var/log/*' -not -path 'etc/ld.so.cache' | sort)
}

Inside apt-get update -qq
Install "$(Package drapefit || Package drapefit-cuda)"
Inside bash /source/tools/quickstart --installed /tmp/quickstart | tee "$scratch/quickstart"
grep -q 'bending good' "$scratch/quickstart" || fail "the quickstart finds no good fit"
[ -s "$root/tmp/quickstart/report.html" ] || fail "the quickstart leaves no report"
Inside drapefit help fit | grep -q '^drape_fit ' || fail "drapefit does not find the programs beside it"

if package=$(Package libdrapefit-dev); then
  Install cmake ninja-build "$package"
  Inside sh -c 'cmake -S /source/tests/repository/consumer -B /tmp/consumer -G Ninja \
    -DCMAKE_BUILD_TYPE=Release >/dev/null && cmake --build /tmp/consumer >/dev/null'
  Inside /tmp/consumer/consumer /tmp/quickstart/reference/silhouette.png \
    /usr/share/drapefit/configs/fabrics/synthetic_shirt.json |
    grep -E '^(good|usable): bending rigidity ' || fail "the consumer fits no drape"
fi
if package=$(Package python3-drapefit); then
  Install "$package"
  Inside python3 -c 'import drapefit' || fail "python3 cannot import the module"
fi

packages=$(Inside dpkg-query -W -f='${Package} ${source:Package}\n' |
  awk '$2 == "drapefit" { print $1 }')
Files >"$scratch/before"
# shellcheck disable=SC2086
Inside apt-get purge -qq -y $packages >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
Files >"$scratch/after"
if left=$(grep drape "$scratch/after"); then fail "left after purging $packages: $left"; fi
if new=$(comm -13 "$scratch/before" "$scratch/after" | grep .); then fail "made by purging: $new"; fi
if Inside dpkg-query -W -f='${Package} ${Status}\n' | grep drapefit; then fail "dpkg knows purged packages"; fi
echo "purged:" $packages
