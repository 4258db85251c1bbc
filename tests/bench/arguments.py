"""The arguments of `./bench`.

Needs only Python's standard library, so that `./bench` can check them before it installs anything: run as a program, it exits
with status 2 and a line on standard error if they are unusable.
"""

import argparse

DESCRIPTION = """Measures the running camera from outside, with both renderers, and rviz for comparison where it has a
CameraPub plugin. Writes the tables and the plot of docs/explanation/performance.md and README.md. Installs and builds what is
missing. Takes a quarter of an hour; do not use the machine for anything else meanwhile."""
EXIT_STATUS = 'Exit status: 0 done, 1 something failed, 2 unusable arguments.'
SECTIONS = ['styles', 'points', 'sizes', 'cameras', 'lens', 'compressed', 'idle', 'starts', 'light', 'blackout', 'pages', 'plugin']
RENDERERS = ['cpu', 'gpu', 'auto']
DEPTH_CAMERA_POINTS = 640 * 480


def one_of(known):
    """A parser for a comma-separated list of known words."""
    def parse(text):
        words = text.split(',')
        unknown = [word for word in words if word not in known]
        if unknown:
            raise argparse.ArgumentTypeError('there is no {}; there are {}'.format(', '.join(unknown), ', '.join(known)))
        return words
    return parse


def positive(text):
    """A positive, finite number."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError('{} is not a positive number'.format(text))
    return value


def sizes(text):
    """A comma-separated list of cloud sizes."""
    try:
        counts = [int(part) for part in text.split(',')]
    except ValueError:
        counts = [0]
    if min(counts) < 1:
        raise argparse.ArgumentTypeError('{} is not a list of positive whole numbers'.format(text))
    return counts


def parse():
    """The arguments of the command line, with defaults."""
    parser = argparse.ArgumentParser(prog='bench', description=DESCRIPTION, epilog=EXIT_STATUS, allow_abbrev=False)
    parser.add_argument('--programs', default='.', help=argparse.SUPPRESS)
    parser.add_argument('--only', type=one_of(SECTIONS), default=SECTIONS, metavar='A,B',
                        help='measure only these sections: {}; other tables stay as they are'.format(', '.join(SECTIONS)))
    parser.add_argument('--quick', action='store_true', help='measure two seconds per row; implies --dry')
    parser.add_argument('--seconds', type=positive, default=10.0, metavar='N', help='time per row [default: %(default)g s]')
    parser.add_argument('--hz', type=positive, default=30.0, metavar='N', help='clouds per second for styles [default: %(default)g]')
    parser.add_argument('--renderers', type=one_of(RENDERERS), default=RENDERERS, metavar='A,B',
                        help='[default: cpu,gpu,auto; auto only where there is a GPU]')
    parser.add_argument('--points', type=sizes, metavar='N,N,…', help='cloud sizes for points [default: ten thousand to ten million]',
                        default=[10000, 100000, DEPTH_CAMERA_POINTS, 1000000, 3000000, 10000000])
    parser.add_argument('--dry', action='store_true', help='print the tables and leave the pages as they are')
    parser.add_argument('--list', action='store_true', help='list the programs that would be measured; install and build nothing')
    given = parser.parse_args()
    given.starts = 10
    if given.quick:
        given.dry, given.seconds, given.starts = True, 2.0, 3
    # For sections with many rows, in which no cloud is missed.
    given.sweep_seconds = given.seconds / 2
    return given


if __name__ == '__main__':
    parse()
