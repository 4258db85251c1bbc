"""The scene of `./soak`: a config with every display class, and messages for all of their topics.

`SOURCES` lists the topics. Each has a function that makes a message from a random generator; the same function makes what
moves all the time and what a picture check publishes, so that any process gets the same messages from the same seed. What a
check publishes replaces everything from before: markers begin with DELETEALL, histories are filled, maps are whole.
"""

import collections
import math
import time

import numpy
import rospy
from geometry_msgs.msg import (
    AccelStamped, Point, Point32, PointStamped, PolygonStamped, PoseArray, PoseStamped, PoseWithCovarianceStamped,
    TwistStamped, WrenchStamped)
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import GridCells, OccupancyGrid, Odometry, Path
from sensor_msgs.msg import (
    CameraInfo, ChannelFloat32, FluidPressure, Illuminance, Image, JointState, LaserScan, PointCloud, PointCloud2, Range,
    RelativeHumidity, Temperature)
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import (
    InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerPose, InteractiveMarkerUpdate, Marker,
    MarkerArray)

import bench.messages
from bench.messages import OPTICAL, point_cloud, transform

SENSORS, SCENE = 'sensors', 'scene'
# Name: picture size in pixels, focal length, "Frame Rate", place in the map.
CAMERAS = {
    'cam_a': ((640, 480), 500.0, -1, (-3.5, 0.0, 1.6)),
    'cam_b': ((320, 240), 240.0, 10, (-3.0, 2.0, 1.0)),
    'cam_c': ((480, 360), 380.0, 5, (-4.0, -1.5, 2.2)),
}
GLOBAL_RATE_HZ = 20
MESH = 'package://conformance_assets/meshes/cone.stl'
# A frame of TF disappears after that time without a new transform, so that a check need not wait longer.
FRAME_TIMEOUT_S = 3
# The cloud that measures latency: its colour is the time in ms, and it lies in the middle of this camera's picture.
BEACON, BEACON_CAMERA = '/soak/beacon', 'cam_a'

URDF = '''<robot name="soak"><material name="grey"><color rgba="0.6 0.6 0.7 1"/></material>
<link name="base_link"><visual><geometry><box size="0.6 0.4 0.2"/></geometry><material name="grey"/></visual></link>
<link name="upper_arm"><visual><origin xyz="0 0 0.25"/><geometry><cylinder radius="0.06" length="0.5"/></geometry></visual></link>
<link name="lower_arm"><visual><geometry><mesh filename="package://conformance_assets/meshes/cone.stl" scale="0.3 0.3 0.3"/>
</geometry></visual></link>
<joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper_arm"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="5" velocity="1"/></joint>
<joint name="elbow" type="revolute"><parent link="upper_arm"/><child link="lower_arm"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="3" velocity="1"/></joint></robot>'''

# --- the config -------------------------------------------------------------------------------------------------------

