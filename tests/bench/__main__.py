"""Measures running virtual cameras from outside and writes the tables of docs/explanation/performance.md and README.md.

`./bench` runs it after building; `--programs` is the folder of camera_stream. It starts its own ROS master. `arguments` parses
the arguments, `probe` publishes the clouds and receives the pictures, `light` and `blackout` watch a screen, `pages` opens
operator's pages, `page` writes the tables. The sections:

    styles    a depth camera's cloud in each style
    points    Flat Squares by the number of points
    sizes     the same cloud by picture size
    cameras   one, two and four cameras on the same scene
    lens      with and without allowing for the projector's distortion
    compressed  the load and delay of compressed pictures, beside raw ones
    idle      the load while nothing changes, or nobody subscribes
    starts    from process start to the first picture, and to the end of `render`
    light     to the pixel on an X server's screen, through a topic and a window, and through the node's own window
    blackout  from the call of `~blackout` to a black screen, under load
    pages     with none, one and twenty operator's pages open
    plugin    rviz with CameraPub in it, and with a camera that works as the plugin before it did

In styles, points, idle and light rviz is measured for comparison, if it is installed with a plugin that has the class
rviz_camera_stream/CameraPub; with several cameras only where it draws on a GPU. `drivers` finds out whether it does.
"""

import collections
import contextlib
import itertools
import math
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

import rosgraph
import rospy

from golden.scenes.processes import free_port

from . import arguments, blackout, drivers, light, page, pages, plugin
from .arguments import DEPTH_CAMERA_POINTS, SECTIONS
from .drivers import AUTO, GPU, RVIZ, RVIZ_GPU
from .probe import (
    Compressed, INFO, NEWEST, ONE_BY_ONE, SIZE_PX, PlainClouds, Probe, Program, STREAM, SerializedCloud, Usage, picture_topic)

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
STYLES = ['Flat Squares', 'Points', 'Spheres', 'Boxes']
SIZES_PX = [(640, 480), (1280, 800), (1920, 1080), (3840, 2160)]
CAMERAS = [1, 2, 4]
# The projector's D in the section lens, which moves the corners of its picture by some ten pixels.
DISTORTION = [-0.12, 0.02, 0.0005, -0.001, 0.0]
# At full speed: more pictures a second than that are not measured.
FULL_SPEED_HZ = 120
# What draws with a software driver is not measured with more points than this.
MOST_POINTS_ON_SOFTWARE = 10 ** 6
# `auto` compares its renderers by fewer images than this.
COMPARED = 24

CONFIG = """Visualization Manager:
  Displays:
  - {{Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: {cloud}, Style: {style}, Size (Pixels): 3,
     Size (m): 0.004, Alpha: 1, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Decay Time: 0}}
{cameras}
  Global Options: {{Fixed Frame: base, Frame Rate: {repeat_hz}, Background Color: 48; 48; 48}}
  Views: {{Current: {{Class: rviz/Orbit, Name: Current View}}}}
  Tools: [{{Class: rviz/MoveCamera}}]
Window Geometry: {{Width: 800, Height: 500}}
"""
CAMERA = """  - {{Class: rviz_camera_stream/CameraPub, Name: camera{number}, Enabled: true, Image Topic: {image},
     Camera Info Topic: {info}, Display namespace: camera{number}, Frame Rate: -1, Image Encoding: rgb8,
     Background Color: 0; 0; 0, Near Clip Distance: 0.01, Queue Size: 2, Visibility: {{Value: true}}}}"""

# A program under test: its name in the tables, and the start of its command line.
Camera = collections.namedtuple('Camera', 'name command')


def config(topic, style='Flat Squares', cameras=1, repeat_hz=30):
    """An .rviz file; in the long run at most repeat_hz pictures a second, and an unchanged one about as often."""
    displays = [CAMERA.format(number=number, image=picture_topic(number), info=INFO) for number in range(cameras)]
    return CONFIG.format(cloud=topic, style=style, cameras='\n'.join(displays), repeat_hz=repeat_hz)


