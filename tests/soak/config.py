"""Configs that `./soak` saves while the node runs: edited ones, and ones that cannot be read."""

import collections
import os

from . import scene

EXTRAS = [
    'Class: rviz/Grid, Plane: YZ, Plane Cell Count: 5, Color: 200; 80; 80',
    'Class: rviz/PointCloud2, Topic: /soak/lidar, Style: Boxes, Size (m): 0.02, Color Transformer: AxisColor',
    'Class: rviz/PointCloud2, Topic: /soak/nobody, Style: Points',
    'Class: rviz/LaserScan, Topic: /soak/lidar',
    'Class: rviz/Axes, Reference Frame: no_such_frame',
    'Class: rviz/Map, Topic: /soak/map, Color Scheme: raw, Draw Behind: true',
    'Class: rviz/MarkerArray, Marker Topic: /soak/markers, Namespaces: {array: false}',
    'Class: rviz/RobotModel, Robot Description: no_such_description',
    'Class: rviz/RobotModel, Robot Description: robot_description, Alpha: 0.4, Collision Enabled: true',
    'Class: rviz/TF, Show Names: false',
    'Class: fancy_plugins/Hologram, Topic: /soak/lidar',
]


def edited(rng):
    """The config with displays removed, added and changed, and perhaps another camera."""
    displays = collections.OrderedDict(scene.DISPLAYS)
    removable = [name for name in displays if name not in ('polygon', 'range', 'beacon')]
    for name in rng.sample(removable, rng.randrange(0, 6)):
        del displays[name]
    for name in rng.sample(list(displays), 3):
        if 'Alpha: ' in displays[name]:
            displays[name] = displays[name].replace('Alpha: ', 'Alpha: 0.3, Old Alpha: ')
    for number, extra in enumerate(rng.sample(EXTRAS, rng.randrange(0, 5))):
        displays['extra {}'.format(number)] = extra
    return scene.config(displays, ['more_{}'.format(number) for number in range(rng.randrange(0, 2))])


# Where a wrong message has an effect that lasts until the display is reset, as in rviz: a mistake of a server of interactive markers
# stops its display, and a cloud without the fields of a display's colour transformer has that use another one.
LASTING = ('depth', 'lidar', 'boxes', 'spheres', 'decaying', 'beacon', 'legacy', 'scan', 'handles')


def reset(topics):
    """The config without those displays of topics that a wrong message may have changed for good; None where there are none."""
    displays = collections.OrderedDict(scene.DISPLAYS)
    for name in LASTING:
        if any('Topic: {},'.format(topic) in displays[name] for topic in topics):
            del displays[name]
    return scene.config(displays) if len(displays) < len(scene.DISPLAYS) else None


def save(file, text, rng=None):
    """Saves the config in place as rviz does, or as many editors do, by renaming."""
    if rng and rng.random() < 0.5:
        with open(file + '.new', 'w') as out:
            out.write(text)
        os.replace(file + '.new', file)
    else:
        with open(file, 'w') as out:
            out.write(text)


def write(file, data):
    with open(file, 'wb') as out:
        out.write(data)


def cut_in_half(file, rng):
    """Ends within a display: what ends behind one is a config that can be read, with fewer displays and no camera."""
    text = b''
    while text.count(b'{') == text.count(b'}'):
        text = TEXT[:rng.randrange(1, len(TEXT) // 2)]
    write(file, text)


TEXT = scene.config().encode()
BREAKS = {
    'cut in half': cut_in_half,
    'empty': lambda file, rng: write(file, b''),
    'noise': lambda file, rng: write(file, bytes(rng.randrange(256) for _ in range(2000))),
    'deleted': lambda file, rng: os.remove(file),
    'nested': lambda file, rng: write(file, b'{a: ' * 20000),
    'aliases': lambda file, rng: write(file, b'a: &a [1,1]\n' + b''.join(
        b'%c: &%c [*%c,*%c]\n' % (c + 1, c + 1, c, c) for c in range(97, 121))),
}