CLOUD = 'Queue Size: 10, Position Transformer: XYZ, '
DISPLAYS = collections.OrderedDict([
    ('grid', 'Class: rviz/Grid, Plane Cell Count: 12'),
    ('axes', 'Class: rviz/Axes, Reference Frame: base_link, Length: 0.4, Radius: 0.03'),
    ('frames', 'Class: rviz/TF, Marker Scale: 0.5, Frame Timeout: {}'.format(FRAME_TIMEOUT_S)),
    ('depth', 'Class: rviz/PointCloud2, Topic: /soak/depth, Style: Flat Squares, Size (m): 0.01, Color Transformer: RGB8, ' +
     CLOUD + 'Alpha: 1'),
    ('lidar', 'Class: rviz/PointCloud2, Topic: /soak/lidar, Style: Points, Size (Pixels): 2, Color Transformer: Intensity, ' +
     CLOUD + 'Alpha: 1'),
    ('boxes', 'Class: rviz/PointCloud2, Topic: /soak/boxes, Style: Boxes, Size (m): 0.04, Color Transformer: AxisColor, ' +
     CLOUD + 'Alpha: 1'),
    ('spheres', 'Class: rviz/PointCloud2, Topic: /soak/spheres, Style: Spheres, Size (m): 0.05, Color Transformer: FlatColor, ' +
     CLOUD + 'Color: 90; 160; 255, Alpha: 0.5'),
    ('decaying', 'Class: rviz/PointCloud2, Topic: /soak/decaying, Style: Squares, Size (m): 0.03, Color Transformer: RGB8, ' +
     CLOUD + 'Decay Time: 0.6, Alpha: 0.8'),
    ('beacon', 'Class: rviz/PointCloud2, Topic: /soak/beacon, Style: Flat Squares, Size (m): 0.006, Color Transformer: RGB8, ' +
     CLOUD + 'Alpha: 1'),
    ('legacy', 'Class: rviz/PointCloud, Topic: /soak/legacy, Style: Points, Size (Pixels): 4, Color Transformer: Intensity, ' +
     CLOUD + 'Channel Name: intensity'),
    ('scan', 'Class: rviz/LaserScan, Topic: /soak/scan, Style: Flat Squares, Size (m): 0.03, Color Transformer: Intensity, ' +
     CLOUD),
    ('depth image', 'Class: rviz/DepthCloud, Depth Map Topic: /soak/depth_camera/image, Color Image Topic: "", '
     'Style: Flat Squares, Color Transformer: FlatColor, Auto Size: {Auto Size Factor: 1, Value: true}'),
    ('map', 'Class: rviz/Map, Topic: /soak/map, Alpha: 0.6, Color Scheme: costmap'),
    ('cells', 'Class: rviz/GridCells, Topic: /soak/cells, Color: 90; 30; 160, Alpha: 0.8'),
    ('marker', 'Class: rviz/Marker, Marker Topic: /soak/marker, Queue Size: 100'),
    ('markers', 'Class: rviz/MarkerArray, Marker Topic: /soak/markers, Queue Size: 100'),
    ('handles', 'Class: rviz/InteractiveMarkers, Update Topic: /soak/handles/update, Show Axes: false'),
    ('robot', 'Class: rviz/RobotModel, Robot Description: robot_description'),
    ('effort', 'Class: rviz/Effort, Topic: /soak/joints, Robot Description: robot_description, Width: 0.05'),
    ('path', 'Class: rviz/Path, Topic: /soak/path, Line Style: Billboards, Buffer Length: 2, Pose Style: Arrows'),
    ('odometry', 'Class: rviz/Odometry, Topic: /soak/odometry, Keep: 3'),
    ('pose', 'Class: rviz/Pose, Topic: /soak/pose, Shape: Axes'),
    ('poses', 'Class: rviz/PoseArray, Topic: /soak/poses, Shape: Arrow (3D)'),
    ('uncertain', 'Class: rviz/PoseWithCovariance, Topic: /soak/uncertain'),
    ('points', 'Class: rviz/PointStamped, Topic: /soak/points, History Length: 3, Alpha: 0.7'),
    ('polygon', 'Class: rviz/Polygon, Topic: /soak/polygon'),
    ('range', 'Class: rviz/Range, Topic: /soak/range, Buffer Length: 2'),
    ('wrench', 'Class: rviz/WrenchStamped, Topic: /soak/wrench, History Length: 2'),
    ('twist', 'Class: rviz/TwistStamped, Topic: /soak/twist'),
    ('accel', 'Class: rviz/AccelStamped, Topic: /soak/accel'),
    ('temperature', 'Class: rviz/Temperature, Topic: /soak/temperature, Style: Spheres, Size (m): 0.2'),
    ('pressure', 'Class: rviz/FluidPressure, Topic: /soak/pressure, Style: Boxes, Size (m): 0.2'),
    ('light', 'Class: rviz/Illuminance, Topic: /soak/light, Style: Spheres, Size (m): 0.2'),
    ('humidity', 'Class: rviz/RelativeHumidity, Topic: /soak/humidity, Style: Boxes, Size (m): 0.2'),
    ('window image', 'Class: rviz/Image, Image Topic: /soak/depth_camera/image'),
    ('window camera', 'Class: rviz/Camera, Image Topic: /soak/depth_camera/image'),
])
CAMERA = ('Class: rviz_camera_stream/CameraPub, Name: {name}, Enabled: true, Image Topic: /soak/{name}/image, Camera Info Topic: '
          '/soak/{name}/info, Display namespace: {name}, Frame Rate: {rate}, Image Encoding: rgb8, Background Color: 12; 24; 36, '
          'Near Clip Distance: 0.01, Queue Size: 2, Visibility: {{Value: true, {hidden}}}')


