"""Watches the node while `./soak` runs: the images of its viewers, its process, its log. Errors become findings."""

import collections
import contextlib
import os
import re
import subprocess
import threading
import time

from .processes import Failure, module, start, wait_until
from .scene import BEACON_CAMERA, CAMERAS

# Most log lines in a window of this length: the node limits each place in its program to 50 a second.
LOG_WINDOW_S, LOG_LINES = 10, 600
# Limit of the time between a fault that stops images and the next image.
GRACE_S = 1.0
EARLIEST_STALL_S = 0.1

Picture = collections.namedtuple('Picture', 'topic at width height crc')


class Findings:
    """Errors, in the order in which they were found."""

    def __init__(self, begin):
        self.begin, self.all, self.lock = begin, [], threading.Lock()

    def add(self, text):
        with self.lock:
            self.all.append((time.monotonic() - self.begin, text))
        print('FINDING at {:.1f} s: {}'.format(time.monotonic() - self.begin, text), flush=True)


class Span:
    """A time with a beginning and, later, an end."""

    def __init__(self, kind, cameras=()):
        self.kind, self.cameras, self.begin, self.end = kind, cameras, time.monotonic(), None

    def overlap(self, begin, end, grace_s=0.0):
        """How much of a time lies within it."""
        own_end = end if self.end is None else self.end + grace_s
        return max(0.0, min(end, own_end) - max(begin, self.begin))


class Spans:
    """All such times so far."""

    def __init__(self):
        self.all, self.lock = [], threading.Lock()

    @contextlib.contextmanager
    def during(self, kind, cameras=()):
        span = Span(kind, cameras)
        with self.lock:
            self.all.append(span)
        try:
            yield span
        finally:
            span.end = time.monotonic()

    def overlapping(self, begin, end, grace_s=0.0):
        with self.lock:
            # The oldest ones have ended long ago.
            recent = self.all[-200:]
        return [span for span in recent if span.overlap(begin, end, grace_s) > 0]


