"""Makes golden cases again with the real rviz: the bag from its scene, the picture from rviz.

This is what `tests/golden/regenerate` runs once the plugin is there; its header describes the arguments. A picture is taken
again if it differs: 4 times, or 60 times where rviz draws it differently from run to run (`varies` in cases.yaml). It is the same
if one of them is.
"""

import argparse
import collections
import multiprocessing
import os
import pathlib
import queue
import signal
import sys
import tempfile
import time
import traceback

from . import golden, scene
from .scores import scores


def arguments_of(command_line):
    parser = argparse.ArgumentParser(prog="tests/golden/regenerate", add_help=False)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--runs", type=int, metavar="N")
    parser.add_argument("--jobs", type=int, default=min(4, os.cpu_count() or 1), metavar="N")
    parser.add_argument("--plugin", type=pathlib.Path, required=True, metavar="PREFIX")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("test_output/regenerated"), metavar="DIR")
    arguments = parser.parse_args(command_line)
    if arguments.jobs < 1 or (arguments.runs or 1) < 1:
        parser.error("--jobs and --runs must be at least 1")
    arguments.names = names_of(arguments.cases, parser)
    return arguments


def names_of(patterns, parser):
    """The cases that the arguments name."""
    known = sorted(set(scene.all_cases()) | set(golden.descriptions()))
    if not patterns:
        return known
    found = []
    for pattern in patterns:
        some = [name for name in known if name == pattern or (pattern.endswith("*") and name.startswith(pattern[:-1]))]
        if not some:
            parser.error(f"there is no case {pattern}; a new one is a function of that name in tests/golden/scenes/subjects")
        found += some
    return list(dict.fromkeys(found))


def main(command_line=None):
    arguments = arguments_of(command_line)
    if not arguments.plugin.joinpath("lib/librviz_camera_stream.so").exists():
        sys.exit(f"regenerate: there is no lib/librviz_camera_stream.so in {arguments.plugin}")
    for name in arguments.names:
        if name not in scene.all_cases() or name not in golden.descriptions():
            sys.exit(f"regenerate: the case {name} needs a function in tests/golden/scenes/subjects and a line in cases.yaml")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    counts = collections.Counter()
    for line, kind in Workers(arguments):
        counts[kind] += 1
        print(f"[{sum(counts.values())}/{len(arguments.names)}] {line}", flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    return 1 if counts["different"] or counts["failed"] else 0


class Workers:
    """Processes with a recorder each; iterating gives a line and a kind of result for each case."""

    def __init__(self, arguments):
        self.arguments = arguments

    def __iter__(self):
        spawn = multiprocessing.get_context("spawn")
        names, results = spawn.Queue(), spawn.Queue()
        jobs = min(self.arguments.jobs, len(self.arguments.names))
        for name in [*self.arguments.names, *[None] * jobs]:
            names.put(name)
        with tempfile.TemporaryDirectory(prefix="regenerate_golden_") as folder:
            processes = [spawn.Process(target=work, args=(names, results, f"{folder}/{index}", self.arguments), daemon=True)
                         for index in range(jobs)]
            try:
                for process in processes:
                    process.start()
                for _ in self.arguments.names:
                    yield self._result(results, processes)
                for process in processes:
                    process.join(30)
            finally:
                for process in processes:
                    process.terminate()
                for process in processes:
                    process.join(20)

    @staticmethod
    def _result(results, processes):
        while True:
            try:
                return results.get(timeout=1)
            except queue.Empty:
                if not any(process.is_alive() for process in processes):
                    sys.exit("regenerate: no rviz could be started; see above")


def work(names, results, folder, arguments):
    """A worker: takes names until it gets None, and puts (line, kind) for each."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    recorder = golden.Recorder(folder, arguments.plugin.resolve())
    try:
        while (name := names.get()) is not None:
            begin = time.monotonic()
            try:
                line, kind = treat(recorder, name, arguments)
            except Exception as error:
                if not isinstance(error, (RuntimeError, TimeoutError)):
                    traceback.print_exc()
                line, kind = f"{name}: {error}", "failed"
            results.put((f"{line} ({time.monotonic() - begin:.1f} s)", kind))
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        recorder.end()


def treat(recorder, name, arguments):
    """Takes a case's picture and compares or writes it; returns (line, kind)."""
    if arguments.runs:
        return measure(recorder, name, arguments)
    if arguments.check and (said := golden.differences(name)):
        return f"{name}: {said}", "different"
    written = "the bag and " if not arguments.check and golden.write_bag(name) else ""
    expected = golden.expected_picture(name)
    if expected is None:
        return first_picture(recorder, name, written, arguments)
    pixels, run = recorder.record_until(name, expected)
    if run:
        return f"{name}: same{how_often(name, run)}" + (", wrote the bag" if written else ""), "same"
    if arguments.check:
        return f"{name}: {comparison(expected, pixels)}; {leave(name, pixels, arguments)}", "different"
    golden.write_picture(name, pixels)
    return f"{name}: wrote {written}the picture ({comparison(expected, pixels)})", "written"


def first_picture(recorder, name, written, arguments):
    """Takes the picture of a case that has none; returns (line, kind)."""
    if arguments.check:
        return f"{name}: there is no picture", "different"
    first, *others = (recorder.record(name).pixels for _ in range(golden.NEW_ATTEMPTS))
    golden.write_picture(name, first)
    line = f"{name}: wrote {written}the picture"
    for other in others:
        if other.tobytes() != first.tobytes():
            line += f"; another run: {comparison(first, other)}, so cases.yaml should say why it `varies`"
    return line, "written"


def how_often(name, run):
    """What to say of a picture that was the expected one only in this run."""
    if run == 1:
        return ""
    if "varies" in golden.descriptions()[name]:
        return f" in run {run}"
    return f" in run {run}, so it varies: cases.yaml should say why"


def measure(recorder, name, arguments):
    """Takes a picture several times; says how many different ones there are and how they score against the expected one."""
    expected = golden.expected_picture(name)
    found = {}
    for _ in range(arguments.runs):
        pixels = recorder.record(name).pixels
        found.setdefault(pixels.tobytes(), [pixels, 0])[1] += 1
    lines = [f"{count}x {comparison(expected, pixels)}" for pixels, count in
             sorted(found.values(), key=lambda each: -each[1])]
    for index, (pixels, _) in enumerate(found.values()):
        leave(f"{name}_{index}", pixels, arguments)
    same = len(found) == 1 and next(iter(found.values()))[0].tobytes() == expected.tobytes()
    return f"{name}: {', '.join(lines)}", "same" if same else "different"


def comparison(expected, actual):
    """How two pictures differ, in words."""
    if expected.shape != actual.shape:
        return f"{actual.shape[1]}x{actual.shape[0]} pixels instead of {expected.shape[1]}x{expected.shape[0]}"
    found = scores(expected, actual)
    if not found.different:
        return "same"
    return (f"{found.different} pixels differ, by {found.largest} at most, strict {found.strict:.4f},"
            f" close {found.close:.4f}")


def leave(name, pixels, arguments):
    """Leaves a picture for people to look at."""
    arguments.output.mkdir(parents=True, exist_ok=True)
    file = arguments.output / f"{name}.png"
    golden.Image.fromarray(pixels).save(file)
    return str(file)


if __name__ == "__main__":
    sys.exit(main())
