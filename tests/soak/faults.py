"""The faults of `./soak`. Each is a function of the run and a random generator of its own; its first line says what it does.

The plan of all faults follows from the seed: it is dealt from a shuffled deck, so that each kind comes once before any comes
again. A fault that needs what another one has in hand waits for it.
"""

import contextlib
import random
import signal
import socket
import struct
import subprocess
import time

from dynamic_reconfigure.msg import BoolParameter, DoubleParameter, IntParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from roscpp.srv import SetLoggerLevel
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from . import config, ros
from .damage import KINDS as DAMAGES
from .processes import Failure, end, module, start
from .scene import CAMERAS, HANDLES, SENSORS, SOURCES, SCENE

FAULTS = {}
LOGGER = 'ros.rviz_camera_stream'


def fault(*needs):
    """Registers a fault, with what no other fault may touch meanwhile."""
    def register(function):
        FAULTS[function.__name__] = (function, needs)
        return function
    return register


def plan(seed, only, mean_s):
    """An endless sequence of (seconds to wait, kind, seed of its parameters)."""
    rng = random.Random(seed)
    kinds = only or list(FAULTS)
    while True:
        deck = list(kinds)
        rng.shuffle(deck)
        for kind in deck:
            yield rng.expovariate(1 / mean_s), kind, rng.randrange(1 << 30)


# --- viewers ----------------------------------------------------------------------------------------------------------

def camera(rng):
    return rng.choice(list(CAMERAS))


def topic_of(name):
    return '/soak/{}/image'.format(name)


def connected(run, name):
    return ros.subscribe(run.node.uri, topic_of(name), Image)


def reset(connection):
    """Closes a connection as if its process was killed with data in flight."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
    connection.close()


@fault()
def viewer_slow(run, rng):
    """A viewer reads slower than pictures come."""
    name, rate, seconds = camera(rng), rng.choice([2e4, 2e5, 1e6]), rng.uniform(2, 8)
    yield '{} at {:.0f} kB/s for {:.1f} s'.format(name, rate / 1000, seconds)
    with contextlib.closing(connected(run, name)) as connection:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            connection.recv(max(1, int(rate * 0.05)))
            time.sleep(0.05)


@fault()
def viewer_silent(run, rng):
    """Viewers connect and read nothing."""
    name, count, seconds = camera(rng), rng.randrange(1, 6), rng.uniform(2, 8)
    yield '{} of {} for {:.1f} s'.format(count, name, seconds)
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            stack.enter_context(contextlib.closing(connected(run, name)))
        time.sleep(seconds)


@fault()
def viewer_stopped(run, rng):
    """A viewer is stopped by SIGSTOP, goes on, and is killed."""
    name, seconds = camera(rng), rng.uniform(1, 5)
    yield '{} for {:.1f} s'.format(name, seconds)
    command = module('soak.viewer', run.node.uri, topic_of(name))
    process = start(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    try:
        time.sleep(1)
        process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        process.send_signal(signal.SIGCONT)
        time.sleep(0.5)
    finally:
        end(process, signal.SIGKILL)
        process.stdin.close()


@fault()
def viewer_killed(run, rng):
    """Viewers are killed in the middle of a picture."""
    name, count = camera(rng), rng.randrange(1, 20)
    yield '{} of {}'.format(count, name)
    for _ in range(count):
        connection = connected(run, name)
        connection.recv(rng.randrange(1, 100000))
        reset(connection)


@fault()
def viewer_half_open(run, rng):
    """Connections to the port of a topic that send half a header, or nothing."""
    name, count, seconds = camera(rng), rng.randrange(1, 12), rng.uniform(1, 6)
    yield '{} to {} for {:.1f} s'.format(count, name, seconds)
    address = ros.topic_address(run.node.uri, topic_of(name))
    header = b'\xb0\0\0\0\x20\0\0\0message_definition=string data\n\n'
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            connection = stack.enter_context(contextlib.closing(socket.create_connection(address, ros.TIMEOUT_S)))
            connection.sendall(header[:rng.randrange(len(header))])
        time.sleep(seconds)


@fault()
def garbage(run, rng):
    """Noise on the node's TCPROS and XML-RPC ports."""
    count = rng.randrange(5, 40)
    yield '{} connections'.format(count)
    api = ros.rosgraph.network.parse_http_host_and_port(run.node.uri)
    tcpros = ros.topic_address(run.node.uri, topic_of('cam_a'))
    noise = bytes(rng.randrange(256) for _ in range(2000))
    call = b'<methodCall><methodName>%s</methodName><params>%s</params></methodCall>'
    pieces = [
        noise, b'', b'\xff\xff\xff\xff', b'\xff\xff\xff\x7f' + noise, b'GET / HTTP/1.1\r\n\r\n',
        b'POST / HTTP/1.1\r\nContent-Length: ',
        b'POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n<', b'POST / HTTP/1.0\r\nContent-Length: 5\r\n\r\n<a><b',
        http(b'<a>' * 5000), http(call % (b'noSuchMethod', b'')), http(call % (b'requestTopic', b'<param/>')),
        http(call % (b'publisherUpdate', b'<param><value>x</value></param>' * 3)), http(noise),
    ]
    for _ in range(count):
        with contextlib.suppress(OSError), contextlib.closing(
                socket.create_connection(rng.choice([api, tcpros]), ros.TIMEOUT_S)) as connection:
            connection.sendall(rng.choice(pieces))
            if rng.random() < 0.5:
                time.sleep(0.05)
            else:
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))


