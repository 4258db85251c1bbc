"""The scene of a golden case: displays, messages and a camera.

A case is a function with the case's name and the one parameter `scene`, a Scene to fill, or a row of a `family`, in one of the
modules of `subjects`. What it shows is said in `cases.yaml`.
"""

import functools
import importlib
import inspect
import pathlib
import pkgutil

from visualization_msgs.msg import MarkerArray

from . import displays as shown
from .geometry import look_at
from .messages import camera_info, frame_at, frames

CAMERA_FRAME = "proj_view"
# Options of a camera with a larger picture.
LARGE = {"size": (640, 480), "focal": (500, 500)}

ORBIT = {"Class": "rviz/Orbit", "Name": "Current View", "Value": "Orbit (rviz)", "Target Frame": "<Fixed Frame>",
         "Distance": 4, "Pitch": 0.6, "Yaw": 5.8}

_cases = {}


class Scene:
    """A config, messages and a camera, all of which begin with the usual."""

    def __init__(self):
        self.fixed_frame = "base_link"
        self.default_light = True
        self.tools = [{"Class": "rviz/MoveCamera"}]
        self.rviz_view = ORBIT
        self.displays = []
        self._frames, self._messages = [], []
        self._camera_frame = self._info = None
        self.camera()

    def camera(self, eye=(1.6, 1.1, 1.5), target=(0.0, 0.0, 0.15), roll=0.0, turned=None, parent="base_link", size=(400, 300),
               focal=(310.0, 310.0), **info):
        """Places the camera, in metres and pixels.

        eye, target: where it is and where it looks; roll: about the view, clockwise, in radians. turned: its optical frame's
        rotation, instead of target and roll. info: `centre`, `shift` and fields, as of `messages.camera_info`.
        """
        if parent is not None:
            self._camera_frame = frame_at(CAMERA_FRAME, parent, eye, turned or look_at(eye, target, roll))
        else:
            self._camera_frame = None
        self._info = camera_info(CAMERA_FRAME, size, focal, **info)

    def frame(self, child, parent="base_link", at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0)):
        """Adds a fixed frame."""
        self._frames.append(frame_at(child, parent, at, turned))

    def show(self, *displays):
        """Adds displays to the config. Unless there is a `camera_pub` among them, one that shows all of them is added."""
        self.displays += displays

    def publish(self, topic, *messages, secs=0.0):
        """Adds messages, `secs` after the scene's beginning."""
        self._messages += [(topic, message, secs) for message in messages]

    def show_markers(self, *markers):
        """Shows Markers with a MarkerArray display."""
        self.show(shown.display("MarkerArray"))
        self.publish("/m", MarkerArray(markers=list(markers)))

    def messages(self):
        """All messages in their order: (topic, message, seconds since the scene's beginning)."""
        fixed = ([self._camera_frame] if self._camera_frame else []) + self._frames
        return [("/tf_static", frames(*fixed), 0.0), (shown.CAMERA_INFO_TOPIC, self._info, 0.0), *self._messages]

    def config(self):
        """The config as the values of its YAML."""
        displays = list(self.displays)
        if not shown.cameras(displays):
            displays.append(shown.camera_pub())
        for camera in shown.cameras(displays):
            camera.setdefault("Visibility", shown.all_visible(displays))
        return {
            "Panels": [{"Class": "rviz/Displays", "Name": "Displays"}],
            "Visualization Manager": {
                "Class": "", "Enabled": True, "Name": "root", "Value": True,
                "Displays": displays,
                "Global Options": {"Background Color": "48; 48; 48", "Default Light": self.default_light,
                                   "Fixed Frame": self.fixed_frame, "Frame Rate": 30},
                "Tools": self.tools,
                "Views": {"Current": self.rviz_view, "Saved": None},
            },
            "Window Geometry": {"Height": 500, "Width": 800, "X": 0, "Y": 0},
        }


def family(function, rows):
    """Makes a case of each row, by name: the arguments of `function` behind the scene, as a sequence or by their names."""
    for name, row in rows.items():
        arguments, named = ((), row) if isinstance(row, dict) else (row, {})
        _add(name, functools.partial(_call, function, arguments, named))


def _call(function, arguments, named, scene):
    function(scene, *arguments, **named)


def one_display(kind, topic, **more):
    """A function for `family` whose rows are the properties of one display, its message and, if need be, the camera's options."""
    def fill(scene, properties, message, camera=None):
        scene.camera(**(camera or {}))
        scene.show(shown.display(kind, properties, **more))
        scene.publish(topic, message)

    return fill


def _add(name, function):
    if name in _cases:
        raise ValueError(f"there are two cases {name}")
    _cases[name] = function


@functools.cache
def all_cases():
    """The functions of all cases, by name."""
    folder = pathlib.Path(__file__).parent / "subjects"
    for found in pkgutil.iter_modules([str(folder)]):
        module = importlib.import_module(f"{__package__}.subjects.{found.name}")
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and list(inspect.signature(function).parameters) == ["scene"]:
                _add(name, function)
    return dict(sorted(_cases.items()))


def make(name):
    """The scene of a case. Raises KeyError when there is none of this name."""
    scene = Scene()
    all_cases()[name](scene)
    return scene
