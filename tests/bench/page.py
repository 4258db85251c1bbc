"""Writes a benchmark's figures as tables and a plot into the pages.

The text between `<!-- bench SECTION begin -->` and `<!-- bench SECTION end -->` is replaced; the rest of a page is written by
hand. A section that was not measured stays as it is; one that no page has is printed.
"""

import os

from .drivers import GPU, RVIZ, RVIZ_GPU, is_hardware
from .tables import processor, table

STYLES = {'Flat Squares': 'Flat Squares 4 mm', 'Points': 'Points 3 px', 'Spheres': 'Spheres 4 mm', 'Boxes': 'Boxes 4 mm'}
LATENCY = '{latency_ms:.1f} / {latency_p95_ms:.1f}{mark}'
MARKERS = ('o', 's', '^', 'v')


def machine(given):
    """The machine, in words."""
    gpu = given.drivers.gpu
    return ', '.join([processor()] + ([gpu] if is_hardware(gpu) else []))


def paragraphs(*parts):
    return '\n\n'.join(part for part in parts if part)


def slow_note(rows, rate):
    if not any(row['mark'] for row in rows):
        return ''
    return '† Each cloud was sent after the picture of the previous one, because most were missed at {}.'.format(rate)


def without_software_gpu(given, result):
    """A section's figures without those of the GPU renderer on a software driver, which nobody should use."""
    return dict(result, rows=[row for row in result['rows'] if is_hardware(given.drivers.gpu) or row['name'] != GPU])


def driver_note(given, rows):
    """How rviz drew, if it is among the rows."""
    names, drivers = [row['name'] for row in rows], given.drivers
    if RVIZ_GPU in names:
        return '{} drew with {}.'.format(RVIZ_GPU, drivers.opengl)
    if RVIZ not in names:
        return ''
    if is_hardware(drivers.gpu):
        return 'rviz drew on the CPU, with {}: its display offered no other OpenGL.'.format(drivers.opengl)
    return 'This machine has no GPU: rviz ran on a software driver.'


def styles(given, result):
    rows = [dict(row, shown=STYLES[row['style']]) for row in result['rows']]
    intro = ('`./bench --only styles` on {}: 1280×800 rgb8, 307,200 points at {:g} clouds/s, {:g} s each. Floor: '
             '{:.1f} ms.').format(machine(given), given.hz, given.seconds, result['floor']['latency_ms'])
    heads = ['program', 'style', 'pictures/s', 'clouds missed', 'latency ms, median / p95', 'CPU ms per picture', 'peak MB',
             'first picture ms']
    row = ['{name}', '{shown}', '{pictures_hz:.1f}', '{missed} of {clouds}', LATENCY, '{cpu_ms:.1f}', '{peak_mb:.0f}',
           '{first_ms:.0f}']
    return paragraphs(intro, table(heads, row, rows), slow_note(rows, '{:g} clouds/s'.format(given.hz)), driver_note(given, rows))


def summary(given, result):
    """The README's table, of two styles and one caveat: the CPU renderer, and rviz if it was measured."""
    rows = [dict(row, shown=STYLES[row['style']]) for row in result['rows']
            if row['name'] in ('camera_stream, cpu', RVIZ, RVIZ_GPU) and row['style'] in ('Flat Squares', 'Points')]
    heads = ['program', '307,200 points as', 'images/s', 'latency ms', 'CPU ms per image', 'peak MB']
    row = ['{name}', '{shown}', '{pictures_hz:.1f}', '{latency_ms:.0f}{mark}', '{cpu_ms:.0f}', '{peak_mb:.0f}']
    caveats = ('Measured by `./bench` on {}: 1280×800, {:g} clouds/s; latency includes {:.0f} ms of the measuring script.'.format(
        machine(given), given.hz, result['floor']['latency_ms']), driver_note(given, rows),
               slow_note(rows, '{:g} clouds/s'.format(given.hz)))
    return paragraphs(table(heads, row, rows), ' '.join(caveat for caveat in caveats if caveat))


def points(given, result):
    floors = result['floors']
    rows = [dict(row, floor_ms=floors[row['points']]['latency_ms']) for row in result['rows']]
    intro = '`./bench --only points` on {}: Flat Squares, 1280×800, {:g} s each.'.format(machine(given), given.sweep_seconds)
    heads = ['program', 'points', 'latency ms, median / p95', 'floor ms', 'CPU ms per cloud', 'peak MB', 'pictures/s at full speed']
    row = ['{name}', '{points:,}', LATENCY, '{floor_ms:.1f}', '{cpu_per_cloud_ms:.1f}{mark}', '{peak_mb:.0f}', '{full_hz:.1f}']
    return paragraphs(intro, table(heads, row, rows), slow_note(rows, 'that rate'), driver_note(given, rows),
                      '![Latency and CPU time over the number of points](../images/performance.svg)')