def http(body):
    return b'POST / HTTP/1.1\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n%s' % (len(body), body)


# --- publishers -------------------------------------------------------------------------------------------------------

@fault('master', SENSORS)
def sensors_killed(run, rng):
    """The process that publishes clouds is killed and started again."""
    seconds = rng.uniform(0, 2)
    yield 'for {:.1f} s'.format(seconds)
    run.helpers[SENSORS].restart(seconds)


@fault('master', SCENE, 'lenses')
def scene_killed(run, rng):
    """The process that publishes TF, the cameras' lenses and all small topics is killed and started again."""
    seconds = rng.uniform(0, 2)
    yield 'for {:.1f} s'.format(seconds)
    run.helpers[SCENE].restart(seconds)


@fault('master', 'vandal')
def vandal_killed(run, rng):
    """A second publisher of every topic is killed and started again."""
    seconds = rng.uniform(0, 2)
    yield 'for {:.1f} s'.format(seconds)
    run.helpers['vandal'].restart(seconds)


@fault(SENSORS)
def sensors_stopped(run, rng):
    """The process that publishes clouds is stopped by SIGSTOP."""
    seconds = rng.uniform(1, 4)
    yield 'for {:.1f} s'.format(seconds)
    stopped(run.helpers[SENSORS].process, seconds)


@fault(SCENE, 'lenses')
def scene_stopped(run, rng):
    """The process that publishes TF and the cameras' lenses is stopped by SIGSTOP."""
    seconds = rng.uniform(1, 4)
    yield 'for {:.1f} s'.format(seconds)
    stopped(run.helpers[SCENE].process, seconds)


def stopped(process, seconds):
    process.send_signal(signal.SIGSTOP)
    try:
        time.sleep(seconds)
    finally:
        process.send_signal(signal.SIGCONT)


@fault(SENSORS, SCENE)
def connections_cut(run, rng):
    """Connections between publishers and the node break while both live."""
    group, times = rng.choice([SENSORS, SCENE]), rng.randrange(1, 5)
    yield 'all of {}, {} times'.format(group, times)
    for _ in range(times):
        run.helpers[group].ask('cut', 2, [])
        time.sleep(rng.uniform(0.1, 1.0))