class Viewers:
    """The viewers that behave well: one for each camera."""

    def __init__(self, watch, node_uri, folder):
        self.watch, self.count, self.lost = watch, collections.Counter(), 0
        self.last, self.stamps, self.equal, self.silent = {}, {}, collections.Counter(), {}
        self.saved = threading.Event()
        self.gaps, self.latencies_ms = [], []
        self.cameras = {'/soak/{}/image'.format(name): name for name in CAMERAS}
        self.log = os.path.join(folder, 'viewer.log')
        with open(self.log, 'ab') as log:
            self.process = start(module('soak.viewer', node_uri, *self.cameras),
                                 stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            fields = line.decode().rstrip('\n').split('\t')
            if fields[0] == 'picture':
                self.see(self.cameras[fields[1]], *fields[2:])
            elif fields[0] == 'lost':
                self.lost += 1
                self.watch.findings.add('{}: a viewer that behaves well lost its connection: {}'.format(fields[1], fields[3]))
            elif fields[0] == 'saved':
                self.saved.set()
        if not self.watch.is_over:
            self.watch.findings.add('the viewer has ended; its log: ' + self.log)

    def see(self, camera, arrival, stamp, width, height, crc, latency_ms):
        picture = Picture(camera, float(arrival), int(width), int(height), crc)
        before = self.last.get(camera)
        self.count[camera] += 1
        if before:
            self.take_gap(camera, before.at, picture.at)
            same = (before.crc, before.width, before.height) == (crc, picture.width, picture.height)
            self.equal[camera] = self.equal[camera] + 1 if same else 1
        secs, nsecs = stamp.split('.')
        stamp = (int(secs), int(nsecs))
        if stamp <= self.stamps.get(camera, (0, 0)):
            self.watch.findings.add('{}: the stamp {} comes after {}'.format(camera, stamp, self.stamps[camera]))
        self.stamps[camera], self.last[camera] = stamp, picture
        if camera == BEACON_CAMERA and latency_ms != '-' and not self.watch.is_checking:
            self.latencies_ms.append((picture.at, int(latency_ms)))

    def take_gap(self, camera, begin, end):
        length = end - begin
        excuses, stalled_s = self.watch.excuses_of(camera, begin, end)
        self.gaps.append((end, camera, length, self.watch.phase_of(begin, end, excuses)))
        if length > self.limit(camera, begin, end, excuses, stalled_s):
            self.watch.findings.add('{}: no picture for {:.2f} s ({})'.format(camera, length, self.watch.around(begin, end)))

    def limit(self, camera, begin, end, excuses, stalled_s):
        rate = CAMERAS[camera][2]
        period = 0.0 if rate < 0 else 1.0 / rate
        return (self.watch.gap_limit_s + period + stalled_s +
                sum(span.overlap(begin, end, GRACE_S) for span in excuses))

    def check_silence(self):
        """Reports a camera whose pictures have stopped, once for each stop."""
        now = time.monotonic()
        for camera in CAMERAS:
            last = self.last.get(camera)
            begin = last.at if last else self.watch.begin
            excuses, stalled_s = self.watch.excuses_of(camera, begin, now)
            limit = self.limit(camera, begin, now, excuses, stalled_s) + 3.0
            if now - begin > limit and self.silent.get(camera) != begin:
                self.silent[camera] = begin
                self.watch.findings.add('{}: no picture since {:.1f} s ({})'.format(
                    camera, now - begin, self.watch.around(begin, now)))

    def save(self, camera, file):
        """Saves a camera's last picture, as its bytes."""
        self.saved.clear()
        self.process.stdin.write('/soak/{}/image {}\n'.format(camera, file).encode())
        self.process.stdin.flush()
        if not self.saved.wait(10):
            raise Failure('the viewer saves nothing; its log: ' + self.log)


class Watch:
    """Collects figures and findings."""

    def __init__(self, node, gap_limit_s, begin):
        self.node, self.gap_limit_s, self.begin = node, gap_limit_s, begin
        self.findings = Findings(begin)
        self.faults, self.excuses, self.stalls = Spans(), Spans(), []
        self.samples, self.is_over, self.is_checking = [], False, False
        self.log_lines, self.levels, self.log_place, self.next_log_finding = collections.deque(), collections.Counter(), 0, 0.0
        self.most_log_lines, self.texts = 0, collections.Counter()
        self.viewers = None

    def start(self, folder):
        self.viewers = Viewers(self, self.node.uri, folder)
        if not wait_until(lambda: len(self.viewers.last) == len(CAMERAS), 30):
            raise Failure('no picture of {}'.format(', '.join(sorted(set(CAMERAS) - set(self.viewers.last)))))
        for task in (self.sample, self.measure_stalls):
            threading.Thread(target=task, daemon=True).start()

    # --- what explains a gap

    def excuses_of(self, camera, begin, end):
        """Faults that stop this camera by their nature, and for how long the machine itself stood still."""
        excuses = [span for span in self.excuses.overlapping(begin, end, GRACE_S) if camera in span.cameras]
        stalled_s = sum(length for at, length in self.stalls[-200:] if at > begin and at - length < end)
        return excuses, stalled_s

    def phase_of(self, begin, end, excuses):
        if excuses:
            return 'paused: ' + excuses[0].kind
        if self.is_checking:
            return 'picture check'
        return 'with faults' if self.faults.overlapping(begin, end, GRACE_S) else 'calm'

    def around(self, begin, end):
        kinds = sorted({span.kind for span in self.faults.overlapping(begin, end, GRACE_S)})
        return 'during ' + ', '.join(kinds) if kinds else 'without any fault'

    # --- the machine, the process, the log

    def measure_stalls(self):
        """How late a thread that sleeps is woken: when the machine is overloaded, that is no fault of the node."""
        while not self.is_over:
            before = time.monotonic()
            time.sleep(0.05)
            late = time.monotonic() - before - 0.05
            if late > EARLIEST_STALL_S:
                self.stalls.append((time.monotonic(), late))

    def sample(self):
        due = time.monotonic()
        while not self.is_over:
            status = self.node.status()
            if self.is_over:
                return
            if status is None or self.node.process.poll() is not None:
                self.findings.add('the node has ended with status {}'.format(self.node.process.poll()))
                return
            self.samples.append(dict(status, at=time.monotonic(), log_lines=self.read_log()))
            self.viewers.check_silence()
            due = max(due + 1.0, time.monotonic())
            time.sleep(due - time.monotonic())

    def read_log(self):
        """Counts the new lines of the node's log."""
        with open(self.node.log, 'rb') as log:
            log.seek(self.log_place)
            lines = log.read().decode('utf-8', 'replace').splitlines()
            self.log_place = log.tell()
        now = time.monotonic()
        for line in lines:
            found = re.match(r'\s*(?:\x1b\[\S*m)?\[\s*(\w+)\] \[[\d.]+\]:? ?(.*)', line)
            level, text = found.groups() if found else ('', line)
            self.levels[level] += 1
            if level in ('ERROR', 'FATAL', ''):
                self.texts[re.sub(r'[\d.]+', '#', text)[:160]] += 1
            if 'panicked' in line:
                self.findings.add('the log: ' + line)
        self.log_lines.append((now, len(lines)))
        while self.log_lines[0][0] < now - LOG_WINDOW_S:
            self.log_lines.popleft()
        in_window = sum(count for _, count in self.log_lines)
        self.most_log_lines = max(self.most_log_lines, in_window)
        if in_window > LOG_LINES and now > self.next_log_finding:
            self.next_log_finding = now + LOG_WINDOW_S
            self.findings.add('{} log lines within {} s ({})'.format(
                in_window, LOG_WINDOW_S, self.around(now - LOG_WINDOW_S, now)))
        return len(lines)

    def end(self):
        self.is_over = True
