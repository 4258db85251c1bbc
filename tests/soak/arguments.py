"""The arguments of `./soak`.

Needs only Python's standard library, so that `./soak` can check them before it installs anything: run as a program, it exits
with status 2 and a line on standard error if they are unusable.
"""

import argparse
import os
import random
import re

from bench.arguments import positive

DESCRIPTION = """Runs the camera with every display and several cameras on a live ROS master for hours, while viewers,
publishers, the master, configs, lenses and messages fail at random, and compares its images with those of the offline renderer.
Installs and builds what is missing. The report has a page with figures and findings, the list of faults, the node's log, and
for each image that differs the expected and the actual one, their difference, the config and a bag. Ctrl-C ends the run and
writes the report."""
EXIT_STATUS = 'Exit status: 0 everything held, 1 something did not (see the report), 2 unusable arguments, 130 Ctrl-C.'
FAULTS_EVERY_S = 1.3
CHECKPOINT_EVERY_S = 22.0


def kinds():
    """The names of the faults, which are functions of `faults`."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'faults.py'), encoding='utf-8') as faults:
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


def parse():
    """The arguments of the command line, with defaults."""
    parser = argparse.ArgumentParser(prog='soak', description=DESCRIPTION, epilog=EXIT_STATUS, allow_abbrev=False)
    parser.add_argument('--hours', type=positive, required=True, help='duration; 0.05 are three minutes')
    parser.add_argument('--seed', type=int, help='seed of all random choices [default: a random one, which is printed]')
    parser.add_argument('--programs', default='.', metavar='DIR', help='folder of camera_stream; install and build nothing')
    parser.add_argument('--report', type=report_folder, default='soak_report', metavar='DIR',
                        help='folder of the report, replaced if it has one [default: %(default)s]')
    parser.add_argument('--only', type=fault_names, default=[], metavar='A,B', help='faults of these kinds only')
    parser.add_argument('--renderer', choices=['cpu', 'gpu'], default='cpu', help='[default: %(default)s]')
    parser.add_argument('--gap-limit', type=positive, default=1.5, metavar='SECS',
                        help='longest time without an image that is no finding, apart from faults that stop images by their '
                             'nature [default: %(default)g]')
    given = parser.parse_args()
    given.programs = os.path.abspath(given.programs)
    if given.seed is None:
        given.seed = random.SystemRandom().randrange(10 ** 6)
    return given


if __name__ == '__main__':
    parse()