@fault('master')
def publisher_hangs(run, rng):
    """Publishers are registered that accept connections and never answer."""
    sources, seconds = rng.sample(SOURCES, rng.randrange(1, 6)), rng.uniform(2, 6)
    yield '{} for {:.1f} s'.format(', '.join(source.topic for source in sources), seconds)
    with contextlib.ExitStack() as stack:
        for number, source in enumerate(sources):
            listener = stack.enter_context(contextlib.closing(socket.create_server(('127.0.0.1', 0))))
            uri = 'http://127.0.0.1:{}/'.format(listener.getsockname()[1])
            register(stack, run, '/soak_hanging_{}'.format(number), source, uri)
        time.sleep(seconds)


@fault('master')
def publisher_dead(run, rng):
    """Publishers are registered whose processes do not exist."""
    sources, seconds = rng.sample(SOURCES, rng.randrange(1, 6)), rng.uniform(1, 4)
    yield '{} for {:.1f} s'.format(', '.join(source.topic for source in sources), seconds)
    with contextlib.ExitStack() as stack:
        for number, source in enumerate(sources):
            register(stack, run, '/soak_dead_{}'.format(number), source, 'http://127.0.0.1:9/')
        time.sleep(seconds)


def register(stack, run, name, source, uri):
    master = ros.proxy(run.master.uri)
    master.registerPublisher(name, source.topic, source.kind._type, uri)
    stack.callback(master.unregisterPublisher, name, source.topic, uri)


# --- the master -------------------------------------------------------------------------------------------------------

@fault('master')
def master_restarted(run, rng):
    """The master is killed, and another one starts on the same port."""
    seconds = rng.uniform(0, 3)
    yield 'after {:.1f} s'.format(seconds)
    run.master.kill()
    time.sleep(seconds)
    run.master.start()
    run.await_registration()


@fault('master')
def master_stopped(run, rng):
    """The master is stopped by SIGSTOP."""
    seconds = rng.uniform(2, 6)
    yield 'for {:.1f} s'.format(seconds)
    stopped(run.master.process, seconds)


# --- settings ---------------------------------------------------------------------------------------------------------

@fault('config')
def config_edited(run, rng):
    """The config is saved with displays and cameras removed, added and changed, several times."""
    times = rng.randrange(1, 4)
    yield '{} times'.format(times)
    try:
        for _ in range(times):
            run.save_config(config.edited(rng), rng)
            time.sleep(rng.uniform(0.2, 2.5))
    finally:
        run.save_config(None, rng)


@fault('config')
def config_broken(run, rng):
    """A config that cannot be read is saved, and repaired."""
    how, seconds = rng.choice(list(config.BREAKS)), rng.uniform(0.5, 3)
    yield '{} for {:.1f} s'.format(how, seconds)
    try:
        config.BREAKS[how](run.config_file, rng)
        time.sleep(seconds)
    finally:
        run.save_config(None, rng)


@fault('config', 'master')
def reload_called(run, rng):
    """The service reload_config is called, once with a config that cannot be read."""
    yield ''
    for text in (config.edited(rng), '{', None):
        run.save_config(text, rng)
        answer = run.call('/camera_stream/reload_config', Trigger, Trigger._request_class())
        if answer.success != (text != '{'):
            raise Failure('reload_config answers {}: {}'.format(answer.success, answer.message))


@fault('master')
def trigger_called(run, rng):
    """The trigger service of a camera is called many times."""
    name, count = camera(rng), rng.randrange(1, 20)
    yield '{} times for {}'.format(count, name)
    for _ in range(count):
        answer = run.call('/{}/camera_trigger'.format(name), Trigger, Trigger._request_class())
        if not answer.success:
            raise Failure('camera_trigger answers: {}'.format(answer.message))


