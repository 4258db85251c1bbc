"""The arguments of `./soak`. Needs only Python's standard library, so that `./soak` can check them before it installs
anything: run as a program, it exits with status 2 and a line on standard error when they are unusable.
"""

import argparse
import os
import random
import re

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


def kinds():
    """The names of the faults, which are functions of soak_faults.py."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'soak_faults.py'), encoding='utf-8') as faults:
        return re.findall(r'^@fault\(.*\)\ndef (\w+)', faults.read(), re.MULTILINE)


def fault_names(text):
    """A comma-separated list of faults."""
    known, names = kinds(), text.split(',')
    unknown = [name for name in names if name not in known]
    if unknown:
        raise argparse.ArgumentTypeError('there is no fault {}; there are {}'.format(', '.join(unknown), ', '.join(known)))
    return names


def report_folder(text):
    """A folder that can be replaced: a new or empty one, or that of an earlier report."""
    folder = os.path.abspath(text)
    if os.path.exists(folder) and (not os.path.isdir(folder) or os.listdir(folder)) and not os.path.isfile(
            os.path.join(folder, 'report.md')):
        raise argparse.ArgumentTypeError('{} exists and is no report of an earlier run'.format(folder))
    return folder


def parse(description=None):
    """What was given, with all defaults filled in."""
    parser = argparse.ArgumentParser(
        prog='soak', description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument('--hours', type=positive, required=True, help='how long; 0.05 are three minutes')
    parser.add_argument('--seed', type=int, help='of all random choices; without it one is chosen and printed')
    parser.add_argument('--programs', required=True, metavar='DIR', help='the folder that camera_stream is in')
    parser.add_argument('--report', type=report_folder, default='soak_report', metavar='DIR', help='where the report is written')
    parser.add_argument('--only', type=fault_names, default=[], metavar='FAULT,…', help='only faults of these kinds')
    parser.add_argument('--renderer', choices=['cpu', 'gpu'], default='cpu')
    parser.add_argument('--gap-limit', type=positive, default=1.5, metavar='SECS',
                        help='the longest time without a picture that is no finding (default 1.5), apart from faults that '
                             'stop pictures by their nature')
    given = parser.parse_args()
    given.programs = os.path.abspath(given.programs)
    if given.seed is None:
        given.seed = random.SystemRandom().randrange(10 ** 6)
    return given


if __name__ == '__main__':
    parse()