def config(displays=None, cameras=()):
    """The text of the .rviz file. `cameras` are names of more cameras, which look through the first one's lens."""
    text = 'Visualization Manager:\n  Displays:\n'
    displays = DISPLAYS if displays is None else displays
    single = [name for name in displays if name not in ('polygon', 'range')]
    for name in single:
        text += '  - {{Name: {}, Enabled: true, {}}}\n'.format(name, displays[name])
    text += '  - Class: rviz/Group\n    Name: group\n    Enabled: true\n    Displays:\n'
    for name in ('polygon', 'range'):
        text += '    - {{Name: {}, Enabled: true, {}}}\n'.format(name, displays[name])
    hidden = {'cam_a': 'grid: true', 'cam_b': 'depth: false, frames: false', 'cam_c': 'markers: false, beacon: false'}
    for name, (_, _, rate, _) in CAMERAS.items():
        text += '  - {' + CAMERA.format(name=name, rate=rate, hidden=hidden[name]) + '}\n'
    for name in cameras:
        camera = CAMERA.format(name=name, rate=2, hidden='grid: false')
        text += '  - {' + camera.replace('/soak/{}/info'.format(name), '/soak/cam_a/info') + '}\n'
    text += '  Enabled: true\n  Tools:\n  - {Class: rviz/Interact}\n'
    return text + '  Global Options: {{Fixed Frame: map, Frame Rate: {}}}\n'.format(GLOBAL_RATE_HZ)


# --- frames and cameras -----------------------------------------------------------------------------------------------

def static_frames():
    """Cameras and sensors. Optical frames look along x."""
    frames = [transform('map', name, xyz, OPTICAL) for name, (_, _, _, xyz) in CAMERAS.items()]
    frames += [transform('base_link', 'depth_optical', (0.3, 0.0, 0.5), OPTICAL),
               transform('base_link', 'laser', (0.2, 0.0, 0.3))]
    return TFMessage(frames)


def about(axis, angle):
    turn = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    turn[axis] = math.sin(angle / 2)
    return tuple(turn)


def moving_frames(seconds, stamp):
    """The robot that many seconds into its round."""
    return TFMessage([
        transform('map', 'base_link', (0.3 * math.sin(0.5 * seconds), 0.3 * math.cos(0.4 * seconds), 0.1),
                  about(2, 0.3 * math.sin(0.3 * seconds)), stamp),
        transform('base_link', 'upper_arm', (0, 0, 0.1), about(1, 0.8 * math.sin(seconds)), stamp),
        transform('upper_arm', 'lower_arm', (0, 0, 0.5), about(1, math.sin(1.3 * seconds)), stamp),
    ])


def camera_info(name, size_px=None, frame=None):
    """A camera's CameraInfo, of another size or frame if they are given; the view stays the same."""
    size, focal_px, _, _ = CAMERAS[name]
    if size_px:
        focal_px *= size_px[0] / size[0]
    return bench.messages.camera_info(frame or name, size_px or size, focal_px)


# --- messages ---------------------------------------------------------------------------------------------------------

def stamped(message, stamp, frame):
    message.header.stamp, message.header.frame_id = stamp, frame
    return message


def cloud(xyz, value, name, stamp, frame):
    """A PointCloud2 of points with one more field."""
    data = numpy.zeros(len(xyz), [('xyz', '<f4', 3), ('value', '<u4' if name == 'rgb' else '<f4')])
    data['xyz'], data['value'] = xyz, value
    return point_cloud(len(xyz), name, frame, stamp, data.tobytes())


def depth(rng, stamp):
    u, v = numpy.meshgrid(numpy.linspace(-0.5, 0.5, 160), numpy.linspace(-0.4, 0.4, 120))
    z = 2.5 + 0.3 * numpy.sin(9 * u + rng.uniform(0, 6)) * numpy.cos(9 * v)
    xyz = numpy.stack([u * z, v * z, z], axis=-1).reshape(-1, 3)
    return cloud(xyz, (z.ravel() * 6e6).astype('<u4') & 0xffffff, 'rgb', stamp, 'depth_optical')


def ball(rng, count, centre, size):
    return rng.normal(0, size, (count, 3)) + numpy.array(centre) + rng.uniform(-0.2, 0.2, 3)


def lidar(rng, stamp):
    angle = rng.uniform(0, 2 * math.pi, 10000)
    xyz = numpy.stack([4 * numpy.cos(angle), 4 * numpy.sin(angle), rng.uniform(-0.3, 1.5, 10000)], axis=-1)
    return cloud(xyz, numpy.abs(angle), 'intensity', stamp, 'laser')


def boxes(rng, stamp):
    return cloud(ball(rng, 1500, (2, 1.5, 0.5), 0.3), 0, 'rgb', stamp, 'map')


