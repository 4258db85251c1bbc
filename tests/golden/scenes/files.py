"""The bag of a case: a scene is written to it, read from it, and compared with it.

A bag begins with rviz's config, as a text on a topic of its own.

Two scenes are the same if their configs are the same as YAML, and if their messages have the same topics, types, contents and
times in the same order. A header's `seq` does not count, because whoever publishes a message sets it; and all messages are
latched when they are played, whether or not a bag says so. A quaternion and its negative are the same rotation.
"""

import io

import genpy
import rosbag
import yaml
from std_msgs.msg import String

CONFIG_TOPIC = "/rviz_config"

# Numbers of 64 bits are the same if they agree to this: sines and roots may differ in their last bits between machines.
RELATIVE_TOLERANCE = 1e-12
# Some bags have their messages a millisecond apart, in the order in which they are played.
TIME_TOLERANCE_SECS = 0.05


def read_bag(file):
    """The text of a bag's config, and its messages in their order: (topic, message, seconds since the bag's first message).

    The messages' classes are made from the bag's own definitions.
    """
    found = []
    with rosbag.Bag(str(file)) as bag:
        for topic, (_, data, _, _, kind), time in bag.read_messages(raw=True):
            message = kind()
            message.deserialize(data)
            found.append((topic, message, time))
    (topic, config, first), *messages = found
    if topic != CONFIG_TOPIC:
        raise ValueError(f"{file} does not begin with {CONFIG_TOPIC}")
    return config.data, [(topic, message, (time - first).to_sec()) for topic, message, time in messages]


def write_bag(config, messages, file, start_secs):
    """Writes a config, as the values of its YAML, and messages as latched ones; times begin at `start_secs`."""
    text = yaml.dump(config, Dumper=_NoAliases, default_flow_style=False)
    with rosbag.Bag(str(file), "w") as bag:
        for topic, message, secs in [(CONFIG_TOPIC, String(text), 0.0), *messages]:
            kind = type(message)
            header = {"topic": topic, "type": kind._type, "md5sum": kind._md5sum, "message_definition": kind._full_text,
                      "callerid": "/scene", "latching": "1"}
            bag.write(topic, message, genpy.Time(start_secs) + genpy.Duration.from_sec(secs), connection_header=header)


class _NoAliases(yaml.SafeDumper):
    """rviz's reader knows aliases, but whoever reads a config should not have to."""

    def ignore_aliases(self, data):
        return True


def difference_of_messages(ours, theirs):
    """The first difference between two lists of messages, as a sentence, or None."""
    ours, theirs = list(ours), list(theirs)
    if [topic for topic, _, _ in ours] != [topic for topic, _, _ in theirs]:
        return f"topics {[topic for topic, _, _ in ours]} instead of {[topic for topic, _, _ in theirs]}"
    for index, ((topic, one, one_secs), (_, other, other_secs)) in enumerate(zip(ours, theirs)):
        place = f"message {index} on {topic}"
        if one._type != other._type or one._md5sum != other._md5sum:
            return f"{place}: type {one._type} instead of {other._type}"
        if abs(one_secs - other_secs) > TIME_TOLERANCE_SECS:
            return f"{place}: at {one_secs} s instead of {other_secs} s"
        found = _difference(_as_received(one), _as_received(other), "")
        if found:
            return f"{place}: {found}"
    return None


def difference_of_values(ours, theirs, path=""):
    """The first difference between two values of YAML, as a sentence, or None."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        for key in sorted(ours.keys() | theirs.keys(), key=str):
            if key not in ours or key not in theirs:
                return f"{path}/{key} is in only one of them"
            found = difference_of_values(ours[key], theirs[key], f"{path}/{key}")
            if found:
                return found
        return None
    if isinstance(ours, list) and isinstance(theirs, list) and len(ours) == len(theirs):
        for index, (one, other) in enumerate(zip(ours, theirs)):
            found = difference_of_values(one, other, f"{path}/{index}")
            if found:
                return found
        return None
    if ours == theirs and isinstance(ours, bool) == isinstance(theirs, bool):
        return None
    return f"{path}: {ours!r} instead of {theirs!r}"


def _as_received(message):
    """The message after the way through its bytes, in which numbers are rounded to their fields' sizes."""
    output = io.BytesIO()
    message.serialize(output)
    received = type(message)()
    received.deserialize(output.getvalue())
    return received


def _difference(one, other, path):
    if isinstance(one, genpy.Message):
        if one._type == "geometry_msgs/Quaternion":
            if one.x * other.x + one.y * other.y + one.z * other.z + one.w * other.w < 0:
                other = type(one)(-other.x, -other.y, -other.z, -other.w)
        for field in one.__slots__:
            if one._type == "std_msgs/Header" and field == "seq":
                continue
            found = _difference(getattr(one, field), getattr(other, field), f"{path}.{field}")
            if found:
                return found
        return None
    if isinstance(one, (list, tuple)):
        if len(one) != len(other):
            return f"{path}: {len(one)} elements instead of {len(other)}"
        for index, (a, b) in enumerate(zip(one, other)):
            found = _difference(a, b, f"{path}[{index}]")
            if found:
                return found
        return None
    if isinstance(one, float):
        same = one == other or abs(one - other) <= RELATIVE_TOLERANCE * max(1.0, abs(one)) or (one != one and other != other)
        return None if same else f"{path}: {one!r} instead of {other!r}"
    if one == other:
        return None
    if isinstance(one, bytes):
        at = next((i for i, (a, b) in enumerate(zip(one, other)) if a != b), min(len(one), len(other)))
        return f"{path}: {len(one)} and {len(other)} bytes, different from byte {at} on"
    return f"{path}: {one!r} instead of {other!r}"
