"""Everything that a user does to cameras while messages flow, again and again: no crash, no leak.

An hour of it, sped up: the operations of a working day come one after the other as fast as rviz takes them.
RVIZ_PLUGIN_CYCLES sets how many there are.
"""

import os
import random
import threading
import time
import unittest

from .camera_topics import CameraFrame, Infos, Pictures, camera_info
from .stage import stage
from .window import CAMERA_PUB, Rviz, camera, grid

CYCLES = int(os.environ.get("RVIZ_PLUGIN_CYCLES", "120"))
NAMES = ["A", "B", "C", "D"]
SIZES = [(64, 48), (320, 240), (37, 23), (640, 480)]


class Flow:
    """CameraInfos of changing size for all cameras, and the subscribers of their pictures, on a thread."""

    def __init__(self):
        self._end = threading.Event()
        self._infos = [Infos(f"/{name.lower()}/info") for name in NAMES]
        self.pictures = [Pictures(f"/{name.lower()}/image") for name in NAMES]
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        count = 0
        while not self._end.wait(0.02):
            count += 1
            width, height = SIZES[count // 50 % len(SIZES)]
            for infos in self._infos:
                infos.send(camera_info(width, height))
            for pictures in self.pictures:
                if len(pictures.all()) > 20:
                    pictures.forget()

    def close(self):
        self._end.set()
        self._thread.join()
        for infos in self._infos:
            infos.close()
        for pictures in self.pictures:
            pictures.close()


def threads(pid):
    return len(os.listdir(f"/proc/{pid}/task"))


class Operator:
    """Does to the cameras what a user does, at random."""

    def __init__(self, rviz, seed):
        self.rviz, self.random, self.present = rviz, random.Random(seed), set()

    def create(self, name):
        self.rviz.command("create", name, CAMERA_PUB)
        for setting, value in camera(name).items():
            if setting in ("Image Topic", "Camera Info Topic", "Display namespace"):
                self.rviz.command("set", name, setting, value)
        self.present.add(name)

    def remove(self, name):
        self.rviz.command("remove", name)
        self.present.discard(name)

    def duplicate(self, name):
        self.rviz.command("duplicate", name, "Copy")
        self.rviz.command("remove", "Copy")

    def rename(self, name):
        self.rviz.command("rename", name, "Renamed")
        self.rviz.command("rename", "Renamed", name)

    def switch(self, name):
        self.rviz.command("enable", name, 0)
        self.rviz.command("enable", name, 1)

    def change(self, name):
        property_name, values = self.random.choice([
            ("Image Encoding", ["rgb8", "bgra8", "mono16"]), ("Frame Rate", ["-1", "0", "20"]),
            ("Background Color", ["0; 0; 0", "9; 9; 9"]), ("Near Clip Distance", ["0.01", "1"]),
            ("Undistort", ["true", "false"]), ("Projection", ["rviz", "exact"]), ("Depth Topic", ["", f"/{name.lower()}/depth"]),
            ("Display namespace", ["one", "two"]), ("Queue Size", ["1", "5"]),
            ("Camera Info Topic", [f"/{name.lower()}/info", f"/{name.lower()}/camera_info"])])
        self.rviz.command("set", name, property_name, self.random.choice(values))

    def step(self):
        name = self.random.choice(NAMES)
        if name not in self.present:
            return self.create(name)
        action = self.random.choice([self.remove, self.duplicate, self.rename, self.switch, self.change, self.change,
                                     lambda _: self.rviz.command("reset")])
        return action(name)


class Cycle(unittest.TestCase):
    def test_cameras_come_and_go_while_messages_flow(self):
        stage()
        seed = int(os.environ.get("RVIZ_PLUGIN_SEED", str(random.randrange(1 << 32))))
        print(f"RVIZ_PLUGIN_SEED={seed}, {CYCLES} operations", flush=True)
        frame, flow = CameraFrame(), Flow()
        self.addCleanup(frame.close)
        self.addCleanup(flow.close)
        rviz = Rviz([grid()])
        operator = Operator(rviz, seed)
        try:
            measured = []
            for stretch in range(4):
                for _ in range(CYCLES // 4):
                    operator.step()
                for name in sorted(operator.present):
                    operator.remove(name)
                rviz.frames(3)
                time.sleep(0.2)
                measured.append((rviz.resources(), threads(rviz.program.pid), rviz.allocated_bytes()))
            # The first stretch fills caches; after that nothing grows.
            first, last = measured[1], measured[-1]
            self.assertEqual(first[0], last[0])
            self.assertEqual(first[1], last[1])
            growth = last[2] - first[2]
            print(f"allocated: {[each[2] >> 10 for each in measured]} KiB", flush=True)
            # At the moment of counting, a picture of 1.2 MB may still be on its way.
            self.assertLess(growth, 4 << 20)
            for name in NAMES:
                operator.create(name)
        finally:
            status = rviz.close()
        # Closed with four cameras while messages flow.
        self.assertEqual(status, 0, rviz.program.last_lines(40))


if __name__ == "__main__":
    unittest.main()
