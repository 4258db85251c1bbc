"""Tables in Markdown, and the machine in words: for the reports of `./bench` and `./soak`."""

import glob
import os
import re


def found(pattern, files):
    """What a pattern captures in the first file that has it."""
    for name in sorted(glob.glob(files)):
        with open(name) as file:
            match = re.search(pattern, file.read(), re.MULTILINE)
        if match:
            return match.group(1).strip()
    return None


def processor():
    """The processor, in words."""
    model = found(r'^model name\s*: (.*)', '/proc/cpuinfo') or 'of an unknown model'
    return '{} cores ({})'.format(os.cpu_count(), model)


def table(heads, row, rows):
    """A Markdown table; `row` formats the figures of one row."""
    lines = ['| ' + ' | '.join(heads) + ' |', '|---' * len(heads) + '|']
    # There is no figure for pictures that never arrived.
    return '\n'.join(lines + ['| ' + ' | '.join(row).format(**figures).replace('nan', '–') + ' |' for figures in rows])
