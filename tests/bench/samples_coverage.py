#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Repeats the experiment of bench_samples with photographs and counts how often intervals hold.

usage: samples_coverage.py PROGRAMS FOLDER FIRST LAST

PROGRAMS has drapefit. FOLDER gets known.csv and one folder for each seed from FIRST to LAST; what is
there is kept. Prints one line for each experiment and fabric, and the counts.
"""
import collections
import csv
import json
import pathlib
import subprocess
import sys

QUANTITIES = ('bending_overall_un_m', 'bending_length_overall_cm')


def run(programs, folder, seed):
    """The folder of the results of an experiment."""
    photographs, out = folder / f'{seed}', folder / f'{seed}_out'
    if not (photographs / 'samples.csv').exists():
        subprocess.run([programs / 'bench_samples', 'photos', photographs, str(seed)], check=True)
    subprocess.run([programs / 'drapefit', photographs, f'--out={out}'], check=True,
                   stdout=subprocess.DEVNULL)
    return out


def intervals(known, out):
    """(fabric, quantity, known, low, high) of all that is known of an experiment."""
    samples = json.loads((out / 'photo/summary.json').read_text())['samples']
    for group in samples['groups']:
        if not group['specimen'] and not group['face']:
            yield (group['fabric'], 'dc_percent', float(known[group['fabric']]['dc_percent']),
                   group['dc_low_percent'], group['dc_high_percent'])
    for each in samples['differences']:
        difference = float(known[each['a']]['dc_percent']) - float(known[each['b']]['dc_percent'])
        yield f'{each["a"]} - {each["b"]}', 'dc_percent', difference, each['low'], each['high']
    for fabric in known:
        summary = json.loads((out / f'fit_{fabric}/summary.json').read_text())
        for row in summary['laboratory']['material']['rows']:
            if row['key'] in QUANTITIES:
                yield fabric, row['key'], float(known[fabric][row['key']]), row['low'], row['high']


def main(programs, folder, first, last):
    programs, folder = pathlib.Path(programs).resolve(), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / 'known.csv').exists():
        subprocess.run([programs / 'bench_samples', 'known', folder / 'known.csv'], check=True)
    known = {row['fabric']: row for row in csv.DictReader((folder / 'known.csv').open())}
    counts = collections.defaultdict(list)
    for seed in range(int(first), int(last) + 1):
        for fabric, key, value, low, high in intervals(known, run(programs, folder, seed)):
            holds = (low is None or low <= value) and (high is None or value <= high)
            counts[key, ' - ' in fabric].append(holds)
            print(f'{seed} {fabric}: {key} {value:.2f} {"in" if holds else "not in"} {low} … {high}',
                  flush=True)
    for (key, is_difference), held in counts.items():
        print(f'{"difference of " * is_difference}{key}: {sum(held)} of {len(held)}')


if __name__ == '__main__':
    if len(sys.argv) != 5:
        sys.exit(__doc__.split('\n\n')[1])
    main(*sys.argv[1:])