@fault('master', 'lenses')
def reconfigured(run, rng):
    """Settings of a camera are changed by dynamic_reconfigure and changed back."""
    name, times = camera(rng), rng.randrange(1, 5)
    yield '{}, {} times'.format(name, times)
    server = '/camera_stream/{}/set_parameters'.format(name)
    try:
        for _ in range(times):
            request = Reconfigure._request_class()
            request.config.ints = [IntParameter('background_red', rng.randrange(-50, 300))]
            request.config.doubles = [DoubleParameter('near_clip', rng.choice([0.01, 0.5, 1e9, float('nan')])),
                                      DoubleParameter('frame_rate', rng.choice([-1, 3, 15, 1e9]))]
            request.config.bools = [BoolParameter('show_lidar', rng.random() < 0.5), BoolParameter('no_such', True)]
            request.config.strs = [StrParameter('image_encoding', rng.choice(['bgr8', 'mono8', 'mono16', 'rgba8', 'bad']))]
            run.call(server, Reconfigure, request)
            time.sleep(rng.uniform(0.1, 1))
    finally:
        request = Reconfigure._request_class()
        request.config.ints = [IntParameter('background_red', 12)]
        request.config.doubles = [DoubleParameter('near_clip', 0.01), DoubleParameter('frame_rate', CAMERAS[name][2])]
        request.config.bools = [BoolParameter('show_lidar', True)]
        request.config.strs = [StrParameter('image_encoding', 'rgb8')]
        run.call(server, Reconfigure, request)


@fault('master')
def log_level_set(run, rng):
    """The log's level is changed and changed back."""
    levels, seconds = rng.sample(['debug', 'warn', 'error', 'fatal', 'no such'], 2), rng.uniform(0.2, 1)
    yield ', '.join(levels)
    for level in levels + ['info']:
        with contextlib.suppress(OSError) if level == 'no such' else contextlib.nullcontext():
            run.call('/camera_stream/set_logger_level', SetLoggerLevel, SetLoggerLevel._request_class(LOGGER, level))
        time.sleep(seconds if level != 'info' else 0)


# --- lenses -----------------------------------------------------------------------------------------------------------

@fault('lenses', SCENE)
def lens_changed(run, rng):
    """A camera's CameraInfo changes its size several times."""
    name, times = camera(rng), rng.randrange(1, 6)
    sizes = [(rng.randrange(1, 900), rng.randrange(1, 700)) for _ in range(times)]
    yield '{}: {}'.format(name, ', '.join('{}x{}'.format(*size) for size in sizes))
    with lens(run, name):
        for width, height in sizes:
            run.helpers[SCENE].ask('set_info', name, width, height, None, None)
            time.sleep(rng.uniform(0.1, 1))


@fault('lenses', SCENE)
def lens_huge(run, rng):
    """A camera has a very large picture for a moment."""
    size = rng.choice([(4096, 3072), (5000, 1000), (300, 16384)])
    yield 'cam_c: {}x{}'.format(*size)
    # Until all viewers have received it.
    with run.watch.excuses.during('lens_huge', ('cam_c',)), lens(run, 'cam_c'):
        run.helpers[SCENE].ask('set_info', 'cam_c', size[0], size[1], None, None)
        time.sleep(1)


@fault('lenses', SCENE)
def lens_invalid(run, rng):
    """A camera's CameraInfo is invalid, or in a frame that does not exist: there is no picture meanwhile."""
    name, seconds = camera(rng), rng.uniform(0.5, 3)
    broken = rng.choice(['nan', 'zero', 'too large', 'no projection', 'frame'])
    yield '{}: {} for {:.1f} s'.format(name, broken, seconds)
    with run.watch.excuses.during('lens_invalid', (name,)), lens(run, name):
        frame = 'no_such_frame' if broken == 'frame' else None
        run.helpers[SCENE].ask('set_info', name, None, None, frame, broken)
        time.sleep(seconds)


@contextlib.contextmanager
def lens(run, name):
    """Restores a camera's lens in the end."""
    try:
        yield
    finally:
        run.helpers[SCENE].ask('reset_info', name)


