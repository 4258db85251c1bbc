"""The sample scene on a master of its own: projector, clouds, path, and `camera_stream` with the operator's page."""

import os
import pathlib
import re
import shutil
import sys
import threading

import numpy

from golden.scenes.processes import Program, free_port, wait_until
from golden.scenes.rviz_runner import Stage

from .browser import PATIENCE_SECS

ROOT = pathlib.Path(__file__).parents[2]
PROGRAMS = pathlib.Path(os.environ.get('CARGO_TARGET_DIR', ROOT / 'target')) / 'release'
IMAGE = '/proj_view/image'
NODE = '/camera_stream'
CAMERA = f'{NODE}/CameraPub'
OPTICAL_FRAME = 'proj_view'
BASE_FRAME = 'base_link'
TEST_NODE = '/experiment'


class LiveScene:
    """The running scene. A process can have one only, because it is a node of that scene's master."""

    def __init__(self, folder):
        """folder: for logs, the projector's file and the mask; must be this scene's own."""
        self.folder = pathlib.Path(folder)
        self.stage = Stage(self.folder)
        self.programs = {}
        self.projector_file = self.folder / 'projector.yaml'
        shutil.copy(ROOT / 'config/projector.yaml', self.projector_file)
        self.config = self.folder / 'projection.rviz'
        shutil.copy(ROOT / 'rviz/projection.rviz', self.config)
        self._write_mask()
        self.port = free_port()
        try:
            self._start_all()
        except BaseException:
            self.end()
            raise

    def _start_all(self):
        self.start('projector', self.projector_file)
        for cloud in ('clusters', 'desired_object'):
            self.start('publish_cloud', ROOT / f'config/demo/{cloud}.pcd', '--frame', BASE_FRAME, '--topic', f'/widget/{cloud}',
                       '--rate', '1', f'__name:={cloud}', name=cloud)
        self._run('path', ['rostopic', 'pub', '-l', '-f', ROOT / 'config/demo/path.yaml', '/move_base/NavfnROS/plan',
                           'nav_msgs/Path'])
        self.start_camera_stream()
        os.environ.update({name: self.stage.environment[name] for name in ('ROS_MASTER_URI', 'ROS_HOME', 'ROS_HOSTNAME')})
        import rospy
        rospy.init_node(TEST_NODE.lstrip('/'), disable_signals=True, disable_rosout=True)
        self.images, self.transforms, self.cues = Images(), Transforms(), Cues()

    def _run(self, name, command):
        self.programs[name] = Program([str(part) for part in command], self.stage.environment, self.folder / f'{name}.log')

    def start(self, program, *arguments, name=None):
        """Starts one of the project's programs."""
        self._run(name or program, [PROGRAMS / program, *arguments])

    def start_camera_stream(self):
        """Starts the node and waits until it has printed where its page is; returns that address, with the token."""
        self.start('camera_stream', '-d', self.config, '--renderer', 'cpu', '--projection', 'exact',
                   '--mask', self.folder / 'mask.png', '--web', self.port)
        node = self.programs['camera_stream']
        pattern = re.compile(rf'http://[^\s/]+:{self.port}/#token=\S+')
        found = wait_until(lambda: pattern.search(node.log.read_text(errors='replace')), PATIENCE_SECS,
                           'camera_stream prints no address', [node])
        self.address = found.group()
        return self.address

    def end_camera_stream(self):
        self.programs.pop('camera_stream').end()

    def end(self):
        if 'rospy' in sys.modules:
            sys.modules['rospy'].signal_shutdown('the tests have ended')
        for program in self.programs.values():
            program.end()
        self.stage.end()

    def wait_for(self, condition, what):
        """Waits until the condition is true and returns its value; fails when one of the scene's programs ends."""
        return wait_until(condition, PATIENCE_SECS, what, list(self.programs.values()))

    def parameter(self, name):
        """A parameter of the camera, as dynamic_reconfigure keeps it on the parameter server."""
        import rospy
        return rospy.get_param(f'{CAMERA}/{name}')

    def setting(self, name):
        """A parameter of all cameras, as dynamic_reconfigure keeps it on the parameter server."""
        import rospy
        return rospy.get_param(f'{NODE}/{name}')

    def call(self, service, kind, *arguments):
        """Calls a service of the node as an experiment's script does."""
        import rospy
        rospy.wait_for_service(service, PATIENCE_SECS)
        return rospy.ServiceProxy(service, kind)(*arguments)

    def _write_mask(self):
        from PIL import Image
        mask = numpy.full((800, 1280), 255, numpy.uint8)
        mask[:120, 960:] = 0
        Image.fromarray(mask).save(self.folder / 'mask.png')


