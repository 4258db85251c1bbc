"""The plot of a report of `./soak`, drawn by gnuplot: panels over time, one above the other."""

import collections
import subprocess

# Beside the panels, as shares of the picture: for their labels.
LEFT, RIGHT, BOTTOM, TOP, GAP = 0.2, 0.98, 0.045, 0.99, 0.02
SIZE_PX = (1100, 1300)

# What a panel shows as one colour: its title (or none), gnuplot's style, and its points: x and y, and where the style takes
# more, the rest of gnuplot's columns.
Series = collections.namedtuple('Series', 'title style points')
# A panel: its label and further settings in gnuplot's language, its series, and its share of the height.
Panel = collections.namedtuple('Panel', 'label settings series height')


def quoted(text):
    """A string of gnuplot's language that stands for this text as it is."""
    return "'" + text.replace("'", "''") + "'"


def data_block(name, points):
    rows = [' '.join('{:.6g}'.format(value) for value in point) for point in points]
    return ['${} << END'.format(name)] + rows + ['END']


def script(panels, marks, end, file):
    """What gnuplot is told. `marks` are the places of red lines through all panels; x runs from 0 to `end`, in minutes."""
    lines = ['set terminal svg noenhanced size {},{} font "sans-serif,11" background "white"'.format(*SIZE_PX),
             'set output ' + quoted(file), 'set multiplot', 'set grid', 'set key top left Left reverse opaque',
             'set lmargin at screen {}'.format(LEFT), 'set rmargin at screen {}'.format(RIGHT),
             'set xrange [0:{:.6g}]'.format(end)]
    for mark in marks:
        lines.append('set arrow from {0:.6g}, graph 0 to {0:.6g}, graph 1 nohead lc rgb "red"'.format(mark))
    share = (TOP - BOTTOM - GAP * (len(panels) - 1)) / sum(panel.height for panel in panels)
    top = TOP
    for index, panel in enumerate(panels):
        bottom, is_last = top - share * panel.height, index == len(panels) - 1
        lines += ['set tmargin at screen {:.6f}'.format(top), 'set bmargin at screen {:.6f}'.format(bottom)]
        top = bottom - GAP
        lines += ['unset logscale y', 'set autoscale y', 'set ytics auto', 'set format x ' + quoted('%g' if is_last else ''),
                  'set xlabel ' + quoted('minutes' if is_last else ''), 'set ylabel ' + quoted(panel.label)] + panel.settings
        shown = [series for series in panel.series if series.points]
        plots = []
        for number, series in enumerate(shown):
            name = 'data{}_{}'.format(index, number)
            lines += data_block(name, series.points)
            title = 'title ' + quoted(series.title) if series.title else 'notitle'
            plots.append('${} with {} {}'.format(name, series.style, title))
        # gnuplot refuses a plot of nothing; a line above the panel does not show.
        lines.append('plot ' + ', '.join(plots) if plots else 'set yrange [1:2]\nplot 9 notitle')
    return '\n'.join(lines + ['unset multiplot', ''])


def draw(panels, marks, end, file):
    """Draws panels into an SVG file."""
    subprocess.run(['gnuplot', '-'], input=script(panels, marks, end, file), universal_newlines=True, check=True)
