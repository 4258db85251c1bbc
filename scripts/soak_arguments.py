"""The arguments of `./soak`. Needs only Python's standard library, so that `./soak` can check them before it installs
anything: run as a program, it exits with status 2 and a line on standard error when they are unusable.
"""

import argparse
import os
import random

FAULTS_EVERY_S = 1.3
CHECKPOINT_EVERY_S = 22.0


def positive(text):
    """A positive, finite number."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError('{} is not a positive number'.format(text))
    return value


def parse(description=None, kinds=()):
    """What was given, with all defaults filled in. `kinds` are the names of the faults; without any, they are not checked."""
    parser = argparse.ArgumentParser(
        prog='soak', description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument('--hours', type=positive, required=True, help='how long; 0.05 are three minutes')
    parser.add_argument('--seed', type=int, help='of all random choices; without it one is chosen and printed')
    parser.add_argument('--programs', required=True, metavar='DIR', help='the folder that camera_stream is in')
    parser.add_argument('--report', default='soak_report', metavar='DIR', help='where the report is written')
    parser.add_argument('--only', metavar='FAULT,…', help='only faults of these kinds')
    parser.add_argument('--renderer', choices=['cpu', 'gpu'], default='cpu')
    parser.add_argument('--gap-limit', type=positive, default=1.5, metavar='SECS',
                        help='the longest time without a picture that is no finding (default 1.5), apart from faults that '
                             'stop pictures by their nature')
    given = parser.parse_args()
    given.programs, given.report = os.path.abspath(given.programs), os.path.abspath(given.report)
    given.only = given.only.split(',') if given.only else []
    unknown = [kind for kind in given.only if kinds and kind not in kinds]
    if unknown:
        parser.error('there is no fault {}; there are {}'.format(', '.join(unknown), ', '.join(kinds)))
    if given.seed is None:
        given.seed = random.SystemRandom().randrange(10 ** 6)
    return given


if __name__ == '__main__':
    parse()