def has_camera_plugin():
    """Whether rviz finds a plugin with the CameraPub class."""
    if not shutil.which('rviz') or not shutil.which('rospack'):
        return False
    found = subprocess.run(['rospack', 'plugins', '--attrib=plugin', 'rviz'], stdout=subprocess.PIPE, universal_newlines=True)
    for line in found.stdout.splitlines():
        try:
            tree = xml.etree.ElementTree.parse(line.split(None, 1)[1])
        except (IndexError, OSError, xml.etree.ElementTree.ParseError):
            continue
        if any(one.get('name') == 'rviz_camera_stream/CameraPub' for one in tree.iter('class')):
            return True
    return False


def programs(given):
    """The programs under test: the camera with each renderer, and rviz where it can be compared."""
    camera_stream = os.path.join(given.programs, 'camera_stream')
    cameras = [Camera('camera_stream, ' + renderer, [camera_stream, '--renderer', renderer]) for renderer in given.renderers]
    return cameras, [Camera(RVIZ, ['rviz', '--splash-screen', ''])] if has_camera_plugin() else []


class Bench:
    """Runs the programs one after the other. Each section is a method that returns its rows; a row maps names to figures."""

    def __init__(self, given, folder):
        self.given, self.folder, self.log = given, folder, os.path.join(folder, 'programs.log')
        self.cameras, self.rviz = programs(given)
        self.probe = Probe()

    def find_drivers(self):
        """Finds the drivers of the programs, and leaves out those that have none, or with `auto` no GPU to choose."""
        opengl = None
        for number, rviz in enumerate(self.rviz):
            command, opengl = drivers.rviz_on_gpu(rviz.command, self.folder)
            self.rviz[number] = Camera(RVIZ_GPU if drivers.is_hardware(opengl) else RVIZ, command)
        gpu = drivers.adapter(self.cameras[0].command[0], self.write_config(config(NEWEST)), self.folder)
        self.given.drivers = drivers.Drivers(gpu, opengl)
        left_out = [] if drivers.is_hardware(gpu) else [AUTO] if gpu else [AUTO, GPU]
        self.cameras = [camera for camera in self.cameras if camera.name not in left_out]
        print('drivers: {} of the GPU renderer, {} of rviz'.format(*self.given.drivers), flush=True)

    def write_config(self, text):
        """A file with this config."""
        file = os.path.join(self.folder, 'bench.rviz')
        with open(file, 'w') as out:
            out.write(text)
        return file

    @contextlib.contextmanager
    def running(self, camera, text, count=1):
        """Runs a program with this config; yields, once the first picture arrives, its usage and the time that took in ms."""
        file = self.write_config(text)
        self.probe.send(0)
        self.probe.listen([picture_topic(number) for number in range(count)])
        begin = time.monotonic()
        with Program(camera.command + ['-d', file], self.log) as process:
            if not self.probe.wait_for_picture(60):
                sys.exit('bench: {} published no picture; its log: {}'.format(camera.name, self.log))
            first_ms = 1000 * (self.probe.arrivals[0] - begin)
            until = begin + 60
            while camera.name == AUTO and len(self.probe.arrivals) < COMPARED * count and time.monotonic() < until:
                self.probe.send_some(None, 0.2)
            yield Usage(process.pid), first_ms
            self.probe.listen([])
        self.probe.wait_for_disconnection()

    def measure(self, hz, usage, seconds):
        """The figures at a rate. Where most clouds were missed, latency and cost are measured one cloud at a time."""
        figures = dict(self.probe.measure(hz, seconds, usage), mark='')
        if 2 * figures['missed'] > figures['clouds']:
            # The first run's few latencies are dropped: colours recur, so another cloud's image may have matched.
            slowly = self.probe.measure(None, seconds, usage, window=1)
            figures.update({key: slowly[key] for key in ('latency_ms', 'latency_p95_ms', 'cpu_per_cloud_ms')}, mark='†')
        return figures

    def row(self, camera, figures, **more):
        row = dict(figures, name=camera.name, **more)
        shown = ['{} {:.1f}'.format(key, value) if isinstance(value, float) else '{} {}'.format(key, value)
                 for key, value in sorted(row.items()) if key not in ('name', 'mark')]
        print('{}: {}'.format(camera.name, ', '.join(shown)), flush=True)
        return row

    def draws_with_software(self, camera):
        """Whether it draws with a software driver of OpenGL or Vulkan."""
        return camera.name == RVIZ or camera.name == GPU and not drivers.is_hardware(self.given.drivers.gpu)

    def by_program(self, rows):
        names = [camera.name for camera in self.cameras + self.rviz]
        return sorted(rows, key=lambda row: names.index(row['name']))

    def styles(self):
        cloud = PlainClouds(DEPTH_CAMERA_POINTS)
        floor = self.probe.floor(NEWEST, cloud, 5, self.given.seconds)
        rows = []
        for camera in self.cameras + self.rviz:
            for style in STYLES:
                with self.running(camera, config(NEWEST, style)) as (usage, first_ms):
                    figures = self.measure(self.given.hz, usage, self.given.seconds)
                    rows.append(self.row(camera, figures, style=style, first_ms=first_ms))
        return {'floor': floor, 'rows': rows}

    def points(self):
        rows, floors, seconds = [], {}, self.given.sweep_seconds
        for points in self.given.points:
            cloud, hz = SerializedCloud(points), min(5.0, 1e7 / points)
            floor = self.probe.floor(ONE_BY_ONE, cloud, hz, max(seconds, 8 / hz))
            floor['full_hz'] = self.probe.floor(ONE_BY_ONE, cloud, None, seconds)['new_hz']
            print('floor of {} points: {latency_ms:.1f} ms, at most {full_hz:.1f} clouds/s'.format(points, **floor), flush=True)
            floors[points] = floor
            for camera in self.cameras + self.rviz:
                if points > MOST_POINTS_ON_SOFTWARE and self.draws_with_software(camera):
                    continue
                # Between clouds camera_stream repeats no picture then.
                text = config(ONE_BY_ONE, repeat_hz=30 if camera in self.rviz else math.ceil(1.2 * hz))
                with self.running(camera, text) as (usage, _):
                    figures = self.measure(hz, usage, max(seconds, 8 / hz))
                text = config(ONE_BY_ONE, repeat_hz=30 if camera in self.rviz else FULL_SPEED_HZ)
                with self.running(camera, text) as (usage, _):
                    # Long enough for a few pictures of a slow program.
                    full = self.probe.measure(None, max(seconds, 5 * figures['latency_ms'] / 1000), usage)
                    figures.update(full_hz=full['new_hz'], peak_mb=full['peak_mb'])
                    rows.append(self.row(camera, figures, points=points, hz=hz))
        return {'floors': floors, 'rows': self.by_program(rows)}

    def sizes(self):
        cloud, rows = SerializedCloud(DEPTH_CAMERA_POINTS), []
        for size_px in SIZES_PX:
            floor = self.probe.floor(ONE_BY_ONE, cloud, 5, self.given.sweep_seconds, size_px)
            for camera in self.cameras:
                with self.running(camera, config(ONE_BY_ONE, repeat_hz=6)) as (usage, _):
                    figures = self.measure(5, usage, self.given.sweep_seconds)
                    rows.append(self.row(camera, figures, size_px=size_px, floor_ms=floor['latency_ms']))
        return {'rows': self.by_program(rows)}

    def several_cameras(self):
        cloud, rows = SerializedCloud(DEPTH_CAMERA_POINTS), []
        for count in CAMERAS:
            floor = self.probe.floor(ONE_BY_ONE, cloud, 5, self.given.sweep_seconds, cameras=count)
            for camera in self.cameras + [rviz for rviz in self.rviz if not self.draws_with_software(rviz)]:
                text = config(ONE_BY_ONE, cameras=count, repeat_hz=30 if camera in self.rviz else 6)
                with self.running(camera, text, count) as (usage, _):
                    figures = self.measure(5, usage, self.given.sweep_seconds)
                    rows.append(self.row(camera, figures, cameras=count, floor_ms=floor['latency_ms']))
        return {'rows': self.by_program(rows)}

    def lens(self):
        rows = []
        self.probe.use(NEWEST, PlainClouds(DEPTH_CAMERA_POINTS), SIZE_PX, DISTORTION)
        for camera in self.cameras:
            for lens, options in (('without', []), ('with', ['--undistort'])):
                with self.running(camera._replace(command=camera.command + options), config(NEWEST)) as (usage, _):
                    rows.append(self.row(camera, self.measure(self.given.hz, usage, self.given.seconds), lens=lens))
        return {'rows': rows}

    def compressed(self):
        rows = []
        self.probe.use(NEWEST, PlainClouds(DEPTH_CAMERA_POINTS), SIZE_PX)
        for camera in self.cameras:
            for settings in (None, {'format': 'jpeg', 'jpeg_quality': 80}, {'format': 'png', 'png_level': 1}):
                with self.running(camera, config(NEWEST)) as (usage, _):
                    packed = Compressed(self.probe, picture_topic(0), settings) if settings else None
                    figures = self.measure(self.given.hz, usage, self.given.seconds)
                    figures.update(packed.figures() if packed else {})
                    shown = ' '.join(str(value) for value in (settings or {'': 'none'}).values())
                    rows.append(self.row(camera, figures, compressed=shown))
        return {'rows': rows}

    def unwatched_stream(self, camera, cloud):
        """The load of a stream at the given rate that nobody watches, in percent of a core."""
        self.probe.use(STREAM, cloud, SIZE_PX)
        with self.running(camera, config(STREAM)) as (usage, _):
            self.probe.listen([])
            # Until it has proven itself a stream, and nobody has watched for a while.
            self.probe.send_some(self.given.hz, 5.0)
            cpu_s, begin = usage.cpu_s(), time.monotonic()
            self.probe.send_some(self.given.hz, self.given.seconds)
            percent = 100 * (usage.cpu_s() - cpu_s) / (time.monotonic() - begin)
        self.probe.use(NEWEST, cloud, SIZE_PX)
        return percent

    def idle(self):
        rows, seconds, cloud = [], self.given.seconds, PlainClouds(DEPTH_CAMERA_POINTS)
        self.probe.use(NEWEST, cloud, SIZE_PX)
        for camera in self.cameras + self.rviz:
            with self.running(camera, config(NEWEST)) as (usage, _):
                time.sleep(1.0)
                self.probe.forget()
                cpu_s, begin = usage.cpu_s(), time.monotonic()
                time.sleep(seconds)
                pictures, took_s = len(self.probe.arrivals), time.monotonic() - begin
                figures = {'repeated_hz': pictures / took_s, 'repeated_ms': 1000 * (usage.cpu_s() - cpu_s) / max(1, pictures)}
                self.probe.listen([])
                time.sleep(3.0)
                figures['still_percent'] = usage.percent(seconds)
                cpu_s, begin = usage.cpu_s(), time.monotonic()
                self.probe.send_some(self.given.hz, seconds)
                figures['moving_percent'] = 100 * (usage.cpu_s() - cpu_s) / (time.monotonic() - begin)
            figures['stream_percent'] = self.unwatched_stream(camera, cloud)
            rows.append(self.row(camera, figures))
        return {'rows': rows}

    def starts(self):
        rows = []
        self.probe.use(NEWEST, PlainClouds(DEPTH_CAMERA_POINTS), SIZE_PX)
        for camera in self.cameras:
            firsts_ms, renders_ms = [], []
            for _ in range(self.given.starts):
                with self.running(camera, config(NEWEST)) as (_, first_ms):
                    firsts_ms.append(first_ms)
            for _ in range(self.given.starts):
                begin = time.monotonic()
                subprocess.run(
                    [camera.command[0], 'render', '-d', os.path.join(ROOT, 'rviz', 'projection.rviz'), '--bag',
                     os.path.join(ROOT, 'config', 'demo', 'demo.bag'), '-o', os.path.join(self.folder, 'bench.png')] +
                    camera.command[1:], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, check=True)
                renders_ms.append(1000 * (time.monotonic() - begin))
            figures = {'firsts_ms': sorted(firsts_ms), 'renders_ms': sorted(renders_ms)}
            rows.append(self.row(camera, figures))
        return {'rows': rows}

    def light(self):
        return light.section(self, config(NEWEST), PlainClouds(DEPTH_CAMERA_POINTS))

    def blackout(self):
        return blackout.section(self, config(NEWEST), PlainClouds(DEPTH_CAMERA_POINTS))

    def pages(self):
        self.probe.use(NEWEST, PlainClouds(DEPTH_CAMERA_POINTS), SIZE_PX)
        return pages.section(self, config(NEWEST))

    def plugin(self):
        if not self.rviz:
            print('left out: rviz or its plugin CameraPub is not installed', flush=True)
            return None
        return plugin.section(self)

    def run(self, section):
        print('--- ' + section, flush=True)
        return getattr(self, {'cameras': 'several_cameras'}.get(section, section))()


