"""Measures how soon a blackout is dark: from a script's call until the X server's screen is black, under load.

The node has a window of its own on Xvfb. The callers are a script that keeps its connection to the service (`persistent`), as one
that has to be quick does, and the operator's page, which opens a connection for each request. The loads:

    nothing   an unchanged cloud
    markers   100,000 arrows that are placed anew all the time
    mesh      a mesh of two million triangles that is being loaded
    master    a ROS master that does not answer
"""

import contextlib
import http.client
import io
import itertools
import json
import os
import signal
import statistics
import sys
import threading
import time

import numpy
import rosgraph
import rospy
from geometry_msgs.msg import Point, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from std_srvs.srv import SetBool
from visualization_msgs.msg import Marker, MarkerArray

from . import pages
from .light import x_server
from .probe import NEWEST, SIZE_PX, Program

MARKERS = 'bench_markers'
ARROWS = 100000
TRIANGLES = 2000000
# Blackouts of each load; of a mesh, each needs a file of its own.
BLACKOUTS = 20
MESHES = 5
DISPLAY = '  Displays:\n  - {Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: ' + MARKERS + '}\n'
TIMEOUT_S = 60


def marker(number, kind, **fields):
    """A marker behind the cloud."""
    made = Marker(ns='bench', id=number, type=kind, color=ColorRGBA(0, 1, 0, 1), scale=Vector3(0.1, 0.01, 0.01), **fields)
    made.header.frame_id = 'base'
    made.pose.position = Point(number % 317 * 0.01 - 1.6, number // 317 * 0.01 - 1.6, 5)
    made.pose.orientation = Quaternion(0, 0.6, 0, 0.8)
    return made


def written(message):
    """The message, serialised once."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type('Written', (type(message),), {'serialize': lambda _, buff: buff.write(buffer.getvalue())})()


class Sender(threading.Thread):
    """Publishes one message again and again until it ends."""

    def __init__(self, publisher, message, period_s):
        super().__init__(daemon=True)
        self.publisher, self.message, self.period_s, self.ended = publisher, message, period_s, threading.Event()
        self.start()

    def run(self):
        while not self.ended.wait(self.period_s):
            self.publisher.publish(self.message)


@contextlib.contextmanager
def nothing(_publisher, _folder):
    """No load."""
    yield lambda: None


@contextlib.contextmanager
def markers(publisher, _folder):
    """Arrows that are placed anew all the time."""
    sender = Sender(publisher, written(MarkerArray([marker(number, Marker.ARROW) for number in range(ARROWS)])), 0.2)
    time.sleep(1.0)
    yield lambda: None
    sender.ended.set()
    sender.join()


@contextlib.contextmanager
def mesh(publisher, folder):
    """Meshes, each of which is loaded when it is first seen."""
    triangle = numpy.dtype([('numbers', '<f4', 12), ('attribute', '<u2')])
    made = numpy.zeros(TRIANGLES, triangle)
    made['numbers'] = numpy.random.default_rng(7).uniform(-0.1, 0.1, (TRIANGLES, 12))
    files = [os.path.join(folder, 'mesh{}.stl'.format(number)) for number in range(MESHES)]
    for file in files:
        with open(file, 'wb') as out:
            out.write(bytes(80) + TRIANGLES.to_bytes(4, 'little') + made.tobytes())
    numbers = iter(range(MESHES))

    def load():
        number = next(numbers)
        publisher.publish(MarkerArray([marker(number, Marker.MESH_RESOURCE, mesh_resource='file://' + files[number])]))
        time.sleep(0.1)

    yield load


@contextlib.contextmanager
def master(_publisher, _folder):
    """A master that does not answer."""
    pid = rosgraph.Master('/bench').getPid()
    os.kill(pid, signal.SIGSTOP)
    try:
        yield lambda: None
    finally:
        os.kill(pid, signal.SIGCONT)


def until(screen, is_black):
    """Waits until the screen is black, or is not. Returns the time."""
    begun = time.monotonic()
    while bool(screen.pixels[:, :, :3].any()) == is_black:
        if time.monotonic() > begun + TIMEOUT_S:
            sys.exit('bench: the screen is not {} after {} s'.format('black' if is_black else 'lit', TIMEOUT_S))
    return time.monotonic()


def script(_bench):
    """Switches by the service."""
    rospy.wait_for_service('/camera_stream/blackout', TIMEOUT_S)
    return rospy.ServiceProxy('/camera_stream/blackout', SetBool, persistent=True)


def page(bench):
    """Blacks out as the operator's page does; what releases it makes no difference."""
    release = script(bench)
    (host, port), token = pages.address(bench.log)
    head = {'Authorization': 'Bearer ' + token, 'Content-Type': 'application/json'}

    def post(is_on):
        if not is_on:
            release(False)
            return
        connection = http.client.HTTPConnection(host, port, timeout=TIMEOUT_S)
        connection.request('POST', '/api/blackout', json.dumps({'on': is_on, 'camera': None}), head)
        answer = connection.getresponse()
        if answer.status != 200:
            sys.exit('bench: the page: {} {!r}'.format(answer.status, answer.read()))
        connection.close()

    return post


def measure(bench, camera, text, load, caller, cloud):
    """The figures of one load and caller."""
    file = os.path.join(bench.folder, 'blackout.rviz')
    with open(file, 'w') as out:
        out.write(text.replace('  Displays:\n', DISPLAY, 1))
    publisher = rospy.Publisher(MARKERS, MarkerArray, queue_size=2, latch=True)
    with contextlib.ExitStack() as stack:
        shown, screen, _ = stack.enter_context(x_server(bench.log))
        environment = {key: value for key, value in os.environ.items() if not key.startswith('WAYLAND_')}
        environment['DISPLAY'] = shown
        bench.probe.use(NEWEST, cloud, SIZE_PX)
        bench.probe.send(0)
        command = camera.command + ['-d', file, '--window', 'auto', '--web', '0', '--mesh-folder', bench.folder]
        stack.enter_context(Program(command, bench.log, environment=environment))
        until(screen, False)
        call = caller(bench)
        call(False)
        begin_load = stack.enter_context(load(publisher, bench.folder))
        times_ms = []
        for _ in range(MESHES if load is mesh else BLACKOUTS):
            until(screen, False)
            begin_load()
            begun = time.monotonic()
            call(True)
            times_ms.append(1000 * (until(screen, True) - begun))
            call(False)
    publisher.unregister()
    return {'median_ms': statistics.median(times_ms), 'worst_ms': max(times_ms), 'count': len(times_ms)}


def section(bench, text, cloud):
    """The rows of the section."""
    os.environ['ROS_HOME'] = bench.folder
    loads = (('nothing', nothing), ('100,000 arrows are placed', markers), ('a mesh of 2,000,000 triangles is loaded', mesh),
             ('the ROS master hangs', master))
    rows = []
    for camera in bench.cameras:
        for (name, load), caller in itertools.product(loads, (script, page)):
            figures = measure(bench, camera, text, load, caller, cloud)
            rows.append(bench.row(camera, figures, load=name, caller='the ' + caller.__name__))
    return {'rows': rows}