def sizes(given, result):
    rows = [dict(row, size='{}×{}'.format(*row['size_px'])) for row in result['rows']]
    intro = '`./bench --only sizes` on {}: Flat Squares, 307,200 points at 5 clouds/s, {:g} s each.'.format(
        machine(given), given.sweep_seconds)
    row = ['{name}', '{size}', LATENCY, '{floor_ms:.1f}', '{cpu_per_cloud_ms:.1f}{mark}', '{peak_mb:.0f}']
    heads = ['program', 'picture', 'latency ms, median / p95', 'floor ms', 'CPU ms per cloud', 'peak MB']
    return paragraphs(intro, table(heads, row, rows), slow_note(rows, '5 clouds/s'), driver_note(given, rows))


def cameras(given, result):
    intro = '`./bench --only cameras` on {}: Flat Squares, 307,200 points at 5 clouds/s, 1280×800 each, {:g} s.'.format(
        machine(given), given.sweep_seconds)
    rows = result['rows']
    row = ['{name}', '{cameras}', LATENCY, '{floor_ms:.1f}', '{cpu_per_cloud_ms:.1f}{mark}', '{peak_mb:.0f}']
    heads = ['program', 'cameras', 'latency ms to the last picture, median / p95', 'floor ms', 'CPU ms per cloud',
             'peak MB']
    return paragraphs(intro, table(heads, row, rows), slow_note(rows, '5 clouds/s'), driver_note(given, rows))


def lens(given, result):
    intro = '`./bench --only lens` on {}: Flat Squares, 307,200 points at {:g} clouds/s, 1280×800, {:g} s each.'.format(
        machine(given), given.hz, given.seconds)
    heads = ['program', '`--undistort`', 'pictures/s', 'clouds missed', 'latency ms, median / p95', 'CPU ms per cloud', 'peak MB']
    row = ['{name}', '{lens}', '{pictures_hz:.1f}', '{missed} of {clouds}', LATENCY, '{cpu_per_cloud_ms:.1f}{mark}', '{peak_mb:.0f}']
    return paragraphs(intro, table(heads, row, result['rows']), slow_note(result['rows'], '{:g} clouds/s'.format(given.hz)),
                      driver_note(given, result['rows']))


def compressed(given, result):
    nothing = float('nan')
    rows = [dict({'packed_hz': nothing, 'later_ms': nothing, 'kilobytes': nothing}, **row) for row in result['rows']]
    intro = '`./bench --only compressed` on {}: Flat Squares, 307,200 points at {:g} clouds/s, 1280×800, {:g} s each.'.format(
        machine(given), given.hz, given.seconds)
    heads = ['program', 'compressed', 'raw pictures/s', 'raw latency ms, median / p95', 'CPU ms per picture',
             'compressed pictures/s', 'later by ms', 'kB each']
    row = ['{name}', '{compressed}', '{pictures_hz:.1f}', LATENCY, '{cpu_ms:.1f}', '{packed_hz:.1f}', '{later_ms:.1f}',
           '{kilobytes:.0f}']
    return paragraphs(intro, table(heads, row, rows), slow_note(rows, '{:g} clouds/s'.format(given.hz)), driver_note(given, rows))


def idle(given, result):
    intro = '`./bench --only idle` on {}: Flat Squares, 307,200 points, 1280×800, {:g} s each.'.format(
        machine(given), given.seconds)
    row = ['{name}', '{still_percent:.2f}', '{moving_percent:.1f}', '{stream_percent:.2f}', '{repeated_hz:.1f}', '{repeated_ms:.1f}']
    heads = ['program', 'no subscriber, no clouds: % of a core', 'no subscriber, {:g} latched clouds/s: % of a core'.format(given.hz),
             'no subscriber, {:g} clouds/s of a stream: % of a core'.format(given.hz),
             'subscriber, no clouds: pictures/s', 'CPU ms per picture']
    return paragraphs(intro, table(heads, row, result['rows']), driver_note(given, result['rows']))


