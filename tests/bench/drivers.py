"""Finds out which graphics drivers the programs under test get, by what they say themselves.

A machine may have a GPU without /dev/dri, and beside it a virtual screen whose OpenGL is a software driver. So no device file
counts, but the adapter that camera_stream opens, and the OpenGL renderer that rviz gets on its display.
"""

import collections
import glob
import os
import re
import time

from .probe import Program

# Names of programs under test. `auto` takes the CPU or a hardware GPU.
GPU, AUTO, RVIZ, RVIZ_GPU = 'camera_stream, gpu', 'camera_stream, auto', 'rviz', 'rviz, gpu'
# Names of OpenGL's and Vulkan's drivers that draw on the CPU.
SOFTWARE = re.compile('llvmpipe|softpipe|swrast|swiftshader|software rasterizer', re.IGNORECASE)
# NVIDIA's OpenGL draws on any X server, also on a virtual one, whose own OpenGL would be chosen otherwise.
NVIDIA = ['env', '__GLX_VENDOR_LIBRARY_NAME=nvidia']
NVIDIA_DEVICES = '/dev/nvidia[0-9]*'
TIMEOUT_S = 30

# The adapter of camera_stream's GPU renderer and the OpenGL renderer of rviz, in their own words; None if there is none.
Drivers = collections.namedtuple('Drivers', 'gpu opengl')


def is_hardware(name):
    """Whether a driver of this name draws on a GPU."""
    return bool(name) and not SOFTWARE.search(name)


def said(command, pattern, log):
    """What the pattern captures in the program's output, which goes to the file `log`; None if it ends without saying it."""
    environment = dict(os.environ, ROSCONSOLE_STDOUT_LINE_BUFFERED='1')
    with Program(command, log, environment=environment) as process:
        until = time.monotonic() + TIMEOUT_S
        while time.monotonic() < until:
            has_ended = process.poll() is not None
            with open(log, errors='replace') as text:
                found = re.search(pattern, text.read())
            if found or has_ended:
                return found and found.group(1).strip()
            time.sleep(0.1)
    return None


def adapter(camera_stream, config, folder):
    """The adapter that the GPU renderer opens."""
    return said([camera_stream, '--renderer', 'gpu', '-d', config], r' with gpu \((.*), \w+\)', os.path.join(folder, 'gpu.log'))


def rviz_on_gpu(command, folder):
    """The command with which rviz draws on the GPU if there is a way, or as it is; and the OpenGL renderer that it gets."""
    ways = [command] + [NVIDIA + command] * bool(glob.glob(NVIDIA_DEVICES))
    tried = []
    for number, way in enumerate(ways):
        log = os.path.join(folder, 'opengl{}.log'.format(number))
        tried.append((way, said(way + ['--ogre-log'], r'GL_RENDERER = ([^\x1b\n]+)[\x1b\n]', log)))
        if is_hardware(tried[-1][1]):
            return tried[-1]
    return tried[0]
