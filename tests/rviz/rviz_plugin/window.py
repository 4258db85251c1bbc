"""A running rviz with the driver, operated by commands."""

import itertools
import signal
import threading

import yaml

from golden.scenes.processes import wait_until

from .stage import stage

ANSWER_TIMEOUT_SECS = 300.0
END_TIMEOUT_SECS = 300.0

OK, WARNING, ERROR = 0, 1, 2
CAMERA_PUB = "rviz_camera_stream/CameraPub"


def camera(name="Camera", **settings):
    """A CameraPub of a config: topics in the namespace of its name, and settings by their names in rviz."""
    display = {"Class": CAMERA_PUB, "Name": name, "Enabled": True, "Value": True, "Image Topic": f"/{name.lower()}/image",
               "Camera Info Topic": f"/{name.lower()}/info", "Display namespace": name.lower(),
               "Visibility": {"Value": True}}
    display.update(settings)
    return display


def grid(name="Grid"):
    """A white grid in the plane of the fixed frame's x and y, one line each metre, not lit."""
    return {"Class": "rviz/Grid", "Name": name, "Enabled": True, "Value": True, "Cell Size": 1, "Plane Cell Count": 10,
            "Color": "255; 255; 255", "Alpha": 1, "Reference Frame": "<Fixed Frame>"}


class Rviz:
    """rviz with these displays and the driver. A `with` block ends it."""

    _numbers = itertools.count()

    def __init__(self, displays, environment=None, fixed_frame="map"):
        import rospy
        from std_msgs.msg import String
        self._stage = stage()
        self._answers, self._lock = {}, threading.Lock()
        self._subscriber = rospy.Subscriber("/driver/answer", String, self._receive, queue_size=100)
        self._publisher = rospy.Publisher("/driver/command", String, queue_size=100)
        driver = {"Class": "rviz_test_driver/Driver", "Name": "Driver", "Enabled": True, "Value": True}
        config = {"Visualization Manager": {
            "Displays": [*displays, driver], "Global Options": {"Fixed Frame": fixed_frame, "Frame Rate": 30},
            "Views": {"Current": {"Class": "rviz/Orbit", "Distance": 5}}}}
        path = self._stage.folder / f"config_{next(self._numbers)}.rviz"
        path.write_text(yaml.safe_dump(config))
        before = dict(self._stage.environment)
        self._stage.environment.update(environment or {})
        try:
            self.program = self._stage.rviz(path)
        finally:
            self._stage.environment.clear()
            self._stage.environment.update(before)
        wait_until(lambda: self._publisher.get_num_connections() and self._subscriber.get_num_connections(),
                   ANSWER_TIMEOUT_SECS, "the driver is not there", [self.program])

    def _receive(self, message):
        number, result, text = message.data.split("\t", 2)
        with self._lock:
            self._answers[int(number)] = (result, text)

    def command(self, *words):
        """Runs a command of the driver and returns its text. Raises RuntimeError with its reason, or when rviz ends."""
        number = next(self._numbers)
        self._publisher.publish("\t".join([str(number), *(str(word) for word in words)]))
        wait_until(lambda: number in self._answers, ANSWER_TIMEOUT_SECS, f"no answer to {words}", [self.program])
        result, text = self._answers.pop(number)
        if result != "ok":
            raise RuntimeError(f"{words}: {text}")
        return text

    def statuses(self, display):
        """The statuses of a display: name to (level, text)."""
        lines = [line.split("\t", 2) for line in self.command("statuses", display).splitlines()]
        return {name: (int(level), text) for level, name, text in lines}

    def report(self):
        """The statuses of all displays, for a test that has failed."""
        displays = yaml.safe_load(self.command("config"))["Displays"]
        return {display["Name"]: self.statuses(display["Name"]) for display in displays}

    def wait_for_status(self, display, name, level, text=""):
        """Waits until a status has this level and contains this text, and returns the whole text."""
        def found():
            has_level, has_text = self.statuses(display).get(name, (None, ""))
            return has_level == level and text in has_text and (has_text or True)
        return wait_until(found, ANSWER_TIMEOUT_SECS, f"status {name} of {display} is not {level} {text!r}", [self.program],
                          interval_secs=0.1)

    def resources(self):
        """What may leak: textures, their bytes, cameras."""
        words = self.command("resources").split()
        return {name: int(number) for name, number in zip(words[::2], words[1::2])}

    def allocated_bytes(self):
        """The bytes that rviz's process has allocated and not freed."""
        return int(self.command("allocated"))

    def frames(self, count):
        """Waits until the window has been drawn so often."""
        end = int(self.command("frames")) + count
        wait_until(lambda: int(self.command("frames")) >= end, ANSWER_TIMEOUT_SECS, "rviz does not draw", [self.program])

    def close(self):
        """Closes rviz as Ctrl-C does, and returns its exit status: negative if a signal ended it."""
        if self.program.is_running():
            self.program.process.send_signal(signal.SIGINT)
            self.program.process.wait(END_TIMEOUT_SECS)
        self.program.end()
        self._subscriber.unregister()
        self._publisher.unregister()
        return self.program.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.program.end()
        self._subscriber.unregister()
        self._publisher.unregister()
