"""The processes of `./soak`. All of them end with it, however it ends."""

import concurrent.futures
import ctypes
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time

from golden.scenes.processes import free_port

from . import ros
from .scene import URDF

PR_SET_PDEATHSIG = 1
ANSWER_S = 60.0
# Linux kills a process when the thread that started it ends, so one thread that lives as long as the program starts all.
STARTER = concurrent.futures.ThreadPoolExecutor(1)
LIBC = ctypes.CDLL(None)


class Failure(Exception):
    """A program that `./soak` needs failed."""


def module(name, *arguments):
    """The command that runs one of the tests' Python modules."""
    return [sys.executable, '-B', '-m', name, *arguments]


def start(command, **options):
    """Starts a process that is killed when this one ends."""
    def die_with_parent():
        LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    return STARTER.submit(
        lambda: subprocess.Popen(command, start_new_session=True, preexec_fn=die_with_parent, **options)).result()


def end(process, name=signal.SIGINT, patience_s=5.0):
    """Ends a process, stopped or not; its exit status."""
    for number in (signal.SIGCONT, name):
        process.send_signal(number)
    try:
        return process.wait(patience_s)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def wait_until(condition, patience_s, period_s=0.05):
    """Whether a condition comes true in time."""
    until = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > until:
            return False
        time.sleep(period_s)
    return True


class Master:
    """A ROS master on a free port; a restarted one uses the same port."""

    def __init__(self, folder):
        self.port = free_port()
        self.uri = 'http://127.0.0.1:{}'.format(self.port)
        os.environ.update(ROS_MASTER_URI=self.uri, ROS_IP='127.0.0.1', ROS_LOG_DIR=os.path.join(folder, 'log'),
                          ROS_HOME=folder, PYTHONUNBUFFERED='1')
        os.environ.pop('ROS_HOSTNAME', None)
        self.log = os.path.join(folder, 'master.log')
        self.start()

    def start(self):
        with open(self.log, 'ab') as log:
            self.process = start(['rosmaster', '--core', '-p', str(self.port)], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        if not wait_until(self.is_online, 30):
            raise Failure('the ROS master did not start; its log: ' + self.log)
        ros.master_call(self.uri, 'setParam', '/robot_description', URDF)

    def is_online(self):
        try:
            return ros.master_call(self.uri, 'getPid') > 0
        except (OSError, ros.xmlrpc.client.Error, ros.http.client.HTTPException):
            return False

    def knows(self, node, service=None):
        """Whether a node and a service are registered."""
        try:
            ros.master_call(self.uri, 'lookupNode', node)
            return service is None or bool(ros.master_call(self.uri, 'lookupService', service))
        except OSError:
            return False

    def kill(self):
        self.process.kill()
        self.process.wait()


class Node:
    """The node under test."""

    def __init__(self, program, renderer, config, log):
        self.log, self.config = log, config
        self.process = start([program, '-d', config, '--renderer', renderer], stdin=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL, stderr=open(log, 'ab'))
        self.name, self.pid = '/camera_stream', self.process.pid

    def wait(self, master):
        """Waits until it draws; finds its address, which stays the same."""
        def is_ready():
            with open(self.log, errors='replace') as log:
                return 'drawing ' in log.read() or self.process.poll() is not None
        if not wait_until(is_ready, 30) or self.process.poll() is not None:
            raise Failure('the node did not start; its log: ' + self.log)
        if not wait_until(lambda: master.knows(self.name), 10):
            raise Failure('the node does not register at the master')
        self.uri = ros.master_call(master.uri, 'lookupNode', self.name)

    def status(self):
        """What `/proc` says of it: memory in MB, threads, descriptors, CPU time in s; None when it has ended."""
        try:
            with open('/proc/{}/status'.format(self.pid)) as status:
                values = dict(line.split(':', 1) for line in status.read().splitlines())
            with open('/proc/{}/stat'.format(self.pid)) as stat:
                times = stat.read().rsplit(')', 1)[1].split()
            return {
                'memory_mb': int(values['VmRSS'].split()[0]) / 1024,
                'threads': int(values['Threads']),
                'descriptors': len(os.listdir('/proc/{}/fd'.format(self.pid))),
                'cpu_s': (int(times[11]) + int(times[12])) / os.sysconf('SC_CLK_TCK'),
            }
        except (OSError, KeyError, ValueError):
            return None


class Helper:
    """One of the scripts, which answers commands."""

    def __init__(self, name, arguments, folder):
        self.name = name
        self.command = module('soak.publisher', *arguments)
        self.log = os.path.join(folder, name + '.log')
        self.lock = threading.Lock()
        self.start()

    def start(self):
        with open(self.log, 'ab') as log:
            self.process = start(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
        self.answers = queue.Queue()
        threading.Thread(target=self.read, args=(self.process.stdout, self.answers), daemon=True).start()

    @staticmethod
    def read(lines, answers):
        for line in lines:
            answers.put(line)
        answers.put(None)

    def answer(self, what):
        try:
            line = self.answers.get(timeout=ANSWER_S)
        except queue.Empty:
            line = None
        if line is None:
            raise Failure('{} does not answer {}; its log: {}'.format(self.name, what, self.log))
        answer = json.loads(line)
        if isinstance(answer, dict) and 'error' in answer:
            raise Failure('{} {}: {}'.format(self.name, what, answer['error']))
        return answer

    def wait(self):
        with self.lock:
            self.answer('its start')

    def ask(self, *command):
        """Has it run one of its methods; what that returns."""
        with self.lock:
            try:
                self.process.stdin.write(json.dumps(command).encode() + b'\n')
                self.process.stdin.flush()
            except OSError as error:
                raise Failure('{} has ended: {}; its log: {}'.format(self.name, error, self.log))
            return self.answer(command[0])

    def restart(self, pause_s):
        """Kills it and starts it again after a while."""
        with self.lock:
            self.process.kill()
            self.process.wait()
            self.process.stdin.close()
            time.sleep(pause_s)
            self.start()
            self.answer('its start')
