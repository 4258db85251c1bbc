"""The arguments of `tests/rviz/compare_live`.

Needs only Python's standard library, so that `tests/rviz/compare_live` can check them before it installs anything: run as a program,
it exits with status 2 and a line on standard error if they are unusable.
"""

import argparse
import os
import pathlib

DESCRIPTION = """Compares random scenes: what rviz with the CameraPub plugin draws, and what camera_stream draws, live on one master.

A scene passes if the share of *close* pixels of each camera's picture is at least 0.98 (tests/golden/score.rs). One that does
not, twice, fails and leaves config, bag, pictures and logs in a folder of its seed; `camera_stream render` draws it again from
there.

LIVE_SEED names the first seed where the command line does not. Exit status: 0 all scenes pass, 1 one does not, 2 unusable
arguments.
"""
ROOT = pathlib.Path(__file__).resolve().parents[3]


def parse():
    """The arguments of the command line, with defaults."""
    target = ROOT / os.environ.get('CARGO_TARGET_DIR', 'target')
    parser = argparse.ArgumentParser(prog='tests/rviz/compare_live', description=DESCRIPTION, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seed', type=int, help='seed of the first scene [default: a random one, which is printed]')
    parser.add_argument('--count', type=int, default=12, help='number of scenes, each with a seed one higher [default: 12]')
    parser.add_argument('--renderers', nargs='+', choices=['cpu', 'gpu'], default=['cpu'], help='[default: cpu]')
    parser.add_argument('--report', metavar='FILE', help='file that gets a line for each image: seed, camera, renderer,\n'
                        'classes, strict, close, content pixels')
    parser.add_argument('--plugin', type=pathlib.Path, help=argparse.SUPPRESS)
    parser.add_argument('--camera-stream', type=pathlib.Path, default=target / 'release/camera_stream', metavar='PROGRAM',
                        help='the built program [default: target/release/camera_stream]')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'test_output/live',
                        help='folder of scenes that fail [default: test_output/live]')
    parser.add_argument('--keep', action='store_true', help='keep scenes that pass, too')
    arguments = parser.parse_args()
    if not arguments.camera_stream.is_file():
        parser.error(f'{arguments.camera_stream} is not built: cargo build --release -p rcs_app --bin camera_stream')
    return arguments


if __name__ == '__main__':
    parse()
