"""A scene that rviz and `camera_stream` draw side by side: loaded, played step by step, watched."""

import time

import rospy
from golden.scenes.processes import Program, wait_until
from golden.scenes.recorder import PASSING_SUBSCRIPTION, picture_of
from sensor_msgs.msg import Image

from .config_service import load_config
from .stage import RVIZ

PATIENCE_SECS = 300.0
# Pictures after which what was sent is drawn: the first may have been begun before.
PICTURES = 2
# How many equal pictures, and for how long, make one that stands still.
STILL_PICTURES, STILL_SECS = 4, 0.4


class Watch:
    """The last picture of a topic, how many came, and how many and since when they have been the same."""

    def __init__(self, topic):
        self.count, self.wanted, self.same_count, self.same_since, self.last = 0, 0, 0, time.monotonic(), None
        self.subscriber = rospy.Subscriber(topic, Image, self.see, queue_size=2, buff_size=1 << 24)

    def see(self, image):
        self.count += 1
        last = self.last
        if last is not None and (last.width, last.encoding, last.data) == (image.width, image.encoding, image.data):
            self.same_count += 1
        else:
            self.same_count, self.same_since = 1, time.monotonic()
        self.last = image

    def stands_still(self):
        return self.same_count >= STILL_PICTURES and time.monotonic() - self.same_since >= STILL_SECS

    def pixels(self):
        return picture_of(self.last).pixels


class Performance:
    """A scene on a stage, from the loading of its config until its pictures stand still."""

    def __init__(self, live, scene):
        self.live, self.scene = live, scene
        self.programs, self.publishers, self.watches = [], {}, {}

    def __enter__(self):
        try:
            self.load()
        except BaseException:
            self.__exit__()
            raise
        return self

    def load(self):
        """Starts the programs with the scene's config and connects all topics."""
        live, scene = self.live, self.scene
        live.ready_rviz()
        live.scenes_of_rviz += 1
        live.set_time(scene.times[0])
        for name, text in scene.parameters.items():
            live.stage.set_parameter(name, text)
        config = live.folder / 'scene.rviz'
        config.write_text(scene.config)
        self.watch(live.renderers)
        for renderer in live.renderers:
            self.programs.append(self.start_node(renderer, config))
        if not load_config(RVIZ, config):
            raise RuntimeError(f'rviz does not load {config}: {live.rviz.log}')
        self.programs.append(live.rviz)
        # rviz advertises a picture's topic anew while it loads, which can leave a subscriber without its connection.
        self.watch([RVIZ])
        self.connect()

    def watch(self, drawers):
        for camera in self.scene.cameras:
            for drawer in drawers:
                self.watches[drawer, camera.name] = Watch(topic_of(camera, drawer))

    def start_node(self, renderer, config):
        live = self.live
        remaps = []
        for camera in self.scene.cameras:
            namespace = camera.display['Display namespace']
            remaps += [f'{camera.image_topic}:={topic_of(camera, renderer)}',
                       f'/{namespace}/camera_trigger:=/{namespace}/{renderer}/camera_trigger']
        command = [str(live.camera_stream), '-d', str(config), '--renderer', renderer, f'__name:={renderer}', *remaps]
        return Program(command, live.stage.environment, live.folder / f'{renderer}.log')

    def connect(self):
        """Publishers of all topics, connected to their subscribers. camera_stream has to want what rviz does."""
        types = {topic: type(message) for step in self.scene.steps for topic, message in step}
        types['/tf'] = type(self.scene.transforms(0))
        wanted = {}
        wait_until(lambda: self.all_subscribe(types, wanted), PATIENCE_SECS,
                   'camera_stream does not subscribe to what rviz does', self.programs)
        for topic, kind in types.items():
            self.publishers[topic] = rospy.Publisher(topic, kind, latch=topic != '/tf', queue_size=100)
        for topic, publisher in self.publishers.items():
            wait_until(lambda publisher=publisher, nodes=wanted[topic]: nodes <= connected(publisher), PATIENCE_SECS,
                       f'{topic} has not connected to {wanted[topic]}', self.programs)

    def all_subscribe(self, topics, wanted):
        """Whether all nodes have subscribed to what rviz has. `wanted` becomes the subscribers of each topic."""
        subscribers = dict(self.live.stage.system_state()[1])
        for topic, kind in topics.items():
            wanted[topic] = set() if kind._type in PASSING_SUBSCRIPTION else set(subscribers.get(topic, []))
        nodes = {f'/{renderer}' for renderer in self.live.renderers}
        return all(nodes <= wanted[topic] for topic in topics if f'/{RVIZ}' in wanted[topic])

    def play(self):
        """Publishes the messages of all steps, each when those before it are drawn."""
        scene = self.scene
        for step, time_secs in enumerate(scene.times):
            self.live.set_time(time_secs)
            self.publishers['/tf'].publish(scene.transforms(step))
            # Before all others: without them there are no pictures to wait for, and rviz drops depth images.
            self.publish(message for message in scene.steps[step] if is_info(message))
            if step == 0 or scene.transforms_first:
                # rviz loses a message without stamp that comes before the first transform.
                self.wait_for_pictures()
            self.publish(message for message in scene.steps[step] if not is_info(message))
            self.wait_for_pictures()
        self.live.set_time(scene.end_secs)
        self.wait_for_pictures()

    def publish(self, messages):
        for topic, message in messages:
            self.publishers[topic].publish(message)

    def wait_for_pictures(self):
        """Waits until each camera of each program shows what was sent."""
        for watch in self.watches.values():
            watch.wanted = watch.count + PICTURES
        for (drawer, camera), watch in self.watches.items():
            wait_until(lambda watch=watch: watch.count >= watch.wanted, PATIENCE_SECS,
                       f'{drawer} publishes no pictures of {camera}', self.programs)

    def picture(self, drawer, camera):
        """The last picture of a camera, height × width (× RGB)."""
        return self.watches[drawer, camera.name].pixels()

    def stands_still(self):
        return all(watch.stands_still() for watch in self.watches.values())

    def __exit__(self, *_):
        for publisher in self.publishers.values():
            publisher.unregister()
        for watch in self.watches.values():
            watch.subscriber.unregister()
        for program in self.programs:
            if program is not self.live.rviz:
                program.end()
        for name in self.scene.parameters:
            self.live.stage.delete_parameter(name)


def is_info(published):
    _, message = published
    return message._type == 'sensor_msgs/CameraInfo'


def topic_of(camera, drawer):
    """Where a program publishes the camera's picture."""
    return camera.image_topic if drawer == RVIZ else camera.image_topic.replace('/image', f'/{drawer}/image')


def connected(publisher):
    """The names of the nodes that are connected to a publisher."""
    return {connection.endpoint_id for connection in list(publisher.impl.connections)}
