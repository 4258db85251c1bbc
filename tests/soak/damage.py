"""Messages as bytes: clouds that are sent without being serialised again, and messages that are damaged in many ways."""

import io
import math
import struct

import genpy
import rospy

KINDS = ['cut short', 'too long', 'huge count', 'noise', 'nan', 'infinite', 'wrong data', 'empty', 'no frame']
FAR = 1e30


class Serialized:
    """Mixed into a message's class: a message that is its bytes."""
    bytes = b''

    def serialize(self, buff):
        buff.write(self.bytes)


def serialized(message):
    """A message as bytes."""
    out = io.BytesIO()
    message.serialize(out)
    return of_bytes(message, out.getvalue())


def of_bytes(message, data):
    kind = type(message) if isinstance(message, Serialized) else type('Raw', (Serialized, type(message)), {'_has_header': False})
    raw = kind()
    raw.bytes = data
    return raw


def with_stamp(message, stamp):
    """The message with another stamp, which lies behind the header's sequence number."""
    data = bytearray(message.bytes)
    struct.pack_into('<II', data, 4, stamp.secs, stamp.nsecs)
    return of_bytes(message, bytes(data))


def fill(message, value):
    """Sets all floating-point numbers of a message."""
    for name, kind in zip(message.__slots__, message._slot_types):
        current = getattr(message, name)
        if kind in ('float32', 'float64'):
            setattr(message, name, value)
        elif kind.startswith(('float32[', 'float64[')):
            setattr(message, name, [value] * len(current))
        elif isinstance(current, genpy.Message):
            fill(current, value)
        elif isinstance(current, list) and current and isinstance(current[0], genpy.Message):
            for one in current:
                fill(one, value)


def damaged(message, kind, rng):
    """The message, damaged in one of the `KINDS`."""
    if kind in ('nan', 'infinite'):
        fill(message, math.nan if kind == 'nan' else rng.choice([math.inf, -math.inf, FAR]))
        return message
    if kind == 'no frame':
        if hasattr(message, 'header'):
            message.header.frame_id = rng.choice(['', '/', ' ', 'ä', 'a b\n', 'x' * 3000])
        return message
    if kind == 'empty':
        empty = type(message)()
        if hasattr(empty, 'header'):
            empty.header.frame_id, empty.header.stamp = 'map', rospy.Time.now()
        return empty
    if kind == 'wrong data':
        return disagree(message, rng)
    data = bytearray(serialized(message).bytes)
    if kind == 'cut short':
        del data[rng.randrange(len(data)):]
    elif kind == 'too long':
        data += bytes(rng.randrange(256) for _ in range(rng.randrange(1, 500)))
    elif kind == 'huge count':
        # Somewhere in the first bytes, where the lengths of frames, fields and lists are.
        for _ in range(rng.randrange(1, 4)):
            place = rng.randrange(max(1, min(len(data), 120) - 4))
            data[place:place + 4] = struct.pack('<I', rng.choice([0xffffffff, 0x7fffffff, 0x10000000, 65536]))
    elif kind == 'noise':
        for _ in range(rng.randrange(1, 20)):
            data[rng.randrange(len(data))] = rng.randrange(256)
    return of_bytes(message, bytes(data))


def disagree(message, rng):
    """A message whose sizes contradict each other."""
    for name, kind in zip(message.__slots__, message._slot_types):
        current = getattr(message, name)
        if kind in ('uint32', 'int32', 'uint8') and rng.random() < 0.5:
            setattr(message, name, rng.choice([0, 1, 3, 255] + ([0x7fffffff] if kind != 'uint8' else [])))
        elif kind.endswith('[]') and current and rng.random() < 0.5:
            keep = rng.randrange(len(current))
            setattr(message, name, current[:keep])
    return message
