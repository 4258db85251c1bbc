"""The report of `./soak`: figures, trends, findings, and a plot over time."""

import bisect
import collections
import os
import statistics
import time

from bench_page import machine, table
from soak_plot import Panel, Series, draw, quoted
from soak_scene import CAMERAS

# Measurements of the process: heading, unit, and the limit of growth from the first quarter's median to the last's:
# an amount, or a share of the first quarter's if that is more.
TRENDS = {
    'memory_mb': ('memory', 'MB', 24, 0.15),
    'threads': ('threads', '', 4, 0.05),
    'descriptors': ('descriptors', '', 6, 0.05),
}
# The beginning of a run does not count for trends: memory and caches fill.
WARM_UP_SHARE, WARM_UP_S = 0.1, 30.0
# In shorter runs memory is still filling: each kind of fault needs some at its worst, and comes by about twice a minute.
SHORTEST_TREND_S = 1500.0
PLOTTED_EVERY_S = 5.0


def slope_an_hour(samples, key):
    """The slope of a figure by least squares."""
    times, values = [sample['at'] / 3600 for sample in samples], [sample[key] for sample in samples]
    middle, mean = statistics.mean(times), statistics.mean(values)
    spread = sum((at - middle) ** 2 for at in times)
    return sum((at - middle) * (value - mean) for at, value in zip(times, values)) / spread if spread else 0.0


