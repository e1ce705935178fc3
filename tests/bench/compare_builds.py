#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what two builds write: the quickstart and small cases of each program.

usage: compare_builds.py run OUT [CASE ...]        runs the cases with the build of this checkout
       compare_builds.py compare OLD NEW [CASE ...]    compares two such folders

Configure both builds with -DCMAKE_CXX_FLAGS=-ffp-contract=off. Otherwise the compiler contracts
products and sums by the shape of each function, and a function that moved changes the last bits.

Files are compared byte for byte. In JSON, members that hold times, paths and provenance are left
out, and members that only one build writes are listed apart. Exit code 1: a value differs, or a
case failed.
"""
import json
import pathlib
import re
import subprocess
import sys

# Members whose values depend on the machine, the build or the folder, and not on the result.
PASSING = re.compile(r'second|time_s$|_ms$|peak_mb|provenance|version|sha|path|file|folder|command|source$|'
                     r'options|threads|created|backend|device|^key$|^id$|^log|built|speed')
CASES = {
    # The fabric is given by {fabric}: --material in older builds, --fabric in newer ones.
    'quickstart_drape': 'simulate --config=configs/programs/quickstart/simulate.json --out={out}',
    'quickstart_fit': 'fit --config=configs/programs/quickstart/fit.json '
                      '--images={other}/quickstart_drape/silhouette.png --out={out}',
    'simulate_cantilever': 'simulate --config=configs/programs/simulate_cantilever.json --out={out}',
    'simulate_steps': 'simulate {fabric}=configs/fabrics/synthetic_felt.json --mesh=disc:300 '
                      '--start=configs/starts/four_waves.json --steps=40 --time_step=0.05 '
                      '--contact=support --solve=dynamic --out={out}',
    'fit_lab_tests': 'fit --config=configs/programs/fit_lab_tests.json --out={out}',
    'fit_bayes': 'fit --config=configs/programs/fit_bayes.json --mesh=disc:200 '
                 '--coarse_mesh=disc:150 --camera=orthographic --posterior_iterations=3 '
                 '--images={other}/quickstart_drape/silhouette.png --out={out}',
    'fit_heterogeneous': 'fit --config=configs/programs/fit_heterogeneous.json --mesh=disc:200 '
                         '--coarse_mesh=disc:150 --field_iterations=5 '
                         '--images={other}/quickstart_drape/silhouette.png --out={out}',
    'predict': 'predict --config=configs/programs/predict.json --mesh=disc:200 --draws=8 --out={out}',
    'predict_posterior': 'predict {posterior}={other}/fit_bayes --mesh=disc:200 --draws=8 '
                         '--out={out}',
    'equilibria': 'equilibria --config=configs/programs/equilibria.json --mesh=disc:200 --samples=6 '
                  '--out={out}',
    'equilibria_mirrored': 'equilibria {fabric}=configs/fabrics/synthetic_knit.json --mesh=disc:150 '
                           '--samples=4 --contact=support --distance=vertices --out={out}',
    'check': 'check --config=configs/programs/check.json',
    'check_reference': 'check --config=configs/programs/check.json --law=reference --mesh=disc:100',
    'metrics': 'metrics {other}/quickstart_drape/silhouette.png --image_width_mm=355.8 '
               '--out={out}.json',
    'metrics_two': 'metrics {other}/quickstart_drape/drape.obj '
                   '{other}/quickstart_fit/drape_silhouette.obj '
                   '--out={out}.json',
    'export': 'export {source}{other}/quickstart_fit --to=all --mesh=disc:150 --starts=1 --out={out}',
    'export_posterior': 'export {source}{other}/fit_bayes --to=csv,json --mesh=disc:150 --starts=0 '
                        '--out={out}',
    'report': 'report {other}/quickstart_fit --out={out}.html',
    'garment_skirt': 'garment --garment=configs/garments/circle_skirt.json --edge=0.06 '
                     '--seconds=1.4 --threads=1 {fabric}=configs/fabrics/cotton_blue.json '
                     '--body=mannequin:walk --out={out}',
    'garment_dress': 'garment --garment=configs/garments/tank_dress.json --edge=0.08 '
                     '--seconds=0.4 --threads=1 {fabric}=configs/fabrics/synthetic_knit.json '
                     '--body=mannequin:jump --out={out}',
    'stability': 'stability --config=configs/studies/stability_quick.json --out={out}',
    'gradients': 'gradients --config=configs/studies/gradients.json --mesh=disc:100 '
                 '--horizons=1,3,10 --time_steps=0.05 --fold_starts=1 --out={out}',
    'bench': 'bench --config=configs/studies/bench/quick.json --mesh=disc:100,disc:200 '
             '--reference=disc:200,disc:400 --reference_relax_mesh=disc:100 --run_seconds=0.1 '
             '--out={out}',
    'optimisers': 'compare_optimisers --config=configs/studies/compare_optimisers.json '
                  '--num_parameters=7 --budget=8 --mesh=disc:100 --coarse_mesh=disc:100 '
                  '--twin_mesh=disc:150 --out={out}',
}


def run(tree, case, out):
    """Runs a case; returns whether it succeeded."""
    program = tree / 'build/release/bin/drapefit'
    usage = subprocess.run([program, 'simulate', '--help'], capture_output=True, text=True,
                           check=True).stdout
    one_option = '--fabric' in usage
    words = CASES[case].format(out=out / case, other=out,
                               fabric='--fabric' if one_option else '--material',
                               posterior='--fabric' if one_option else '--posterior',
                               source='--fabric=' if one_option else '').split()
    done = subprocess.run([program, *words], cwd=tree, capture_output=True, text=True)
    (out / (case + '.txt')).write_text(done.stdout)
    if done.returncode != 0:
        print(f'{case}: exit code {done.returncode}: {done.stderr.strip()[-300:]}', flush=True)
    return done.returncode == 0


def differences(old, new, at, only):
    """Lists where two JSON values differ; members of one side alone go to `only`."""
    if isinstance(old, dict) and isinstance(new, dict):
        found = []
        for key in sorted(set(old) | set(new)):
            if PASSING.search(key):
                continue
            if key in old and key in new:
                found += differences(old[key], new[key], f'{at}/{key}', only)
            else:
                only.append(f'{at}/{key} ({"old" if key in old else "new"})')
        return found
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return [d for k, pair in enumerate(zip(old, new))
                for d in differences(*pair, f'{at}/{k}', only)]
    return [] if old == new else [f'{at}: {str(old)[:60]} → {str(new)[:60]}']


def compare_files(old, new, only):
    if old.suffix == '.json':
        values = [json.loads(re.sub(r'^\s*//.*$', '', p.read_text(), flags=re.M))
                  for p in (old, new)]
        return differences(*values, '', only)
    if old.suffix in ('.html', '.svg', '.log'):  # they hold times and random identifiers
        return []
    if old.suffix in ('.txt', '.md', '.csv'):
        timed = re.compile(r'seconds|[0-9] m?s\b|/|MB')
        lines = [[line for line in p.read_text().splitlines() if not timed.search(line)]
                 for p in (old, new)]
        return [f'{a[:70]} → {b[:70]}' for a, b in zip(*lines) if a != b] or (
            [] if len(lines[0]) == len(lines[1]) else
            [f'{len(lines[0])} → {len(lines[1])} lines'])
    return [] if old.read_bytes() == new.read_bytes() else ['bytes differ']


def compare(case, outs):
    old, new = ({p.relative_to(out).as_posix(): p for p in sorted(out.rglob('*'))
                 if p.is_file() and '/cells/' not in p.as_posix() and
                 re.match(re.escape(case) + r'(/|\.|$)', p.relative_to(out).as_posix())}
                for out in outs)
    only, found = [], []
    for name in sorted(set(old) | set(new)):
        if name not in old or name not in new:
            only.append(f'{name} ({"old" if name in old else "new"})')
            continue
        found += [f'{name}{d}' if d.startswith('/') else f'{name}: {d}'
                  for d in compare_files(old[name], new[name], only)]
    print(f'{case}: {len(set(old) & set(new))} files, {len(found)} differences, '
          f'{len(only)} of one build alone')
    for line in found[:8] + [f'only {line}' for line in only[:8]]:
        print('   ', line)
    return found


def main():
    words = sys.argv[1:]
    if words[:1] == ['run'] and len(words) > 1:
        out = pathlib.Path(words[1]).resolve()
        out.mkdir(parents=True, exist_ok=True)
        tree = pathlib.Path(__file__).resolve().parents[2]
        sys.exit(not all([run(tree, case, out) for case in words[2:] or CASES]))
    if words[:1] == ['compare'] and len(words) > 2:
        outs = [pathlib.Path(folder).resolve() for folder in words[1:3]]
        sys.exit(any([compare(case, outs) for case in words[3:] or CASES]))
    sys.exit(__doc__)


if __name__ == '__main__':
    main()