def spheres(rng, stamp):
    return cloud(ball(rng, 800, (1.5, -1.5, 0.6), 0.3), 0, 'rgb', stamp, 'map')


def decaying(rng, stamp):
    return cloud(ball(rng, 500, (1, 0, 1.5), 0.2), rng.integers(1 << 24), 'rgb', stamp, 'map')


def beacon(rng, stamp):
    del rng
    colour = int(time.monotonic() * 1000) & 0xffffff if stamp.is_zero() else 0x10ff80
    return cloud([(0, 0, 0.3)], colour, 'rgb', stamp, BEACON_CAMERA)


def legacy(rng, stamp):
    xyz = ball(rng, 200, (0, 2, 0.5), 0.3)
    points = [Point32(*point) for point in xyz.tolist()]
    return stamped(PointCloud(points=points, channels=[ChannelFloat32('intensity', xyz[:, 2].tolist())]), stamp, 'map')


def scan(rng, stamp):
    ranges = (3 + 0.5 * numpy.sin(numpy.linspace(0, 12, 720) + rng.uniform(0, 6))).tolist()
    return stamped(LaserScan(angle_min=-2, angle_max=2, angle_increment=4 / 719, range_min=0.1, range_max=20, ranges=ranges,
                             intensities=ranges), stamp, 'laser')


def depth_image(rng, stamp):
    rows, columns = numpy.mgrid[0:60, 0:80]
    data = (1500 + 300 * numpy.sin(rows / 9 + rng.uniform(0, 6)) + 3 * columns).astype('<u2')
    return stamped(Image(height=60, width=80, encoding='16UC1', step=160, data=data.tobytes()), stamp, 'depth_optical')


def depth_info(rng, stamp):
    del rng
    message = CameraInfo(width=80, height=60, K=[70, 0, 40, 0, 70, 30, 0, 0, 1], R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                         P=[70, 0, 40, 0, 0, 70, 30, 0, 0, 0, 1, 0])
    return stamped(message, stamp, 'depth_optical')


def pose(rng, into=None):
    """A random pose in front of the cameras, which may be written into a message."""
    into = into or PoseStamped().pose
    into.position = Point(*rng.uniform((-0.5, -2, 0), (3, 2, 1.2)).tolist())
    into.orientation.z, into.orientation.w = about(2, rng.uniform(-3, 3))[2:]
    return into


def occupancy(rng, stamp):
    message = OccupancyGrid(data=numpy.repeat(rng.integers(-1, 101, 100), 100).astype('i1').tolist())
    message.info.width, message.info.height, message.info.resolution = 100, 100, 0.08
    message.info.origin.position = Point(-2, -4, -0.02)
    message.info.origin.orientation.w = 1
    return stamped(message, stamp, 'map')


def occupancy_update(rng, stamp):
    x, y = (int(value) for value in rng.integers(0, 80, 2))
    message = OccupancyGridUpdate(x=x, y=y, width=20, height=20, data=[int(rng.integers(0, 101))] * 400)
    return stamped(message, stamp, 'map')


def cells(rng, stamp):
    message = GridCells(cell_width=0.2, cell_height=0.2, cells=[pose(rng).position for _ in range(30)])
    return stamped(message, stamp, 'map')


def marker(rng, stamp, namespace='shapes', number=None):
    message = Marker(ns=namespace, id=int(rng.integers(12)) if number is None else number, type=int(rng.integers(12)))
    pose(rng, message.pose)
    message.scale.x, message.scale.y, message.scale.z = rng.uniform(0.05, 0.3, 3).tolist()
    colour = message.color
    colour.r, colour.g, colour.b, colour.a = rng.uniform(0.3, 1, 4).tolist()
    if message.type in (Marker.LINE_STRIP, Marker.LINE_LIST, Marker.CUBE_LIST, Marker.SPHERE_LIST, Marker.POINTS,
                        Marker.TRIANGLE_LIST):
        message.points = [Point(*point) for point in rng.uniform(-0.5, 0.5, (12, 3)).tolist()]
    if message.type == Marker.TEXT_VIEW_FACING:
        message.text = 'marker {}'.format(message.id)
    if message.type == Marker.MESH_RESOURCE:
        message.mesh_resource = MESH
    return stamped(message, stamp, 'map')


