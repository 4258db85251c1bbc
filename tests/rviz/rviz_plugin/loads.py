"""Starts rviz as it is found in this environment, with CameraPub in its config, and waits for a picture.

    python3 -m rviz_plugin.loads        from the folder `tests/rviz`, `tests` in PYTHONPATH, after sourcing a workspace's setup file

Prints the picture's size, its number of different colours, and the library that rviz has loaded the plugin from. Needs no
prefix: whatever the sourced environment says about packages is used.

On a busy machine, rviz 1.14.19 with a grid and no plugin at all ended by SIGSEGV or SIGABRT in software OpenGL or Qt in 9 of
220 starts. So rviz is started again, twice at most, where a signal has ended it before there was a picture; that is printed.
"""

import os
import pathlib
import sys
import tempfile

from golden.scenes.rviz_runner import Stage

from .camera_topics import CameraFrame, Infos, Pictures, camera_info, pixels
from .window import camera, grid

ATTEMPTS = 3
PATHS = ("ROS_PACKAGE_PATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PATH")


def loaded_library(pid):
    """The file that a process has mapped the plugin from."""
    with open(f"/proc/{pid}/maps") as maps:
        return next((line.split()[-1] for line in maps if "librviz_camera_stream.so" in line), "none")


def main():
    import rospy
    import yaml
    with tempfile.TemporaryDirectory(prefix="loads_") as folder:
        sourced = {name: os.environ[name] for name in PATHS if name in os.environ}
        with Stage(folder, environment=sourced) as stage:
            os.environ.update({name: stage.environment[name] for name in ("ROS_MASTER_URI", "ROS_HOME", "ROS_HOSTNAME")})
            rospy.init_node("loads", disable_signals=True, disable_rosout=True)
            config = pathlib.Path(folder) / "config.rviz"
            config.write_text(yaml.safe_dump({"Visualization Manager": {
                "Displays": [grid(), camera()], "Global Options": {"Fixed Frame": "map", "Frame Rate": 30}}}))
            frame, infos, pictures = CameraFrame(), Infos("/camera/info", camera_info()), Pictures("/camera/image")
            for attempt in range(ATTEMPTS):
                with stage.rviz(config) as rviz:
                    window = type("Window", (), {"program": rviz, "report": lambda _: rviz.last_lines()})
                    try:
                        picture = pictures.wait_for(lambda each: pixels(each).max() == 255, "with the grid", window)
                    except RuntimeError:
                        if attempt + 1 == ATTEMPTS or rviz.is_running() or rviz.process.returncode >= 0:
                            raise
                        print(f"rviz ended by signal {-rviz.process.returncode} and is started again", flush=True)
                        pictures.forget()
                        continue
                    colours = len({tuple(pixel) for pixel in pixels(picture).reshape(-1, 3)})
                    print(f"picture {picture.width}x{picture.height}, {colours} colours, from {loaded_library(rviz.pid)}")
                    break
            frame.close()
            infos.close()
            pictures.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