class Images:
    """The newest image of the camera as height × width × 3 numbers; none before the first."""

    def __init__(self):
        import rospy
        from sensor_msgs.msg import Image
        self.newest, self.count = None, 0
        self._subscriber = rospy.Subscriber(IMAGE, Image, self._receive, queue_size=2, buff_size=1 << 24)

    def _receive(self, message):
        self.newest = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.width, 3)
        self.count += 1

    def is_black(self):
        return self.newest is not None and not self.newest.any()

    def is_lit(self):
        return self.newest is not None and bool(self.newest.any())


class Cues:
    """The names of the cues that were shown, the newest last, and a publisher that asks for one."""

    def __init__(self):
        import rospy
        from std_msgs.msg import String
        self.names = []
        self._subscriber = rospy.Subscriber(f'{NODE}/cue', String, lambda message: self.names.append(message.data))
        self._publisher = rospy.Publisher(f'{NODE}/set_cue', String, queue_size=10)

    def ask(self, name):
        wait_until(self._publisher.get_num_connections, PATIENCE_SECS, 'nobody subscribes to set_cue')
        self._publisher.publish(name)


class Transforms:
    """The static transforms that are published."""

    def __init__(self):
        import rospy
        from tf2_msgs.msg import TFMessage
        self._lock, self._parents = threading.Lock(), {}
        self._subscriber = rospy.Subscriber('/tf_static', TFMessage, self._receive, queue_size=10)

    def _receive(self, message):
        with self._lock:
            for stamped in message.transforms:
                move, turn = stamped.transform.translation, stamped.transform.rotation
                placed = pose([move.x, move.y, move.z], [turn.x, turn.y, turn.z, turn.w])
                self._parents[stamped.child_frame_id] = (stamped.header.frame_id, placed)

    def projector(self):
        """The pose of the projector's optical frame as a matrix of 4 × 4; none before it is known."""
        with self._lock:
            frame, placed = OPTICAL_FRAME, numpy.eye(4)
            while frame != BASE_FRAME:
                if frame not in self._parents:
                    return None
                frame, parent = self._parents[frame]
                placed = parent @ placed
            return placed


def pose(translation, quaternion):
    """The matrix of 4 × 4 of a translation and a rotation (x, y, z, w)."""
    x, y, z, w = quaternion
    placed = numpy.eye(4)
    placed[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    placed[:3, 3] = translation
    return placed


def pose_of_frame(frame):
    """The matrix of an entry of `frames` in a projector's file: translation, and rotation as roll, pitch, yaw."""
    roll, pitch, yaw = frame['rotation_rpy']
    placed = turned('z', yaw) @ turned('y', pitch) @ turned('x', roll)
    placed[:3, 3] = frame['translation']
    return placed


def turned(axis, angle):
    """A rotation about an axis in radians."""
    half = angle / 2
    quaternion = [numpy.sin(half) if name == axis else 0 for name in 'xyz'] + [numpy.cos(half)]
    return pose([0, 0, 0], quaternion)


def moved(x=0.0, y=0.0, z=0.0):
    """A translation in metres."""
    return pose([x, y, z], [0, 0, 0, 1])
