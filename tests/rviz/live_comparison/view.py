"""Random cameras that look at the middle of a scene, and the config around its displays."""

import math

import numpy as np
import yaml
from golden.scenes.geometry import look_at, pose
from golden.scenes.messages import camera_info
from std_msgs.msg import Header

from .scene import Frame

ENCODINGS = ['rgb8', 'rgba8', 'bgr8', 'bgra8', 'mono8', 'mono16']
SIZES = [(64, 48), (100, 75), (160, 120), (203, 151), (320, 240), (360, 480), (480, 360), (640, 480), (640, 480), (641, 359),
         (848, 480), (1024, 768), (1280, 720)]


class Camera:
    """A CameraPub display, and its CameraInfo at each step."""

    def __init__(self, scene, number):
        rng = scene.rng
        self.name = f'Camera {number}'
        self.image_topic = f'/{scene.prefix}/camera{number}/image'
        self.info_topic = f'/{scene.prefix}/eye{number}/camera_info'
        self.encoding = rng.choice(ENCODINGS) if scene.chance(0.4) else 'rgb8'
        self.frame = scene.name(f'eye{number}')
        moves = scene.chance(0.3)
        distance = scene.log_uniform(1.2, 6.0)
        poses = [looking_at_the_middle(scene, distance) for _ in range(len(scene.times) if moves else 1)]
        scene.frames.append(Frame(self.frame, scene.fixed, poses))
        seen = optics(scene, distance)
        for step in range(len(scene.times)):
            if scene.chance(0.1):
                seen = optics(scene, distance)
            elif step and not moves:
                continue
            header = Header(stamp=scene.stamp(step), frame_id=self.frame)
            scene.publish(step, self.info_topic, camera_info(self.frame, header=header, **seen))
        self.display = {
            'Class': 'rviz_camera_stream/CameraPub', 'Name': self.name, 'Enabled': True, 'Value': True,
            'Image Topic': self.image_topic, 'Camera Info Topic': self.info_topic,
            'Display namespace': f'{scene.prefix}/camera{number}', 'Frame Rate': -1, 'Queue Size': 2,
            'Image Encoding': self.encoding, 'Visibility': visibility(scene),
            'Background Color': scene.color() if scene.chance(0.4) else '0; 0; 0',
            'Near Clip Distance': scene.log_uniform(0.01, distance) if scene.chance(0.2) else 0.01}


def optics(scene, distance):
    """Optics that show a few metres at that distance: square pixels or not, a principal point anywhere near the picture.

    Small pictures show less: whether what is smaller than a pixel is seen is a matter of rounding.
    """
    width, height = scene.rng.choice(SIZES)
    f = width * distance / scene.log_uniform(1.2, min(6.0, 1.0 + width / 100))
    fx, fy = (f, f) if scene.chance(0.6) else (f, f * scene.log_uniform(0.5, 2.0))
    cx, cy = width / 2, height / 2
    if scene.chance(0.4):
        cx, cy = cx + width * scene.uniform(-0.5, 0.5), cy + height * scene.uniform(-0.5, 0.5)
    tx, ty = (fx * scene.uniform(-0.3, 0.3), fy * scene.uniform(-0.3, 0.3)) if scene.chance(0.2) else (0.0, 0.0)
    return {'size': (width, height), 'focal': (fx, fy), 'centre': (cx, cy), 'shift': (tx, ty)}


def looking_at_the_middle(scene, distance):
    """The pose of an optical frame that looks at a point near the origin, rolled or not."""
    direction = scene.numpy.normal(size=3) + [0, 0, 0.5]
    eye = direction / np.linalg.norm(direction) * distance
    roll = scene.uniform(-math.pi, math.pi) if scene.chance(0.25) else 0.0
    return pose(eye, look_at(eye, scene.numpy.uniform(-0.2, 0.2, 3), roll))


def visibility(scene):
    """Some displays are hidden from some cameras.

    Not Axes: rviz draws them regardless of a camera's Visibility. Not displays inside of groups: whether rviz respects
    their Visibility depends on the order of loading.
    """
    boxes = {'Value': True}
    if scene.chance(0.3):
        for display in scene.displays:
            if display['Class'] not in ('rviz/Axes', 'rviz/Group'):
                boxes[display['Name']] = scene.chance(0.7)
    return boxes


def grouped(scene):
    """The displays, some of them in groups, which may be switched off."""
    if not scene.chance(0.25) or len(scene.displays) < 2:
        return scene.displays
    cut = scene.rng.randrange(1, len(scene.displays))
    enabled = scene.chance(0.9)
    group = {'Class': 'rviz/Group', 'Name': 'Group', 'Enabled': enabled, 'Value': enabled, 'Displays': scene.displays[cut:]}
    return scene.displays[:cut] + [group]


def config(scene):
    """The text of the `.rviz` file."""
    displays = [dict(display) for display in scene.displays] + [camera.display for camera in scene.cameras]
    manager = {
        'Class': '', 'Displays': displays, 'Enabled': True, 'Name': 'root', 'Value': True,
        'Global Options': {'Background Color': '48; 48; 48', 'Default Light': scene.default_light, 'Fixed Frame': scene.fixed,
                           'Frame Rate': 10},
        'Tools': [{'Class': 'rviz/Interact', 'Hide Inactive Objects': True}, {'Class': 'rviz/MoveCamera'}],
        'Views': {'Current': {'Class': 'rviz/Orbit', 'Distance': 4, 'Name': 'Current View', 'Pitch': 0.6, 'Yaw': 5.8,
                              'Target Frame': '<Fixed Frame>', 'Value': 'Orbit (rviz)'}, 'Saved': None}}
    window = {'Height': 120, 'Width': 160, 'X': 0, 'Y': 0, 'Hide Left Dock': True, 'Hide Right Dock': True}
    return yaml.safe_dump({'Panels': [], 'Visualization Manager': manager, 'Window Geometry': window}, sort_keys=False)
