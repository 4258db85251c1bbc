"""The golden cases as files: bags written from their scenes, pictures taken from the real rviz.

A Recorder has a stage, on which one case after the other is played: each with an rviz of its own, because displays, frames and
materials of one config would stay for the next.
"""

import pathlib

import numpy
import yaml
from PIL import Image

from . import displays, files, scene
from .messages import STAMP_SECS
from .recorder import PictureWatch, SceneNode
from .rviz_runner import Stage

GOLDEN = pathlib.Path(__file__).resolve().parent.parent
CASES = GOLDEN / "cases"
LIST = GOLDEN / "cases.yaml"
# How often a picture is taken until it is the expected one: usually, and where rviz draws it differently from run to run.
USUAL_ATTEMPTS, VARYING_ATTEMPTS = 4, 60
# Of the varying ones, every other is taken with another layout of the memory, in which what rviz sorts by address is in another
# order.
OTHER_LAYOUT = {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"}
# How often the picture of a new case is taken, to see whether it varies.
NEW_ATTEMPTS = 3


def descriptions():
    """What the list says of each case: its fields by name."""
    with open(LIST) as text:
        return yaml.safe_load(text)


def differences(name):
    """Differences between a case's bag and its scene, as a sentence; empty if there are none."""
    made, file = scene.make(name), CASES / f"{name}.bag"
    if not file.exists():
        return "there is no bag"
    config, messages = files.read_bag(file)
    return (files.difference_of_values(made.config(), yaml.safe_load(config))
            or files.difference_of_messages(made.messages(), messages) or "")


def write_bag(name):
    """Writes the bag of a case if it differs from its scene; returns whether it did."""
    changed = bool(differences(name))
    if changed:
        made = scene.make(name)
        files.write_bag(made.config(), made.messages(), CASES / f"{name}.bag", STAMP_SECS)
    return changed


def expected_picture(name):
    """The picture that a case has, as an array, or None."""
    file = CASES / f"{name}.png"
    return read_picture(file) if file.exists() else None


def read_picture(file):
    """A picture file as an array of 8 or 16 bits."""
    with Image.open(file) as image:
        pixels = numpy.array(image)
    # Pillow reads 16 bits of grey as 32.
    return pixels.astype(numpy.uint16) if pixels.dtype.itemsize > 1 else pixels


def write_picture(name, pixels):
    """Makes a picture the one that is expected of a case."""
    Image.fromarray(pixels).save(CASES / f"{name}.png", optimize=True)


class Recorder:
    """A stage on which cases are played. A process can have one only."""

    def __init__(self, folder, plugin_prefix):
        """folder: for logs; must be this recorder's own. plugin_prefix: where the plugin is installed."""
        self.stage = Stage(folder, plugin_prefix, [GOLDEN])
        try:
            self.node = SceneNode(self.stage)
        except BaseException:
            self.stage.end()
            raise

    def record(self, name, environment=None):
        """Plays the bag of a case to a new rviz, with further variables in its environment, and returns the Picture.

        Raises TimeoutError or RuntimeError, with the end of rviz's log, when there is none.
        """
        description = descriptions()[name]
        text, messages = files.read_bag(CASES / f"{name}.bag")
        messages = [(topic, message) for topic, message, _ in messages]
        config = self.stage.folder / f"{name}.rviz"
        config.write_text(text)
        cameras = displays.cameras(yaml.safe_load(text)["Visualization Manager"]["Displays"])
        camera = next(each for each in cameras if each["Name"] == description.get("camera", each["Name"]))
        parameters = {f"/{key}": resource(value) for key, value in description.get("params", {}).items()}
        parameters["/use_sim_time"] = any(topic == "/clock" for topic, _ in messages)
        for key, value in parameters.items():
            self.stage.set_parameter(key, value)
        try:
            with self.stage.rviz(config, environment=environment) as rviz:
                watch = PictureWatch(camera["Image Topic"], [rviz])
                try:
                    return self.node.play(messages, [rviz], watch, optional=description.get("unsubscribed_ok", False),
                                          frozen="freezes" in description)
                finally:
                    watch.close()
        finally:
            for key in parameters:
                self.stage.delete_parameter(key)

    def record_until(self, name, expected):
        """Records a case until its picture is the expected one; returns (the first picture, the run that gave the expected).

        The run is None if none did: after 4 of them, or after 60 if the case says that it `varies`.
        """
        first = None
        varies = "varies" in descriptions()[name]
        for run in range(1, (VARYING_ATTEMPTS if varies else USUAL_ATTEMPTS) + 1):
            pixels = self.record(name, OTHER_LAYOUT if varies and run % 2 == 0 else {}).pixels
            if numpy.array_equal(pixels, expected):
                return pixels, run
            first = pixels if first is None else first
        return first, None

    def end(self):
        """Ends the stage."""
        self.stage.end()


def resource(address):
    """The text of a file named by a `package://` address of one of the packages `assets` and `robots`."""
    package, _, path = address[len("package://"):].partition("/")
    return (GOLDEN / package.replace("conformance_", "", 1) / path).read_text()
