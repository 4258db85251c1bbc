"""The screen and the master that all tests of a run share."""

import atexit
import os
import pathlib
import tempfile

from golden.scenes.rviz_runner import Stage

PREFIX_VARIABLE = "RVIZ_PLUGIN_PREFIX"
_shared = None


def stage():
    """The Stage, started when it is first asked for, with this process as a node on its master.

    The environment variable RVIZ_PLUGIN_PREFIX names the prefix where the plugin and the driver are installed.
    """
    global _shared
    if _shared is None:
        prefix = os.environ.get(PREFIX_VARIABLE)
        if not prefix or not pathlib.Path(prefix, "lib", "librviz_camera_stream.so").exists():
            raise RuntimeError(f"{PREFIX_VARIABLE} must name the prefix where the plugin is installed, not {prefix!r}")
        folder = tempfile.TemporaryDirectory(prefix="rviz_plugin_")
        _shared = Stage(folder.name, plugin_prefix=pathlib.Path(prefix).resolve())
        atexit.register(folder.cleanup)
        atexit.register(_shared.end)
        os.environ.update({name: _shared.environment[name] for name in ("ROS_MASTER_URI", "ROS_HOME", "ROS_HOSTNAME")})
        import rospy
        rospy.init_node("tests", disable_signals=True, disable_rosout=True)
    return _shared
