"""Everything at once on a live ROS master, with faults at random, and the node's pictures compared with the offline renderer's.

`./soak` runs it after building; `--programs` is the folder of camera_stream. It starts its own ROS master. The parts:

    scene      the config and the messages of all displays     faults  the faults, and their plan
    publisher  the nodes that publish them                     check   the picture checks
    viewer     the viewers                                     watch   measurements and findings
    processes  starting and ending all processes               report  the report
"""

import contextlib
import os
import random
import shutil
import signal
import sys
import tempfile
import threading
import time

from . import arguments, config, faults, report, ros, scene
from .processes import Failure, Helper, Master, Node, end, wait_until
from .watch import Watch

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Time before the first fault, in which everything is drawn once.
CALM_S = 5.0
# Limit for faults to end before an image check.
FAULTS_END_S = 200.0


class Run:
    """One run: the processes, the faults, the checks."""

    def __init__(self, given, folder, stack):
        self.given, self.folder = given, folder
        self.program = os.path.join(given.programs, 'camera_stream')
        self.config_file = os.path.join(folder, 'soak.rviz')
        config.save(self.config_file, scene.config())
        self.stop = threading.Event()
        self.locks = {name: threading.Lock() for name in
                      ('master', 'node', 'config', 'lenses', 'vandal', scene.SENSORS, scene.SCENE)}
        self.services, self.records, self.threads, self.damaged = {}, [], [], set()
        self.master = Master(folder)
        stack.callback(lambda: end(self.master.process))
        self.node = Node(self.program, given.renderer, self.config_file, os.path.join(folder, 'node.log'))
        stack.callback(self.end_node)
        self.node.wait(self.master)
        self.begin = time.monotonic()
        self.watch = Watch(self.node, given.gap_limit, self.begin)
        stack.callback(self.watch.end)
        self.helpers = {}
        for group in (scene.SCENE, scene.SENSORS, 'vandal'):
            self.helpers[group] = Helper(group, [group, str(given.seed)], folder)
            stack.callback(lambda group=group: end(self.helpers[group].process, signal.SIGTERM))
        for helper in self.helpers.values():
            helper.wait()
        self.await_registration()
        self.watch.start(folder)
        stack.callback(lambda: end(self.watch.viewers.process, signal.SIGTERM))
        stack.callback(self.watch.end)

    def end_node(self):
        if self.node.process.poll() is None and end(self.node.process) != 0:
            self.watch.findings.add('the node ended with status {} after SIGINT'.format(self.node.process.poll()))

    # --- what faults use

    def save_config(self, text, rng):
        """Saves a config; None: the usual one."""
        config.save(self.config_file, text or scene.config(), rng)

    def await_registration(self):
        """Waits until a new master knows the node's services and all publishers."""
        nodes = ['/soak_' + group for group in self.helpers]
        if not wait_until(lambda: self.master.knows(self.node.name, '/camera_stream/reload_config')
                          and all(self.master.knows(node) for node in nodes), 15):
            raise Failure('the new master does not know all nodes after 15 s')

    def call(self, service, kind, request):
        """Calls a service of the node."""
        if service not in self.services:
            self.services[service] = ros.master_call(self.master.uri, 'lookupService', service)
        return ros.call_service(self.services[service], service, kind, request)

    # --- the course of events

    def do(self, kind, seed):
        """Runs one fault to its end, on a thread of its own."""
        function, needs = faults.FAULTS[kind]
        with contextlib.ExitStack() as stack:
            for name in sorted(needs):
                stack.enter_context(self.locks[name])
            if self.stop.is_set():
                return
            with self.watch.faults.during(kind) as span:
                parts = function(self, random.Random(seed))
                text = next(parts)
                print('{:8.1f} s  {:18} {}'.format(span.begin - self.begin, kind, text), flush=True)
                record = {'kind': kind, 'text': text, 'begin': span.begin, 'survived': False}
                self.records.append(record)
                try:
                    for _ in parts:
                        pass
                    record['survived'] = self.node.process.poll() is None
                except (Failure, OSError) as error:
                    self.watch.findings.add('{} ({}): {}: {}'.format(kind, text, type(error).__name__, error))
            record['end'] = span.end

    def start_fault(self, kind, seed):
        thread = threading.Thread(target=self.do, args=(kind, seed), daemon=True)
        self.threads.append(thread)
        thread.start()

    def finish_faults(self):
        until = time.monotonic() + FAULTS_END_S
        for thread in self.threads:
            thread.join(max(0.0, until - time.monotonic()))
            if thread.is_alive():
                self.watch.findings.add('a fault does not end')
        self.threads = []

    def run(self, checks):
        """Faults and picture checks until the time is over; the last thing is a check."""
        end_at = self.begin + 3600 * self.given.hours
        plan = faults.plan(self.given.seed, self.given.only, arguments.FAULTS_EVERY_S)
        seeds = random.Random(self.given.seed + 1)
        self.pause(CALM_S)
        self.check(checks, seeds.randrange(1 << 30))
        while not self.stop.is_set() and time.monotonic() < end_at:
            check_at = min(end_at, time.monotonic() + arguments.CHECKPOINT_EVERY_S)
            while not self.stop.is_set():
                wait_s, kind, seed = next(plan)
                if time.monotonic() + wait_s > check_at:
                    break
                self.pause(wait_s)
                self.start_fault(kind, seed)
            self.pause(max(0.0, check_at - time.monotonic()))
            self.finish_faults()
            if not self.stop.is_set():
                self.check(checks, seeds.randrange(1 << 30))

    def pause(self, seconds):
        """Waits, unless the end is requested or the node has ended."""
        self.stop.wait(seconds)
        if self.node.process.poll() is not None:
            raise Failure('the node has ended')

    def check(self, checks, seed):
        text = config.reset(self.damaged)
        self.damaged.clear()
        if text:
            # Until the good messages that the displays begin with have come.
            self.save_config(text, None)
            time.sleep(1.5)
        self.save_config(None, None)
        # Until the file is read again and what was just broken has recovered.
        self.pause(2.0)
        self.watch.is_checking = True
        try:
            is_equal = checks.check(seed)
        finally:
            self.watch.is_checking = False
        status = self.node.status() or dict.fromkeys(('memory_mb', 'threads', 'descriptors'), 0)
        print('{:8.1f} s  picture check {}: {}; {:.0f} MB, {} threads, {} descriptors'.format(
            time.monotonic() - self.begin, checks.passed + checks.failed, 'equal' if is_equal else 'DIFFERENT',
            status['memory_mb'], status['threads'], status['descriptors']), flush=True)


