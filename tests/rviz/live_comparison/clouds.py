"""Random displays of points: PointCloud2, PointCloud, LaserScan, DepthCloud, and the four of single values."""

import struct

import numpy as np
from geometry_msgs.msg import Point32
from golden.scenes.clouds import packed, raw_cloud
from golden.scenes.messages import camera_info
from sensor_msgs.msg import (ChannelFloat32, FluidPressure, Illuminance, Image, LaserScan, PointCloud, RelativeHumidity,
                             Temperature)
from std_msgs.msg import Header

from .scene import STEP_SECS

STYLES = ['Points', 'Squares', 'Flat Squares', 'Spheres', 'Boxes']
TRANSFORMERS = ['Intensity', 'RGB8', 'MONO8', 'RGBF32', 'FlatColor', 'AxisColor']
NUMBERS = ['int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'float32', 'float64']


def properties(scene, channel='intensity', bounds=(0, 4096), size_m=(0.02, 0.2)):
    """The properties that all of these displays share."""
    style = scene.rng.choice(STYLES)
    auto = scene.chance(0.7)
    low, high = sorted(scene.uniform(*bounds) for _ in range(2))
    chosen = {
        'Alpha': scene.alpha(), 'Decay Time': scene.age(scene.uniform(0.3, 3.0)) if scene.chance(0.2) else 0,
        'Color Transformer': scene.rng.choice(TRANSFORMERS), 'Channel Name': channel,
        'Use rainbow': scene.chance(0.6), 'Invert Rainbow': scene.chance(0.3),
        'Min Color': scene.color(), 'Max Color': scene.color(), 'Color': scene.color(),
        'Autocompute Intensity Bounds': auto, 'Min Intensity': low, 'Max Intensity': high,
        'Axis': scene.rng.choice('XYZ'), 'Use Fixed Frame': scene.chance(0.6),
        'Autocompute Value Bounds': {'Value': scene.chance(0.7), 'Min Value': scene.uniform(-1, 0),
                                     'Max Value': scene.uniform(0, 1)},
        'Selectable': scene.chance(0.9)}
    # The display keeps the sizes of both kinds, and the style decides which of them counts.
    sizes = {'Style': style, 'Size (Pixels)': scene.log_uniform(1, 30), 'Size (m)': scene.log_uniform(*size_m)}
    return {**scene.some(chosen), **sizes, 'Position Transformer': 'XYZ', 'Queue Size': scene.rng.randint(10, 50)}


def positions(scene, count):
    """Points in a ball, on a plane, on a line, or on a grid; a few of them NaN or infinite."""
    # Many on a line lie before each other at depths that differ by less than the depth buffer tells.
    shape = scene.rng.choice(['ball', 'plane', 'grid', 'line' if count <= 50 else 'ball'])
    points = scene.numpy.uniform(-0.7, 0.7, (count, 3))
    if shape == 'plane':
        points[:, 2] = points[:, 0] * 0.3
    elif shape == 'line':
        points = points[:, :1] * scene.numpy.normal(size=3)[None] * 0.6
    elif shape == 'grid':
        # Beside the origin: translucent clouds whose middles are equally far away have no order.
        points = np.round(points * 5) / 5 + scene.numpy.uniform(-0.1, 0.1, 3)
    if scene.chance(0.15):
        rows = scene.numpy.integers(0, max(count, 1), max(count // 10, 1) if count else 0)
        points[rows, 0] = scene.rng.choice([np.nan, np.inf, -np.inf])
    return points.astype(np.float32)


def count_of_points(scene):
    return scene.count([1, 2, 50, 200, 1000, 5000])


# --- PointCloud2 ------------------------------------------------------------------------------------------------------


def point_cloud2(scene):
    topic = scene.topic('cloud')
    scene.add_display('PointCloud2', Topic=topic, **properties(scene, bounds=(-100, 300)))
    fields = color_fields(scene)
    scene.publish_at_some(topic, lambda step: cloud_message(scene, step, fields))


def color_fields(scene):
    """Names and kinds of the fields beside x, y and z."""
    fields = []
    if scene.chance(0.5):
        fields.append((scene.rng.choice(['rgb', 'rgba']), scene.rng.choice(['rgb', 'uint32'])))
    if scene.chance(0.6):
        fields.append((scene.rng.choice(['intensity', 'intensities', 'ring']), scene.rng.choice(NUMBERS)))
    if scene.chance(0.2):
        fields += [(name, 'float32') for name in 'rgb']
    return fields


def cloud_message(scene, step, fields):
    points = positions(scene, count_of_points(scene))
    columns = [(name, 'float32', points[:, i]) for i, name in enumerate('xyz')]
    columns += [(name, kind, values_of(scene, name, kind, len(points))) for name, kind in fields]
    size = sum(np.dtype(kind.replace('rgb', 'float32')).itemsize for _, kind, _ in columns)
    rows = 2 if len(points) % 2 == 0 and scene.chance(0.2) else 1
    message = raw_cloud(columns, rows=rows, point_step=size + scene.rng.choice([0, 0, 4]), is_dense=scene.chance(0.5))
    message.header = scene.header(step)
    return message


def values_of(scene, name, kind, count):
    if name in ('rgb', 'rgba'):
        alpha = scene.numpy.choice([0, 80, 255], count) if scene.chance(0.3) else 255
        return packed(scene.numpy.integers(0, 256, (count, 3)), alpha)
    if name in ('r', 'g', 'b'):
        return scene.numpy.uniform(0, 1, count)
    low, high = (0, 200) if kind.startswith('u') else (-100, 100)
    return scene.numpy.uniform(low, high, count).astype(kind)


# --- PointCloud -------------------------------------------------------------------------------------------------------


def point_cloud(scene):
    topic = scene.topic('points')
    scene.add_display('PointCloud', Topic=topic, **properties(scene, bounds=(-100, 300)))
    names = [name for name in ('intensity', 'rgb', 'r', 'g', 'b') if scene.chance(0.4)]

    def message(step):
        points = positions(scene, count_of_points(scene))
        cloud = PointCloud(header=scene.header(step), points=[Point32(*map(float, point)) for point in points])
        for name in names:
            cloud.channels.append(ChannelFloat32(name, channel_values(scene, name, len(points))))
        return cloud

    scene.publish_at_some(topic, message)


def channel_values(scene, name, count):
    if name == 'rgb':
        colors = scene.numpy.integers(0, 1 << 24, count, np.uint32)
        return [struct.unpack('<f', struct.pack('<I', int(color)))[0] for color in colors]
    return [float(np.float32(value)) for value in scene.numpy.uniform(0, 1 if len(name) == 1 else 100, count)]


# --- LaserScan --------------------------------------------------------------------------------------------------------


def laser_scan(scene):
    """Scans that take no time, or that all take as long as a step.

    Not both: in rviz, all scans that come after a long one wait as if they took as long. And a scan that takes longer than
    those before it is lost there if the pose at its last ray comes late.
    """
    topic = scene.topic('scan')
    chosen = properties(scene, bounds=(0, 100))
    if chosen['Style'] == 'Boxes':
        # Boxes of a scan overlap and have their tops in one plane: rounding decides which of them is seen.
        chosen['Style'] = 'Squares'
    scene.add_display('LaserScan', Topic=topic, **chosen)
    takes_time = len(scene.times) > 1 and scene.chance(0.4)
    scene.transforms_first |= takes_time

    def message(step):
        count = scene.rng.choice([1, 10, 180, 720])
        scan = LaserScan(header=scene.header(step), range_min=0.1, range_max=scene.rng.choice([1.0, 5.0]))
        scan.angle_min, scan.angle_increment = scene.uniform(-3, 0), scene.uniform(0.002, 0.02)
        scan.angle_max = scan.angle_min + scan.angle_increment * (count - 1)
        ranges = scene.numpy.uniform(0.05, 1.3, count)
        if scene.chance(0.2):
            ranges[::7] = scene.rng.choice([np.nan, np.inf, 0.0])
        scan.ranges = [float(value) for value in ranges]
        if scene.chance(0.6):
            scan.intensities = [float(value) for value in scene.numpy.uniform(0, 100, count)]
        if takes_time:
            scan.header.stamp = scene.stamp(step - 1)
            scan.time_increment = STEP_SECS * 0.9 / count
        return scan

    scene.publish_at_some(topic, message, first=1 if takes_time else 0)


# --- DepthCloud -------------------------------------------------------------------------------------------------------


def depth_cloud(scene):
    """Only raw images, which both programs read; step, byte order and size are regular, because rviz assumes that."""
    depth, color = scene.topic('depth/image'), scene.topic('color/image')
    with_color = scene.chance(0.6)
    shared = properties(scene)
    # rviz loses the images of a time that it has no transform for, and counts the age from when it has made the cloud.
    shared.pop('Decay Time', None)
    auto = {'Value': scene.chance(0.7), 'Auto Size Factor': scene.log_uniform(1, 4)}
    scene.add_display('DepthCloud', **shared, **{
        'Depth Map Topic': depth, 'Depth Map Transport Hint': 'raw', 'Color Image Topic': color if with_color else '',
        'Color Transport Hint': 'raw', 'Topic Filter': False, 'Auto Size': auto, 'Occlusion Compensation': {'Value': False}})
    width, height = scene.rng.choice([(40, 30), (80, 60), (160, 120)])
    f = width * scene.uniform(0.6, 1.5)
    frame = scene.frame()
    info = camera_info(frame, (width, height), (f, f), header=Header(stamp=scene.stamp(0), frame_id=frame))
    scene.publish(0, depth.rsplit('/', 1)[0] + '/camera_info', info)
    encoding = scene.rng.choice(['16UC1', '32FC1', 'mono16'])
    color_encoding = scene.rng.choice(['rgb8', 'bgr8', 'rgba8', 'bgra8', 'mono8'])
    for step in range(1, len(scene.times)) if len(scene.times) > 1 else [0]:
        if with_color:
            scene.publish(step, color, color_image(scene, step, frame, width, height, color_encoding))
        scene.publish(step, depth, depth_image(scene, step, frame, width, height, encoding))


def image(scene, step, frame, encoding, pixels):
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, data=pixels.tobytes())
    message.header.frame_id, message.header.stamp = frame, scene.stamp(step)
    message.step = pixels.nbytes // pixels.shape[0]
    return message


def depth_image(scene, step, frame, width, height, encoding):
    v, u = np.mgrid[:height, :width]
    metres = 0.6 + 0.3 * np.sin(u / width * scene.uniform(2, 9)) + 0.3 * v / height
    metres[scene.numpy.uniform(size=metres.shape) < 0.03] = 0
    if encoding == '32FC1':
        metres[metres == 0] = np.nan
        return image(scene, step, frame, encoding, metres.astype('<f4'))
    return image(scene, step, frame, encoding, (metres * 1000).astype('<u2'))


def color_image(scene, step, frame, width, height, encoding):
    channels = {'rgb8': 3, 'bgr8': 3, 'rgba8': 4, 'bgra8': 4, 'mono8': 1}[encoding]
    pixels = scene.numpy.integers(0, 256, (height // 5, width // 5, channels), np.uint8)
    return image(scene, step, frame, encoding, np.kron(pixels, np.ones((5, 5, 1), np.uint8)))


# --- single values ----------------------------------------------------------------------------------------------------


def scalar(kind, channel, message_type, bounds):
    """A display of a single value, which has a range of its own. A scene has one of them at most.

    Their points are at the origins of frames: two may be at the same place, and then rviz decides by addresses, or rounding
    does, which of them is seen.
    """

    def add(scene):
        if any(value in scene.classes for value in SINGLE_VALUES):
            return
        topic = scene.topic(channel)
        chosen = properties(scene, channel, bounds, size_m=(0.05, 0.6))
        # Opaque: Ogre sorts what is translucent by its distance, and clouds by their middle in their own frame. So those of
        # one point are as far away as each other and as a grid in the fixed frame, and the order is that of addresses.
        chosen.pop('Alpha', None)
        chosen.pop('Decay Time', None)
        scene.add_display(kind, Topic=topic, **chosen)

        def message(step):
            value = scene.uniform(*bounds)
            return message_type(header=scene.header(step), **{channel: value})

        scene.publish_at_some(topic, message)

    return add


SINGLE_VALUES = ('FluidPressure', 'Illuminance', 'RelativeHumidity', 'Temperature')
fluid_pressure = scalar('FluidPressure', 'fluid_pressure', FluidPressure, (95000, 108000))
illuminance = scalar('Illuminance', 'illuminance', Illuminance, (-100, 1100))
relative_humidity = scalar('RelativeHumidity', 'relative_humidity', RelativeHumidity, (-0.1, 1.1))
temperature = scalar('Temperature', 'temperature', Temperature, (-20, 120))