def trends(samples, begin, findings):
    """Rows of the table of trends; what grows becomes a finding."""
    rows = []
    length = samples[-1]['at'] - begin
    warm = [sample for sample in samples if sample['at'] - begin >= min(WARM_UP_S, length / 4) + WARM_UP_SHARE * length]
    quarter = max(1, len(warm) // 4)
    for key, (name, unit, amount, share) in TRENDS.items():
        first, last = (statistics.median(sample[key] for sample in part) for part in (warm[:quarter], warm[-quarter:]))
        values = [sample[key] for sample in samples]
        allowed = max(amount, share * first)
        grows = length >= SHORTEST_TREND_S and last - first > allowed
        if grows:
            findings.add('{} grows: {:.0f} {} in the first quarter after the start, {:.0f} in the last'.format(
                name, first, unit, last))
        rows.append({'name': '{} {}'.format(name, unit).strip(), 'start': values[0], 'median': statistics.median(values),
                     'end': values[-1], 'max': max(values), 'first': first, 'last': last, 'allowed': allowed,
                     'slope': slope_an_hour(warm, key)})
    return rows


def percentile(values, share):
    """Nearest rank."""
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


def gap_rows(viewers):
    phases = collections.defaultdict(list)
    for _, camera, length, phase in viewers.gaps:
        phases[phase, camera].append(1000 * length)
    rows = []
    for (phase, camera), lengths in sorted(phases.items()):
        rows.append({'phase': phase, 'camera': camera, 'count': len(lengths), 'median': statistics.median(lengths),
                     'p99': percentile(lengths, 0.99), 'longest': max(lengths)})
    return rows


def fault_rows(run):
    rows = []
    gaps = sorted(run.watch.viewers.gaps)
    ends = [gap[0] for gap in gaps]
    longest_gap = max((gap[2] for gap in gaps), default=0.0)
    for kind in sorted({record['kind'] for record in run.records}):
        records = [record for record in run.records if record['kind'] == kind]
        longest = 0.0
        for record in records:
            end = record.get('end') or time.monotonic()
            # Among those that end early enough.
            near = gaps[bisect.bisect(ends, record['begin']):bisect.bisect(ends, end + longest_gap)]
            longest = max([longest] + [length for at, _, length, _ in near if at - length < end])
        rows.append({'kind': kind, 'count': len(records), 'survived': sum(record['survived'] for record in records),
                     'longest': 1000 * longest})
    return rows


def plot(run, file):
    """Memory, threads and descriptors, CPU time and gaps over time; faults as bars."""
    samples, begin, now = run.watch.samples, run.begin, time.monotonic()

    def over_time(value):
        return [((sample['at'] - begin) / 60, value(sample)) for sample in samples]

    load = [((b['at'] - begin) / 60, 100 * (b['cpu_s'] - a['cpu_s']) / (b['at'] - a['at']))
            for a, b in zip(samples, samples[1:]) if b['at'] > a['at']]
    gaps = []
    for camera in CAMERAS:
        longest = collections.defaultdict(float)
        for at, name, length, _ in run.watch.viewers.gaps:
            if name == camera:
                slot = int((at - begin) / PLOTTED_EVERY_S)
                longest[slot] = max(longest[slot], 1000 * length)
        points = [(slot * PLOTTED_EVERY_S / 60, length) for slot, length in sorted(longest.items())]
        gaps.append(Series(camera, 'points pointtype 7 pointsize 0.3', points))
    kinds = sorted({record['kind'] for record in run.records}, reverse=True)
    bars = {True: [], False: []}
    for record in run.records:
        start, row = (record['begin'] - begin) / 60, kinds.index(record['kind'])
        end = max(((record.get('end') or now) - begin) / 60, start + 0.01)
        bars[bool(record['survived'])].append((start, row, start, end, row - 0.4, row + 0.4))
    names = ', '.join('{} {}'.format(quoted(kind), row) for row, kind in enumerate(kinds))
    rows = ['set ytics ({}) font ",8"'.format(names), 'set yrange [-1:{}]'.format(len(kinds))] if kinds else []
    bar = 'boxxyerror fillstyle solid noborder lc rgb '
    panels = [
        Panel('memory (MB)', [], [Series('', 'lines', over_time(lambda sample: sample['memory_mb']))], 2),
        Panel('', [], [Series(key, 'lines', over_time(lambda sample, key=key: sample[key]))
                       for key in ('threads', 'descriptors')], 2),
        Panel('CPU (% of a core)', [], [Series('', 'lines', load)], 2),
        Panel('longest gap (ms)', ['set logscale y'], gaps, 2),
        Panel('', rows, [Series('', bar + '"steelblue"', bars[True]), Series('', bar + '"red"', bars[False])], 4),
    ]
    draw(panels, [at / 60 for at, _ in run.watch.findings.all], max((now - begin) / 60, 0.01), file)


def write(given, run, checks, is_interrupted):
    """Writes the report; whether everything held."""
    watch, viewers = run.watch, run.watch.viewers
    length = time.monotonic() - run.begin
    if checks.passed == 0:
        watch.findings.add('no picture check passed')
    process = trends(watch.samples, run.begin, watch.findings)
    cpu = (watch.samples[-1]['cpu_s'] - watch.samples[0]['cpu_s']) / max(1e-9, watch.samples[-1]['at'] - watch.samples[0]['at'])
    latencies = [latency for _, latency in viewers.latencies_ms] or [float('nan')]
    stalls = [late for _, late in watch.stalls]
    findings = watch.findings.all
    survived = sum(record['survived'] for record in run.records)
    outcome = 'everything held' if not findings else '{} finding{}'.format(len(findings), 's' * (len(findings) > 1))
    only = ' --only ' + ','.join(given.only) if given.only else ''
    lines = [
        '# Soak', '',
        '`./soak --hours {:g} --seed {}{}` on {}{}: **{}**.'.format(
            given.hours, given.seed, only, machine(), ', interrupted' if is_interrupted else '', outcome), '',
        table(['', ''], ['{name}', '{value}'], [
            {'name': 'time', 'value': '{:.2f} hours'.format(length / 3600)},
            {'name': 'pictures received', 'value': ', '.join('{} {:,}'.format(name, viewers.count[name]) for name in CAMERAS)},
            {'name': 'faults', 'value': '{} of {} survived, {} kinds'.format(
                survived, len(run.records), len({record['kind'] for record in run.records}))},
            {'name': 'picture checks', 'value': '{} equal, {} different, of {} cameras each'.format(
                checks.passed, checks.failed, len(CAMERAS))},
            {'name': 'connections lost by viewers that behave well', 'value': viewers.lost},
            {'name': 'latency from publishing a small cloud to the arrival of its picture, faults included',
             'value': '{:.0f} ms median, {:.0f} ms p99, {:.0f} ms longest'.format(
                 statistics.median(latencies), percentile(latencies, 0.99), max(latencies))},
            {'name': 'CPU time of the node', 'value': '{:.0f} % of a core'.format(100 * cpu)},
            {'name': 'most log lines within 10 s', 'value': watch.most_log_lines},
            {'name': 'log lines', 'value': ', '.join('{} {}'.format(count, level or 'other')
                                                     for level, count in watch.levels.most_common())},
            {'name': 'stalls of the machine itself over 100 ms', 'value': '{}, the longest {:.0f} ms'.format(
                len(stalls), 1000 * max(stalls, default=0))},
        ]), '',
        '## Findings', '',
        '\n'.join('- {:.1f} s: {}'.format(at, text) for at, text in findings) or 'None.', '',
        '## The process', '',
        table(['', 'start', 'median', 'end', 'most', 'median of the first quarter*', 'of the last*', 'may grow by',
               'slope per hour*'],
              ['{name}', '{start:.0f}', '{median:.0f}', '{end:.0f}', '{max:.0f}', '{first:.1f}', '{last:.1f}', '{allowed:.0f}',
               '{slope:+.1f}'], process), '',
        '\\* after the warm-up.', '',
        '![Memory, threads, descriptors, CPU time, gaps and faults over time](soak.svg)', '',
        '## Times without a picture', '',
        '"Paused" are faults that stop pictures by their nature.', '',
        table(['phase', 'camera', 'pictures', 'median ms', 'p99 ms', 'longest ms'],
              ['{phase}', '{camera}', '{count}', '{median:.0f}', '{p99:.0f}', '{longest:.0f}'], gap_rows(viewers)), '',
        '## Faults', '',
        'The longest gap is that of any camera while the fault lasted, often together with others.', '',
        table(['fault', 'times', 'survived', 'longest gap ms'], ['{kind}', '{count}', '{survived}', '{longest:.0f}'],
              fault_rows(run)), '',
    ]
    if watch.texts:
        lines += ['## Errors in the log', '']
        lines += ['- {} times: {}'.format(count, text) for text, count in watch.texts.most_common(15)]
    with open(os.path.join(given.report, 'report.md'), 'w', encoding='utf-8') as out:
        out.write('\n'.join(lines) + '\n')
    with open(os.path.join(given.report, 'faults.log'), 'w', encoding='utf-8') as out:
        for record in run.records:
            out.write('{:.1f} {:.1f} {} {}\n'.format(
                record['begin'] - run.begin, (record.get('end') or record['begin']) - run.begin, record['kind'], record['text']))
    # The whole log of a long run would be large.
    with open(run.node.log, 'rb') as log, open(os.path.join(given.report, 'node.log'), 'wb') as out:
        log.seek(max(0, os.path.getsize(run.node.log) - (8 << 20)))
        out.write(log.read())
    plot(run, os.path.join(given.report, 'soak.svg'))
    print('\n'.join(lines[2:9] if not findings else lines[2:]).split('## The process')[0])
    print('report: {}'.format(os.path.join(given.report, 'report.md')), flush=True)
    return not findings