def main():
    given = arguments.parse()
    # The scene's meshes lie there.
    packages = [os.path.join(ROOT, 'tests', 'golden', 'assets'), os.environ.get('ROS_PACKAGE_PATH', '/usr/share')]
    os.environ['ROS_PACKAGE_PATH'] = os.pathsep.join(packages)
    from .check import Checks
    folder = tempfile.mkdtemp(prefix='rviz_camera_stream_soak.')
    shutil.rmtree(given.report, ignore_errors=True)
    os.makedirs(given.report)
    print('seed {}, {:g} hours; report: {}'.format(given.seed, given.hours, given.report), flush=True)
    run, checks, is_interrupted = None, None, []
    try:
        with contextlib.ExitStack() as stack:
            run = Run(given, folder, stack)

            def interrupt(*_):
                is_interrupted.append(True)
                run.stop.set()
            for name in (signal.SIGINT, signal.SIGTERM):
                signal.signal(name, interrupt)
            checks = Checks(run, folder)
            try:
                run.run(checks)
            except Failure as error:
                run.watch.findings.add(str(error))
            finally:
                run.stop.set()
                run.finish_faults()
    except Failure as error:
        sys.exit('soak: {}'.format(error))
    is_good = report.write(given, run, checks, bool(is_interrupted))
    shutil.rmtree(folder)
    sys.exit(130 if is_interrupted else 0 if is_good else 1)


if __name__ == '__main__':
    main()