def marker_array(rng, stamp):
    """Additions, some for a short while, and deletions."""
    markers = [marker(rng, stamp, 'array', int(rng.integers(60))) for _ in range(8)]
    for one in markers:
        one.lifetime = rospy.Duration(float(rng.choice([0, 0.5, 3])))
        one.action = Marker.DELETE if rng.random() < 0.25 else Marker.ADD
    return MarkerArray(markers)


def handle(rng, stamp, number):
    message = InteractiveMarker(name='handle {}'.format(number), description='handle {}'.format(number), scale=0.4)
    pose(rng, message.pose)
    for orientation, mode in (((0, 0, 0, 1), InteractiveMarkerControl.MOVE_AXIS),
                              ((0, 0, 1, 1), InteractiveMarkerControl.ROTATE_AXIS)):
        control = InteractiveMarkerControl(name='c', interaction_mode=mode, always_visible=True)
        turn = control.orientation
        turn.x, turn.y, turn.z, turn.w = orientation
        message.controls.append(control)
    return stamped(message, stamp, 'map')


def joints(rng, stamp):
    return stamped(JointState(name=['shoulder', 'elbow'], position=[0, 0], effort=rng.uniform(-3, 3, 2).tolist()), stamp, '')


def path(rng, stamp):
    message = Path(poses=[PoseStamped() for _ in range(10)])
    start, turn = rng.uniform(-1, 1), rng.uniform(-0.5, 0.5)
    for i, one in enumerate(message.poses):
        one.header.frame_id, one.header.stamp = 'map', stamp
        one.pose.position = Point(0.25 * i, start + turn * i * 0.2, 0.05)
        one.pose.orientation.w = 1
    return stamped(message, stamp, 'map')


def covariance(rng):
    values = numpy.diag(rng.uniform(0.01, 0.1, 6))
    return values.ravel().tolist()


def odometry(rng, stamp):
    message = Odometry(child_frame_id='base_link')
    pose(rng, message.pose.pose)
    message.pose.covariance = covariance(rng)
    return stamped(message, stamp, 'map')


def uncertain(rng, stamp):
    message = PoseWithCovarianceStamped()
    pose(rng, message.pose.pose)
    message.pose.covariance = covariance(rng)
    return stamped(message, stamp, 'map')


def vectors(kind, first, second):
    """A message of two vectors at the robot."""
    def make(rng, stamp):
        message = kind()
        body = getattr(message, kind.__slots__[1])
        for name in (first, second):
            vector = getattr(body, name)
            vector.x, vector.y, vector.z = rng.uniform(-1, 1, 3).tolist()
        return stamped(message, stamp, 'base_link')
    return make


def scalar(kind, field, low, high):
    def make(rng, stamp):
        return stamped(kind(**{field: rng.uniform(low, high)}), stamp, 'laser')
    return make


def point(rng, stamp):
    return stamped(PointStamped(point=pose(rng).position), stamp, 'map')


def polygon(rng, stamp):
    message = PolygonStamped()
    message.polygon.points = [Point32(*corner) for corner in rng.uniform((-1, -2, 0), (2, 2, 1), (6, 3)).tolist()]
    return stamped(message, stamp, 'map')


def one_pose(rng, stamp):
    return stamped(PoseStamped(pose=pose(rng)), stamp, 'map')


def some_poses(rng, stamp):
    return stamped(PoseArray(poses=[pose(rng) for _ in range(30)]), stamp, 'map')


def distance(rng, stamp):
    return stamped(Range(field_of_view=0.5, min_range=0.1, max_range=4, range=rng.uniform(0.5, 2)), stamp, 'laser')


# --- topics -----------------------------------------------------------------------------------------------------------

# Who publishes it, how often in Hz, and how many messages fill what the display keeps.
Source = collections.namedtuple('Source', 'topic kind make group hz count latch', defaults=(1, False))

