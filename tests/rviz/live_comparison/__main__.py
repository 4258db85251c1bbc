"""Compares random scenes: what rviz with the CameraPub plugin draws, and what camera_stream draws, live on one master."""

import os
import pathlib
import random
import signal
import sys
import tempfile
import time

from .arguments import ROOT, parse
from .comparison import Comparison
from .generator import scene_of
from .stage import LiveStage

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
    print(f'{arguments.count} scenes from seed {seed}; again: tests/rviz/compare_live --seed {seed} --count {arguments.count}',
          flush=True)
    packages = [ROOT / 'tests/golden/assets', ROOT / 'tests/golden/robots']
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
