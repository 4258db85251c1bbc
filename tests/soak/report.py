"""The report of `./soak`: figures, trends and findings."""

import bisect
import collections
import os
import statistics
import time

from bench.tables import processor, table

from .scene import CAMERAS

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
# Rows of the table over time.
PARTS = 12


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


def row_over_time(run, begin, end):
    """The figures of a part of the run."""
    samples = [sample for sample in run.watch.samples if begin <= sample['at'] < end]
    row = {key: max((sample[key] for sample in samples), default=float('nan')) for key in TRENDS}
    length = samples[-1]['at'] - samples[0]['at'] if samples else 0.0
    cpu_s = samples[-1]['cpu_s'] - samples[0]['cpu_s'] if length else float('nan')
    gaps = [length for at, _, length, _ in run.watch.viewers.gaps if begin <= at < end]
    return dict(row, minutes=(end - run.begin) / 60, cpu=100 * cpu_s / (length or 1.0), gap=1000 * max(gaps, default=float('nan')),
                faults=sum(begin <= record['begin'] < end for record in run.records),
                findings=sum(begin <= at + run.begin < end for at, _ in run.watch.findings.all))


def rows_over_time(run):
    """The run in equal parts, each with the largest of its figures."""
    part = (time.monotonic() - run.begin) / PARTS
    return [row_over_time(run, run.begin + number * part, run.begin + (number + 1) * part) for number in range(PARTS)]


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
            given.hours, given.seed, only, processor(), ', interrupted' if is_interrupted else '', outcome), '',
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
        table(['until minute', 'memory MB', 'threads', 'descriptors', 'CPU %', 'longest gap ms', 'faults', 'findings'],
              ['{minutes:.1f}', '{memory_mb:.0f}', '{threads}', '{descriptors}', '{cpu:.0f}', '{gap:.0f}', '{faults}', '{findings}'],
              rows_over_time(run)), '',
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
    print('\n'.join(lines[2:9] if not findings else lines[2:]).split('## The process')[0])
    print('report: {}'.format(os.path.join(given.report, 'report.md')), flush=True)
    return not findings