def starts(given, result):
    rows = []
    for row in result['rows']:
        for what, key in (('first picture received: running master, 307,200 latched points', 'firsts_ms'),
                          ('`camera_stream render` done: sample scene, 1280×800 to PNG', 'renders_ms')):
            times_ms = row[key]
            rows.append({'name': row['name'], 'what': what, 'median': times_ms[len(times_ms) // 2], 'worst': times_ms[-1],
                         'count': len(times_ms)})
    intro = '`./bench --only starts` on {}: from process start, everything included.'.format(machine(given))
    row = ['{name}', '{what}', '{median:.0f}', '{worst:.0f}', '{count}']
    return paragraphs(intro, table(['program', 'until', 'median ms', 'worst ms', 'runs'], row, rows), driver_note(given, rows))


def light(given, result):
    intro = ('`./bench --only light` on {}: Flat Squares, 307,200 points at {:g} clouds/s, 1280×800, {:g} s each. Floor: {:.1f} / '
             '{:.1f} ms.').format(machine(given), given.hz, given.seconds, result['floor']['latency_ms'],
                                  result['floor']['latency_p95_ms'])
    row = ['{name}', '{pictures_hz:.1f}', '{missed} of {clouds}', LATENCY, '{cpu_ms:.1f}', '{server_ms:.1f}', '{peak_mb:.0f}']
    heads = ['program', 'pictures/s', 'clouds missed', 'latency to light ms, median / p95', 'CPU ms per picture',
             "the X server's CPU ms per picture", 'peak MB']
    return paragraphs(intro, table(heads, row, result['rows']), *map(light_steps, result['rows'][:1]),
                      driver_note(given, result['rows']))


def light_steps(row):
    """Where the time of the node's own window goes, by the node's own medians."""
    steps = row['steps']
    rest_ms = row['latency_ms'] - sum(steps.values())
    named = ', '.join('{} {:.1f}'.format(name, ms) for name, ms in steps.items())
    return 'Of the {latency_ms:.1f} ms of {name}: {named}; {rest:.1f} outside the node.'.format(named=named, rest=rest_ms, **row)


def blackout(given, result):
    intro = ('`./bench --only blackout` on {}: 1280×800 in a window of the node on Xvfb, from the call to a black screen. A '
             'script calls on a persistent connection, the page on a new one.').format(machine(given))
    heads = ['program', 'meanwhile', 'caller', 'median ms', 'worst ms', 'blackouts']
    row = ['{name}', '{load}', '{caller}', '{median_ms:.0f}', '{worst_ms:.0f}', '{count}']
    return paragraphs(intro, table(heads, row, result['rows']), driver_note(given, result['rows']))


def pages(given, result):
    intro = ("`./bench --only pages` on {}: Flat Squares, 307,200 points at {:g} clouds/s, 1280×800, {:g} s each; of twenty pages one "
             'never reads.').format(machine(given), given.hz, given.seconds)
    heads = ['program', 'open pages', 'pictures/s on the topic', 'latency ms, median / p95', 'CPU ms per cloud', 'images/s of a page']
    row = ['{name}', '{pages}', '{new_hz:.1f}', LATENCY, '{cpu_per_cloud_ms:.1f}', '{page_hz:.1f}']
    return paragraphs(intro, table(heads, row, result['rows']), driver_note(given, result['rows']))


def plugin(given, result):
    intro = ('`./bench --only plugin` on {}: rviz with one camera, Flat Squares, 10,000 points at {:g} clouds/s, 1280×800, {:g} s '
             'each.').format(machine(given), given.hz, given.seconds)
    heads = ['camera in rviz', 'subscribers', 'pictures/s', 'latency ms, median / p95', "rviz's frames/s",
             "main thread's ms per frame", '% of a core']
    row = ['{name}', '{watched}', '{pictures_hz:.1f}', LATENCY, '{frames_hz:.1f}', '{frame_ms:.1f}', '{cpu_percent:.0f}']
    return paragraphs(intro, table(heads, row, result['rows']), 'rviz ran on a software driver.')


def blocks(given, results):
    """The text of each measured section; keys are the names in the markers."""
    texts = {section: globals()[section](given, result) for section, result in results.items()}
    if 'styles' in results:
        texts['summary'] = summary(given, results['styles'])
    return texts


def plot(result, file):
    """Latency and CPU time over the number of points, all axes logarithmic."""
    import matplotlib
    matplotlib.use('svg')
    matplotlib.rcParams['svg.hashsalt'] = 'rviz_camera_stream'
    from matplotlib import pyplot
    figure, sides = pyplot.subplots(1, 2, figsize=(10, 4), sharex=True)
    names = sorted({row['name'] for row in result['rows']})
    shown = (('latency_ms', 'latency, median (ms)'), ('cpu_per_cloud_ms', 'CPU per cloud (ms)'))
    for axes, (key, title) in zip(sides, shown):
        for name, marker in zip(names, MARKERS):
            rows = sorted((row for row in result['rows'] if row['name'] == name), key=lambda row: row['points'])
            axes.loglog([row['points'] for row in rows], [row[key] for row in rows], marker + '-', label=name)
        axes.set_xlabel('points')
        axes.set_title(title)
        axes.grid(True, which='both', alpha=0.3)
    points, floors = zip(*sorted(result['floors'].items()))
    sides[0].loglog(points, [floor['latency_ms'] for floor in floors], ':', color='gray', label='floor')
    sides[0].legend()
    figure.tight_layout()
    figure.savefig(file, metadata={'Date': None})


def write(root, given, results):
    """Writes the measured sections into the pages, and prints those that no page has."""
    results = {section: without_software_gpu(given, result) for section, result in results.items()}
    texts = blocks(given, results)
    written = set()
    for page in (os.path.join(root, 'docs', 'explanation', 'performance.md'), os.path.join(root, 'README.md')):
        with open(page, encoding='utf-8') as file:
            before = text = file.read()
        for section, block in texts.items():
            begin, end = ('<!-- bench {} {} -->'.format(section, edge) for edge in ('begin', 'end'))
            if begin in text:
                head, rest = text.split(begin)
                text = '{}{}\n{}\n{}{}'.format(head, begin, block, end, rest.split(end)[1])
                written.add(section)
        if text != before:
            with open(page, 'w', encoding='utf-8') as file:
                file.write(text)
            print('written: ' + page)
    for section in sorted(texts.keys() - written):
        print(texts[section])
    if 'points' in results:
        plot(results['points'], os.path.join(root, 'docs', 'images', 'performance.svg'))
