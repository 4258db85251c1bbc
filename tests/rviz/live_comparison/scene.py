"""A random scene, made from a seed: displays, cameras, and the messages of a few steps of time.

Each step has a time of the simulated clock and messages for that time. Between two steps both programs are given the time
to draw. Names of topics, frames and parameters begin with the seed, so that scenes that follow each other on one master
and in one rviz have nothing in common.

What rviz draws by chance, or draws otherwise as docs/reference/differences.md says, is left out; each such place says why.
"""

import math
import random

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from golden.scenes.messages import frame_at, frames
from std_msgs.msg import ColorRGBA, Header

from .spoil import spoil

# Seconds of the simulated clock: between two steps, and from the last one until everything stands still.
STEP_SECS = 0.5
REST_SECS = 1.0
# How far an age must be from a limit of age, so that it does not matter when exactly a message was processed.
MARGIN_SECS = 0.2


# The share of faulty messages.
SPOILT = 0.1


class Frame:
    """A frame with its parent; a moving one has another pose in each step."""

    def __init__(self, name, parent, poses):
        self.name, self.parent, self.poses = name, parent, poses

    @property
    def moves(self):
        return len(self.poses) > 1


class Scene:
    """The scene of a seed: `displays` for the config, `steps` of (topic, message), `cameras`, `parameters`."""

    def __init__(self, seed, start_secs):
        self.seed = seed
        self.rng = random.Random(seed)
        self.numpy = np.random.default_rng(seed)
        self.prefix = f's{seed}'
        self.times = [start_secs + STEP_SECS * i for i in range(self.rng.randint(1, 5))]
        self.end_secs = self.times[-1] + REST_SECS
        self.steps = [[] for _ in self.times]
        self.displays, self.cameras, self.parameters, self.classes, self.spoilt = [], [], {}, [], []
        self.config = ''
        self.transforms_first = self.rng.random() < 0.5
        self.default_light = self.rng.random() < 0.9
        self.fixed = self.name('map')
        self.frames = [Frame(self.fixed, None, [None])]
        for i in range(self.rng.randint(1, 5)):
            self.add_frame(f'f{i}')
        if self.chance(0.2):
            self.fixed = self.frame(moving=False)

    # --- names and frames ---------------------------------------------------------------------------------------------

    def name(self, word):
        return f'{self.prefix}_{word}'

    def topic(self, word):
        """A topic that no other display has."""
        return f'/{self.prefix}/{word}{len(self.displays)}'

    def add_frame(self, word, pose=None):
        """A frame below one that exists already, fixed or moving from step to step."""
        parent = self.rng.choice(self.frames).name
        count = len(self.times) if self.rng.random() < 0.4 else 1
        poses = [self.pose(0.25) for _ in range(count)] if pose is None else [pose]
        self.frames.append(Frame(self.name(word), parent, poses))
        return self.frames[-1]

    def frame(self, moving=True):
        """The name of a frame; of one that stands still if not `moving`."""
        return self.rng.choice([frame for frame in self.frames if moving or not self.is_moving(frame)]).name

    def is_moving(self, frame):
        """Whether the frame or one of those that it is attached to moves."""
        by_name = {frame.name: frame for frame in self.frames}
        while frame is not None:
            if frame.moves:
                return True
            frame = by_name.get(frame.parent)
        return False

    def transforms(self, step):
        """The message of all transforms at a step."""
        placed = [frame for frame in self.frames if frame.parent is not None]
        return frames(*(self.transform(frame, step) for frame in placed))

    def transform(self, frame, step):
        pose = frame.poses[step if frame.moves else 0]
        at = (pose.position.x, pose.position.y, pose.position.z)
        transform = frame_at(frame.name, frame.parent, at, pose.orientation)
        transform.header.stamp = self.stamp(step)
        return transform

    # --- time ---------------------------------------------------------------------------------------------------------

    def stamp(self, step):
        return rospy.Time.from_sec(self.times[step])

    def header(self, step, may_move=True):
        """A header of a step. Without a stamp only in a frame that stands still: "now" is another time for each program."""
        if self.chance(0.15):
            return Header(frame_id=self.frame(moving=False))
        if self.chance(0.01):
            return Header(stamp=self.stamp(step), frame_id=self.name('nowhere'))
        return Header(stamp=self.stamp(step), frame_id=self.frame(may_move))

    def age(self, secs):
        """`secs`, or very long where a message of that age would be at its limit when everything stands still."""
        ages = [self.end_secs - time for time in self.times] + [0.0]
        return secs if all(abs(secs - age) > MARGIN_SECS for age in ages) else 1000.0

    # --- what happens -------------------------------------------------------------------------------------------------

    def add_display(self, kind, **properties):
        """A display of class `rviz/KIND`."""
        name = f'{kind} {len(self.displays)}'
        self.classes.append(kind)
        # rviz takes up markers that wait for their transforms in no fixed order.
        self.transforms_first |= kind in ('Marker', 'MarkerArray')
        display = {'Class': f'rviz/{kind}', 'Name': name, 'Enabled': True, 'Value': True}
        self.displays.append({**display, **properties})
        return self.displays[-1]

    def publish(self, step, topic, message):
        """A message of a step; a few of them are faulty."""
        if self.rng.random() < SPOILT:
            what = spoil(self, message)
            if what:
                self.spoilt.append(f'{topic} {what}')
        self.steps[step].append((topic, message))

    def publish_at_some(self, topic, make, first=0):
        """`make(step)` at random steps from `first` on, at least one."""
        chosen = [step for step in range(first, len(self.times)) if self.rng.random() < 0.6]
        for step in chosen or [self.rng.randrange(first, len(self.times))]:
            self.publish(step, topic, make(step))

    # --- random values ------------------------------------------------------------------------------------------------

    def some(self, properties):
        """A part of the properties; those that are left out have their defaults."""
        return {key: value for key, value in properties.items() if self.rng.random() < 0.75}

    def count(self, counts):
        """One of the counts, or rarely 0."""
        return 0 if self.chance(0.04) else self.rng.choice(counts)

    def chance(self, probability):
        return self.rng.random() < probability

    def uniform(self, low, high):
        return round(self.rng.uniform(low, high), 4)

    def log_uniform(self, low, high):
        return round(math.exp(self.rng.uniform(math.log(low), math.log(high))), 5)

    def alpha(self):
        """Mostly opaque; else any opacity."""
        return 1.0 if self.chance(0.5) else self.rng.choice([0.0, 0.05, 0.3, 0.5, 0.7, 0.9, 0.99])

    def color(self):
        """A colour as a config has it."""
        return '; '.join(str(self.rng.choice([0, 255, self.rng.randrange(256)])) for _ in range(3))

    def rgba(self, alpha=None):
        channels = [self.rng.choice([0.0, 1.0, self.rng.random()]) for _ in range(3)]
        return ColorRGBA(*channels, self.alpha() if alpha is None else alpha)

    def point(self, radius=0.6):
        return Point(*(self.uniform(-radius, radius) for _ in range(3)))

    def quaternion(self):
        """A turn about any axis; often none."""
        if self.chance(0.3):
            return Quaternion(0, 0, 0, 1)
        axis = self.numpy.normal(size=4)
        x, y, z, w = axis / np.linalg.norm(axis)
        return Quaternion(x, y, z, w)

    def pose(self, radius=0.6):
        return Pose(self.point(radius), self.quaternion())