SOURCES = [
    Source('/soak/depth', PointCloud2, depth, SENSORS, 10),
    Source('/soak/lidar', PointCloud2, lidar, SENSORS, 8),
    Source('/soak/boxes', PointCloud2, boxes, SENSORS, 2),
    Source('/soak/spheres', PointCloud2, spheres, SENSORS, 2),
    # It decays while a check waits for it, and so publishes none.
    Source('/soak/decaying', PointCloud2, decaying, SENSORS, 4, 0),
    Source(BEACON, PointCloud2, beacon, SENSORS, 15),
    Source('/soak/legacy', PointCloud, legacy, SENSORS, 1),
    Source('/soak/scan', LaserScan, scan, SENSORS, 12),
    Source('/soak/depth_camera/camera_info', CameraInfo, depth_info, SENSORS, 2),
    Source('/soak/depth_camera/image', Image, depth_image, SENSORS, 4),
    Source('/soak/map', OccupancyGrid, occupancy, SCENE, 0.2, 1, True),
    Source('/soak/cells', GridCells, cells, SCENE, 1),
    Source('/soak/marker', Marker, marker, SCENE, 8, 6),
    Source('/soak/markers', MarkerArray, marker_array, SCENE, 5),
    Source('/soak/joints', JointState, joints, SCENE, 10),
    Source('/soak/path', Path, path, SCENE, 1, 2),
    Source('/soak/odometry', Odometry, odometry, SCENE, 5, 4),
    Source('/soak/pose', PoseStamped, one_pose, SCENE, 2),
    Source('/soak/poses', PoseArray, some_poses, SCENE, 2),
    Source('/soak/uncertain', PoseWithCovarianceStamped, uncertain, SCENE, 2),
    Source('/soak/points', PointStamped, point, SCENE, 2, 3),
    Source('/soak/polygon', PolygonStamped, polygon, SCENE, 1),
    Source('/soak/range', Range, distance, SCENE, 5, 2),
    Source('/soak/wrench', WrenchStamped, vectors(WrenchStamped, 'force', 'torque'), SCENE, 3, 2),
    Source('/soak/twist', TwistStamped, vectors(TwistStamped, 'linear', 'angular'), SCENE, 3),
    Source('/soak/accel', AccelStamped, vectors(AccelStamped, 'linear', 'angular'), SCENE, 3),
    Source('/soak/temperature', Temperature, scalar(Temperature, 'temperature', 0, 100), SCENE, 1),
    Source('/soak/pressure', FluidPressure, scalar(FluidPressure, 'fluid_pressure', 98000, 105000), SCENE, 1),
    Source('/soak/light', Illuminance, scalar(Illuminance, 'illuminance', 0, 1000), SCENE, 1),
    Source('/soak/humidity', RelativeHumidity, scalar(RelativeHumidity, 'relative_humidity', 0, 1), SCENE, 1),
    # Updates of the map, so that they come after it.
    Source('/soak/map_updates', OccupancyGridUpdate, occupancy_update, SCENE, 2),
]
HANDLES = '/soak/handles/update'


class Handles:
    """A server of interactive markers: its messages have consecutive numbers."""

    def __init__(self, server):
        self.server, self.number, self.shown = server, 0, {}

    def init(self):
        return InteractiveMarkerInit(server_id=self.server, seq_num=self.number, markers=list(self.shown.values()))

    def keep_alive(self):
        return InteractiveMarkerUpdate(server_id=self.server, seq_num=self.number, type=InteractiveMarkerUpdate.KEEP_ALIVE)

    def update(self, rng, stamp, is_check=False):
        """One of three handles is added, moved or erased; for a check, all are replaced."""
        self.number += 1
        message = InteractiveMarkerUpdate(server_id=self.server, seq_num=self.number, type=InteractiveMarkerUpdate.UPDATE)
        numbers = range(3) if is_check else [int(rng.integers(3))]
        for number in numbers:
            new = handle(rng, stamp, number)
            if is_check or new.name not in self.shown or rng.random() < 0.3:
                message.markers.append(new)
                self.shown[new.name] = new
            elif rng.random() < 0.3:
                message.erases.append(new.name)
                del self.shown[new.name]
            else:
                moved = InteractiveMarkerPose(name=new.name, pose=new.pose, header=new.header)
                self.shown[new.name].pose = new.pose
                message.poses.append(moved)
        return message


def generator(seed, topic):
    """The random generator of a topic."""
    return numpy.random.default_rng([seed] + list(topic.encode()))


def check_messages(source, seed, stamp):
    """The messages of an image check on a topic."""
    rng = generator(seed, source.topic)
    if source.kind is MarkerArray:
        first = Marker(action=3)
        first.header.frame_id = 'map'
        markers = [marker(rng, stamp, 'array', number) for number in range(12)]
        return [MarkerArray([first] + markers)]
    messages = [source.make(rng, stamp) for _ in range(source.count)]
    if source.kind is Marker:
        first = Marker(action=3)
        first.header.frame_id = 'map'
        messages = [first] + messages
    if source.kind is Odometry:
        # Further apart than what the display takes for the same place.
        for number, message in enumerate(messages):
            message.pose.pose.position.x = -0.5 + number
    return messages