@contextlib.contextmanager
def master(folder):
    """A ROS master on a free port, for this process and its children."""
    port = free_port()
    os.environ.update(ROS_MASTER_URI='http://127.0.0.1:{}'.format(port), ROS_IP='127.0.0.1')
    with Program(['roscore', '-p', str(port)], os.path.join(folder, 'roscore.log')):
        until = time.monotonic() + 30
        while not rosgraph.is_master_online():
            if time.monotonic() > until:
                sys.exit('bench: the ROS master did not start; its log: {}/roscore.log'.format(folder))
            time.sleep(0.2)
        yield


@contextlib.contextmanager
def display(folder):
    """A virtual screen for rviz, if there is no display."""
    if os.environ.get('DISPLAY'):
        yield
        return
    # The server picks a free display and writes its number, followed by a newline.
    reading, writing = os.pipe()
    log = os.path.join(folder, 'xvfb.log')
    with Program(['Xvfb', '-displayfd', str(writing), '-screen', '0', '1280x800x24'], log, inherit=[writing]):
        os.close(writing)
        with open(reading) as written:
            ready, _, _ = select.select([written], [], [], 20)
            number = written.readline().strip() if ready else ''
        if not number:
            sys.exit('bench: Xvfb did not start; log: {}'.format(log))
        os.environ['DISPLAY'] = ':' + number
        yield


def main():
    given = arguments.parse()
    if given.list:
        for camera in itertools.chain(*programs(given)):
            print(camera.name)
        return
    folder = tempfile.mkdtemp(prefix='rviz_camera_stream_bench.')
    with contextlib.ExitStack() as stack:
        stack.enter_context(master(folder))
        bench = Bench(given, folder)
        if bench.rviz:
            stack.enter_context(display(folder))
        bench.find_drivers()
        results = {}
        for section in (section for section in SECTIONS if section in given.only):
            result = bench.run(section)
            if result:
                results[section] = result
        rospy.signal_shutdown('done')
    shutil.rmtree(folder)
    if given.dry:
        for block in page.blocks(given, results).values():
            print('\n' + block)
    else:
        page.write(ROOT, given, results)


if __name__ == '__main__':
    main()
