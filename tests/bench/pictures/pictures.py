#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of known drape coefficient, made and measured: a table for tests/bench/PICTURES.md.

usage: pictures.py all OUT --half=tuning|kept       the three tasks that follow
       pictures.py make OUT --half=tuning|kept [--each=6] [--kinds=TEXT] [--bin=build/release/bin]
       pictures.py measure OUT --half=tuning|kept [--label=NAME] [--tools=photo,metrics,fit]
           [--kinds=TEXT] [--bin=…]
       pictures.py table OUT --half=tuning|kept [--label=NAME,NAME] [--list]
       pictures.py sheet OUT --half=tuning|kept

make simulates the drapes and writes the pictures with reference.json; measure writes
results_NAME.json; table prints counts by kind, with --list each picture that is not right; sheet
writes sheet.png, small copies of all pictures. Nobody looks at the kept half while tuning; the sets
"second" and "third" were looked at.
"""
import argparse
import collections
import json
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image, ImageDraw

sys.dont_write_bytecode = True  # the checkout stays clean
import drapes
import kinds
import render

ROOT = pathlib.Path(__file__).resolve().parents[3]
SEEDS = {'tuning': 41, 'second': 2041, 'third': 1041, 'kept': 8041}
TOOLS = ('photo', 'metrics', 'fit')
# What differs by less across more than 2 % of the border cannot be measured there, of 255.
LEAST_CONTRAST = 10.0
TOLERANCE = 1.0  # where a program states no ±, three of them [points]


def save(picture, values, path):
    image = Image.fromarray(values)
    turn = {1: None, 3: Image.Transpose.ROTATE_180, 6: Image.Transpose.ROTATE_90,
            8: Image.Transpose.ROTATE_270}[picture.orientation]
    if turn is not None:
        image = image.transpose(turn)
    options = {}
    if picture.dpi:
        options['dpi'] = (picture.dpi, picture.dpi)
    if picture.suffix == 'jpg':
        options.update(quality=picture.quality)
        if picture.focal_35mm:
            exif = Image.Exif()
            exif[0x0112] = picture.orientation
            exif[0x8769] = {0xA405: picture.focal_35mm}
            options['exif'] = exif
    if picture.mode != 'RGB':
        image = image.convert('L')
    if picture.mode == '1':
        image = image.point(lambda value: 255 * (value > 127)).convert('1')
    image.save(path, **options)


def describe(picture, name, contrast):
    camera = picture.scene.camera
    given = picture.specimen or 0.30
    weak = float(np.percentile(contrast, 2))
    return {
        'file': name, 'kind': picture.kind, 'view': picture.view, 'drape': picture.drape.name,
        'dc': picture.drape.coefficient, 'size': picture.drape.size, 'specimen_given': given,
        'px_per_m': camera.pixels_per_metre(),
        'scale_given': picture.scale_given, 'weakest_contrast': weak,
        'expect': 'refuse' if weak < LEAST_CONTRAST else picture.expect,
        'light': picture.scene.light and picture.scene.light.ratio}


def make(out, half, each, wanted, programs):
    folder = out / half
    folder.mkdir(parents=True, exist_ok=True)
    known = drapes.simulate(programs, folder / 'drapes', SEEDS[half])
    rows = []
    for number, (kind, arguments) in enumerate(kinds.KINDS):
        for index in range(each):
            rng = np.random.default_rng([SEEDS[half], number, index])
            picture = kind(kinds.Maker(rng, known), *arguments)
            if wanted and wanted not in picture.kind:
                continue
            light, share, disc = render.render(picture.scene, picture.drape, rng)
            values = render.develop(picture.scene, light, share, rng)
            name = f'{number:02}_{kind.__name__}_{picture.view}_{index}.{picture.suffix}'
            save(picture, values, folder / name)
            contrast = render.border_contrast(values, share, disc)
            rows.append(describe(picture, name, contrast))
            print(name, f'{picture.drape.coefficient:.1f}', flush=True)
    (folder / 'reference.json').write_text(json.dumps(rows, indent=1))


def command(tool, row, picture, out, programs):
    specimen = [] if row['specimen_given'] == 0.30 else [f'--specimen={row["specimen_given"]}']
    if tool == 'photo':
        scale = [] if row['view'] == 'phone' else ['--marker=none']
        if row['view'] == 'flat':
            scale.append(f'--px_per_m={row["px_per_m"]:.6g}' if row['scale_given'] else '--dpi')
        return [programs / 'drape_photo', picture, f'--out={out}', *scale, *specimen]
    # Scale of a telephone's picture: as a ruler on the support shows it.
    scale = [f'--camera_scale={row["px_per_m"]:.6g}' if row['scale_given'] else '--dpi']
    if tool == 'metrics':
        return [programs / 'drape_metrics', picture, f'--out={out}/summary.json', *scale, *specimen]
    # The picture is read before the fit, which is kept as short as it can be.
    return [programs / 'drape_fit', f'--images={picture}', f'--out={out}', *scale, *specimen,
            '--density=0.15', '--mesh=disc:100', '--search_mesh=disc:100',
            '--coarse_mesh=disc:100', '--candidates_per_round=1', '--iterations=0',
            '--initial_bend=1', '--initial_stretch=1', '--initial_lifts=0.8', '--initial_steps=1',
            '--num_parameters=1', '--simpler_models=false', '--settle_steps=1', '--threads=1']


def find(node, key):
    """The first value of a key anywhere in a JSON document."""
    if isinstance(node, dict):
        if node.get(key) is not None:
            return node[key]
        node = list(node.values())
    if isinstance(node, list):
        for value in node:
            if (found := find(value, key)) is not None:
                return found
    return None


def read_result(tool, summary):
    """The drape coefficient [%], its standard deviation or None, and the notes."""
    if tool == 'photo':
        return 100 * summary['dc'], 100 * summary['dc_sd'], summary.get('warnings', [])
    dc = find(summary, 'dc_image' if tool == 'fit' else 'dc')
    deviation = find(summary, 'dc_image_sd' if tool == 'fit' else 'dc_sd')
    quality = find(summary, 'quality') or {}
    notes = summary.get('notes', []) + quality.get('notes', [])
    # Says in each photograph what was seen; no doubt.
    notes = [note for note in notes if 'photograph: grey levels' not in note]
    return 100 * dc, deviation and 100 * deviation, list(dict.fromkeys(notes))


def measure(out, half, label, tools, wanted, programs):
    folder = out / half
    scratch = folder / f'scratch_{label}'
    scratch.mkdir(exist_ok=True)
    results = []
    for row in json.loads((folder / 'reference.json').read_text()):
        for tool in tools if wanted in row['kind'] else ():
            for old in scratch.glob('*'):
                if old.is_file():
                    old.unlink()
            words = [str(word) for word in command(tool, row, folder / row['file'], scratch,
                                                   programs)]
            done = subprocess.run(words, capture_output=True, text=True, timeout=300)
            result = {'file': row['file'], 'tool': tool, 'code': done.returncode,
                      'command': words}
            if done.returncode == 0:
                result['dc'], result['sd'], result['notes'] = read_result(
                    tool, json.loads((scratch / 'summary.json').read_text()))
            else:
                result['reason'] = done.stderr.strip()[-600:]
            results.append(result)
        print(row['file'], flush=True)
    (folder / f'results_{label}.json').write_text(json.dumps(results, indent=1))


def judge(row, result):
    """right; noted: off, with a note; refused; silent: off without a note; or broken (crashed)."""
    if result['code'] in (2, 3):  # 3: nothing could be fitted
        return 'refused'
    if result['code'] != 0:
        return 'broken'
    error = abs(result['dc'] - row['dc'])
    if error <= (TOLERANCE if result['sd'] is None else 3 * result['sd']):
        return 'right'
    return 'noted' if result['notes'] else 'silent'


def table(out, half, labels, listed):
    folder = out / half
    rows = {row['file']: row for row in json.loads((folder / 'reference.json').read_text())}
    counts, good = {}, {}
    for label in labels:
        for result in json.loads((folder / f'results_{label}.json').read_text()):
            row, column = rows[result['file']], (result['tool'], label)
            verdict = judge(row, result)
            line = counts.setdefault(row['kind'], {}).setdefault(column, collections.Counter())
            error = abs(result['dc'] - row['dc']) if result['code'] == 0 else np.inf
            line.update([verdict, 'all'])
            line['noted right'] += verdict == 'right' and bool(result['notes'])
            line['silent, far'] += verdict == 'silent' and error > 1
            by_scale = result['tool'] == 'photo' or row['view'] == 'flat'
            if row['expect'] == 'measure' and by_scale:
                good.setdefault(column, collections.Counter()).update(
                    ['all', 'close'] if error <= 1 else ['all'])
            if listed and verdict != 'right':
                print_case(row, result, verdict)
    print_table(counts, good)


def print_case(row, result, verdict):
    said = result.get('reason', '')
    if result['code'] == 0:
        deviation = '' if result['sd'] is None else f' ± {result["sd"]:.2f}'
        said = f'{result["dc"]:.1f}{deviation} {"; ".join(result["notes"])}'
    print(f'{verdict:8} {result["tool"]:8} {row["file"]:32} {row["dc"]:5.1f}: {said[-200:]}')


def print_table(counts, good):
    columns = sorted({column for line in counts.values() for column in line},
                     key=lambda column: TOOLS.index(column[0]))
    print('right / off, noted / refused / off, silent (by more than a point)\n')
    print('| kind | pictures | ' + ' | '.join(f'drape_{tool}, {label}' for tool, label in columns)
          + ' |')
    print('|---' * (len(columns) + 2) + '|')
    total = {column: sum((line.get(column, collections.Counter()) for line in counts.values()),
                         collections.Counter()) for column in columns}
    for kind, line in [*sorted(counts.items()), ('all', total)]:
        cells = []
        for column in columns:
            n = line.get(column, collections.Counter())
            cells.append(f'{n["right"]} / {n["noted"]} / {n["refused"]} / {n["silent"]}'
                         + (f' ({n["silent, far"]})' if n['silent'] else '')
                         + (f' broken {n["broken"]}' if n['broken'] else ''))
        print(f'| {kind} | {max(n["all"] for n in line.values())} | ' + ' | '.join(cells) + ' |')
    for column in columns:
        print(f'drape_{column[0]}, {column[1]}: {good[column]["close"]} of {good[column]["all"]} '
              f'good pictures are measured within 1 point; {total[column]["noted right"]} right '
              'ones have a note')


def sheet(out, half):
    folder = out / half
    rows = json.loads((folder / 'reference.json').read_text())
    across, side = 12, 160
    image = Image.new('RGB', (across * side, -(-len(rows) // across) * (side + 14)), 'white')
    pen = ImageDraw.Draw(image)
    for number, row in enumerate(rows):
        small = Image.open(folder / row['file']).convert('RGB')
        small.thumbnail((side - 4, side - 4))
        place = number % across * side, number // across * (side + 14)
        image.paste(small, place)
        pen.text((place[0], place[1] + side - 2), row['file'][:22], fill='black')
    image.save(folder / 'sheet.png')


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('task', choices=('all', 'make', 'measure', 'table', 'sheet'))
    parser.add_argument('out', type=pathlib.Path)
    parser.add_argument('--half', choices=tuple(SEEDS), required=True)
    parser.add_argument('--each', type=int, default=6, help='pictures of each kind')
    parser.add_argument('--kinds', default='', help='only kinds whose name has this text')
    parser.add_argument('--bin', type=pathlib.Path, default=ROOT / 'build/release/bin')
    parser.add_argument('--label', default='now')
    parser.add_argument('--tools', default=','.join(TOOLS))
    parser.add_argument('--list', action='store_true')
    given = parser.parse_args()
    programs = given.bin.resolve()
    if given.task in ('make', 'all'):
        make(given.out, given.half, given.each, given.kinds, programs)
    if given.task in ('measure', 'all'):
        measure(given.out, given.half, given.label, given.tools.split(','), given.kinds, programs)
    if given.task in ('table', 'all'):
        table(given.out, given.half, given.label.split(','), given.list)
    if given.task == 'sheet':
        sheet(given.out, given.half)
    return 0


if __name__ == '__main__':
    sys.exit(main())