# --- messages ---------------------------------------------------------------------------------------------------------

@fault(SCENE)
def tf_silent(run, rng):
    """No transforms for a while."""
    seconds = rng.uniform(1, 6)
    yield 'for {:.1f} s'.format(seconds)
    run.helpers[SCENE].ask('silence_tf', seconds)
    time.sleep(seconds)


@fault('vandal')
def tf_made_up(run, rng):
    """New frames that nobody uses, at a rate."""
    hz, seconds = rng.choice([10, 50, 200]), rng.uniform(1, 4)
    yield '{} a second for {:.1f} s'.format(hz, seconds)
    run.helpers['vandal'].ask('made_up_frames', hz, seconds, rng.randrange(10 ** 6))


@fault('vandal')
def tf_bad(run, rng):
    """Transforms with NaN, zero quaternions, empty names, loops, and from long ago."""
    count = rng.randrange(1, 60)
    yield '{}'.format(count)
    run.helpers['vandal'].ask('bad_frames', rng.randrange(10 ** 6), count)


@fault('vandal')
def unknown_frame(run, rng):
    """Messages in a frame that does not exist."""
    count = rng.randrange(1, 40)
    yield '{}'.format(count)
    run.helpers['vandal'].ask('unknown_frame', 'nowhere_{}'.format(rng.randrange(100)), count)


@fault('vandal', 'config')
def bad_messages(run, rng):
    """Damaged messages on several topics."""
    chosen = [(rng.choice([source.topic for source in SOURCES] + [HANDLES]), rng.choice(DAMAGES), rng.randrange(10 ** 6),
               rng.randrange(1, 12)) for _ in range(8)]
    yield ', '.join('{} {}'.format(topic, kind) for topic, kind, _, _ in chosen)
    for topic, kind, seed, count in chosen:
        run.helpers['vandal'].ask('damage', topic, kind, seed, count)
        run.damaged.add(topic)


@fault(SENSORS)
def cloud_flood(run, rng):
    """Clouds at several times their rate."""
    factor, seconds = rng.choice([3, 5, 8]), rng.uniform(1, 4)
    yield '{} times for {:.1f} s'.format(factor, seconds)
    try:
        run.helpers[SENSORS].ask('set_rate', factor)
        time.sleep(seconds)
    finally:
        run.helpers[SENSORS].ask('set_rate', 1.0)


@fault('vandal')
def marker_flood(run, rng):
    """Thousands of markers, and DELETEALL."""
    count, seconds = rng.choice([1000, 3000]), rng.uniform(0.5, 2)
    yield '{} for {:.1f} s'.format(count, seconds)
    run.helpers['vandal'].ask('many_markers', count, seconds)


@fault('vandal')
def mesh_missing(run, rng):
    """Markers with meshes that do not exist or cannot be read."""
    number = rng.randrange(1000)
    addresses = ['package://no_such_package/{}.stl'.format(number), 'package://conformance_assets/{}.dae'.format(number),
                 'file:///nowhere/{}.obj'.format(number), 'http://127.0.0.1:9/{}.stl'.format(number), '', 'package://', 'x',
                 'file:///dev/zero', 'file:///proc/self/mem', 'package://conformance_assets/../../x.stl',
                 'package://conformance_assets/package.xml']
    chosen = rng.sample(addresses, 4)
    yield ', '.join(chosen)
    run.helpers['vandal'].ask('missing_meshes', chosen)


# --- the node ---------------------------------------------------------------------------------------------------------

@fault('node')
def node_stopped(run, rng):
    """The node itself is stopped by SIGSTOP."""
    seconds = rng.uniform(1, 2)
    yield 'for {:.1f} s'.format(seconds)
    with run.watch.excuses.during('node_stopped', tuple(CAMERAS)):
        stopped(run.node.process, seconds)
