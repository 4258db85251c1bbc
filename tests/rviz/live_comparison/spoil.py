"""Faulty messages: one number of a message is replaced by one that nobody expects."""

import math

from geometry_msgs.msg import Quaternion

# No millions: rviz loses precision in them, of which its pictures show the rounding.
NUMBERS = [float('nan'), float('inf'), float('-inf'), 0.0, -1.0, -0.5, 3.0, 30.0]
# Not those of a camera, which gets an error here; nor of handles, which stop in rviz until they are reset; nor times.
SKIPPED_TYPES = ('sensor_msgs/CameraInfo', 'visualization_msgs/InteractiveMarkerInit',
                 'visualization_msgs/InteractiveMarkerUpdate')
SKIPPED_FIELDS = ('time_increment', 'scan_time', 'header', 'lifetime', 'stamp')
# Elements of an array that may be replaced.
FIRST = 3


def spoil(scene, message):
    """Replaces one number, or the length of a quaternion, in place. Returns what was done, or none where nothing can be."""
    if message._type in SKIPPED_TYPES:
        return None
    places = list(numbers(message, message._type))
    if not places:
        return None
    owner, key, path = scene.rng.choice(places)
    if isinstance(owner, Quaternion):
        # Arrows of a path that point nowhere end rviz.
        factor = scene.rng.choice([0.5, 1.01, 2.0] if message._type == 'nav_msgs/Path' else [0.0, 0.5, 1.01, 2.0])
        owner.x, owner.y, owner.z, owner.w = (factor * part for part in (owner.x, owner.y, owner.z, owner.w))
        return f'{path} times {factor}'
    # Ogre refuses boxes around what is not finite, which ends rviz. It looks at a marker's pose, and at no other number. And a
    # map that is not finite moves the one before it to its own origin there.
    is_marker = 'visualization_msgs/Marker' in path and '.pose.' not in path
    finite_only = is_marker or message._type == 'nav_msgs/OccupancyGrid'
    value = scene.rng.choice([number for number in NUMBERS if math.isfinite(number) or not finite_only])
    if is_marker and path.endswith('.scale.z'):
        # So does a text of negative height.
        value = abs(value)
    if isinstance(owner, list):
        owner[key] = value
    else:
        setattr(owner, key, value)
    return f'{path} = {value}'


def numbers(owner, path):
    """All floating point numbers of a message: (owner, key, path)."""
    if isinstance(owner, list):
        for key, value in enumerate(owner[:FIRST]):
            yield from number(owner, key, value, f'{path}[{key}]')
    else:
        for field in owner.__slots__:
            if field not in SKIPPED_FIELDS:
                yield from number(owner, field, getattr(owner, field), f'{path}.{field}')


def number(owner, key, value, path):
    if isinstance(value, float):
        yield owner, key, path
    elif isinstance(value, list) or hasattr(value, '__slots__'):
        yield from numbers(value, path)
