"""Compares random scenes: what rviz with the CameraPub plugin draws, and what camera_stream draws, live on one master.

A scene passes if the share of *close* pixels of each camera's picture is at least 0.98 (tests/golden/score.rs). One that does
not, twice, fails and leaves config, bag, pictures and logs in a folder of its seed; `camera_stream render` draws it again from
there.

Exit status: 0 all scenes pass, 1 one does not, 2 unusable arguments.
"""

import argparse
import os
import pathlib
import random
import signal
import sys
import tempfile
import time

from .comparison import Comparison
from .generator import scene_of
from .stage import LiveStage

ROOT = pathlib.Path(__file__).resolve().parents[2]
SEEDS = 1_000_000
# A scene that differs is played again: on a machine that is busy enough, a thread of a program may take up a transform later
# than another thread the message after it.
ATTEMPTS = 2


def main():
    arguments = parse()
    # So that programs are ended and temporary files removed.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    seed = arguments.seed
    if seed is None:
        seed = int(os.environ.get('LIVE_SEED') or random.SystemRandom().randrange(SEEDS))
    print(f'{arguments.count} scenes from seed {seed}; again: tests/compare_live --seed {seed} --count {arguments.count}',
          flush=True)
    packages = [ROOT / 'tests/conformance/assets', ROOT / 'tests/conformance/robots']
    with tempfile.TemporaryDirectory(prefix='live_comparison_') as folder:
        live = LiveStage(pathlib.Path(folder), arguments.plugin, packages, arguments.camera_stream, arguments.renderers)
        try:
            comparison = Comparison(live, arguments.output, arguments.keep)
            failed = compare_all(comparison, range(seed, seed + arguments.count), arguments.report)
        finally:
            live.end()
    if failed:
        print(f'failed: the scenes of the seeds {", ".join(map(str, failed))}; see {arguments.output}')
        return 1
    print('all scenes agree')
    return 0


def parse():
    target = ROOT / os.environ.get('CARGO_TARGET_DIR', 'target')
    parser = argparse.ArgumentParser(prog='tests/compare_live', description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seed', type=int, help='of the first scene [default: a fresh one, which is printed]')
    parser.add_argument('--count', type=int, default=12, help='how many scenes, each with a seed one higher [default: 12]')
    parser.add_argument('--renderers', nargs='+', choices=['cpu', 'gpu'], default=['cpu'], help='[default: cpu]')
    parser.add_argument('--report', help='appends a line for each picture: seed, camera, renderer, classes,\n'
                        'strict, close, content pixels')
    parser.add_argument('--plugin', required=True, type=pathlib.Path, metavar='PREFIX', help='where the plugin is installed')
    parser.add_argument('--camera-stream', type=pathlib.Path, default=target / 'release/camera_stream', metavar='PROGRAM',
                        help='the built program [default: target/release/camera_stream]')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'test_output/live',
                        help='where scenes that fail are kept [default: test_output/live]')
    parser.add_argument('--keep', action='store_true', help='keeps those that pass, too')
    arguments = parser.parse_args()
    if not arguments.camera_stream.is_file():
        parser.error(f'{arguments.camera_stream} is not built: cargo build --release -p rcs_app --bin camera_stream')
    return arguments


def compare_all(comparison, seeds, report):
    """Compares the scenes of the seeds and returns those that do not pass."""
    failed = []
    for seed in seeds:
        begun = time.monotonic()
        for _ in range(ATTEMPTS):
            results = compare(comparison, seed)
            for result in results:
                print_result(result, time.monotonic() - begun)
            if results and all(result.passes for result in results):
                break
        else:
            failed.append(seed)
        if report:
            append(report, results)
    return failed


def compare(comparison, seed):
    """Plays the scene of a seed; no results if a program ends or stops."""
    try:
        return comparison.compare(scene_of(seed, comparison.live.now + 10.0))
    except (RuntimeError, TimeoutError) as error:
        print(f'seed {seed}: {error}', flush=True)
        comparison.live.end_rviz()
        return []


def print_result(result, secs):
    word = 'ok' if result.passes else 'DIFFERENT'
    print(f'seed {result.seed} {result.camera} {result.renderer}: strict {result.strict:.4f} close {result.close:.4f} of '
          f'{result.content} pixels {word} ({", ".join(result.classes)}; {secs:.1f} s)', flush=True)


def append(report, results):
    with open(report, 'a') as file:
        for result in results:
            fields = (*result[:3], ','.join(result.classes), f'{result.strict:.6f}', f'{result.close:.6f}', result.content)
            file.write('\t'.join(map(str, fields)) + '\n')


if __name__ == '__main__':
    sys.exit(main())
