"""Programs that a test starts: each leads a process group of its own, writes a log, and ends with the test.

A program that was started here ends when `end` is called, when its `with` block is left, and when the Python process that
started it dies, whatever the reason (the kernel's parent-death signal). Nothing else is ever signalled.
"""

import ctypes
import os
import random
import signal
import socket
import subprocess
import time

PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None, use_errno=True)


def _die_with_parent():
    _libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


class Program:
    """A running program with its log."""

    def __init__(self, command, environment, log, pass_fds=()):
        """Starts `command` with `environment` as its whole environment; both outputs go to the file `log`."""
        self.command = command
        self.log = log
        with open(log, "wb") as output:
            # The parent-death signal must be set in the child, before it becomes the program.
            self.process = subprocess.Popen(
                command, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                start_new_session=True, pass_fds=pass_fds, preexec_fn=_die_with_parent)

    @property
    def pid(self):
        return self.process.pid

    def is_running(self):
        return self.process.poll() is None

    def check(self):
        """Raises RuntimeError with the end of the log if the program has ended."""
        if not self.is_running():
            raise RuntimeError(f"{self.command[0]} ended with status {self.process.returncode}; its log {self.log} ends with:\n"
                               f"{self.last_lines()}")

    def last_lines(self, count=15):
        with open(self.log, errors="replace") as file:
            return "".join(file.readlines()[-count:])

    def end(self, patience_secs=5.0):
        """Asks the program's process group to end, and kills what is left after `patience_secs`."""
        for wanted, secs in ((signal.SIGTERM, patience_secs), (signal.SIGKILL, 10.0)):
            if not self.is_running():
                break
            try:
                os.killpg(self.process.pid, wanted)
            except ProcessLookupError:
                break
            try:
                self.process.wait(secs)
            except subprocess.TimeoutExpired:
                continue
        self.process.poll()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()


def wait_until(condition, timeout_secs, what, programs=(), interval_secs=0.02):
    """Waits until `condition()` is true and returns its value.

    Raises RuntimeError as soon as one of `programs` has ended, and TimeoutError, which names `what`, after `timeout_secs`.
    """
    end = time.monotonic() + timeout_secs
    while True:
        value = condition()
        if value:
            return value
        for program in programs:
            program.check()
        if time.monotonic() > end:
            raise TimeoutError(f"after {timeout_secs:g} s: {what}")
        time.sleep(interval_secs)


def free_port():
    """A port for a master, at random: below those that the kernel gives to clients, one of which may take it before."""
    for port in random.sample(range(20000, 32000), 200):
        with socket.socket() as trial:
            try:
                trial.bind(("127.0.0.1", port))
                return port
            except OSError:
                continue
    raise RuntimeError("no free port for a master between 20000 and 32000")
