"""The real rviz with the CameraPub plugin, isolated from whatever else runs on this machine.

A `Stage` is a virtual screen with Mesa's software OpenGL, a ROS master on a free port and an empty home. On it, `rviz` runs
with a config and the plugin of an installed prefix:

    with Stage(folder, plugin_prefix=prefix, packages=[golden]) as stage:
        stage.set_parameter("/robot_description", text)
        with stage.rviz(config_file) as rviz:
            ...

`Stage.environment` is that of the programs on the stage, for others that share its master. Only the stage's own processes are
ended.
"""

import os
import pathlib
import shutil
import xmlrpc.client
from typing import Any

from .processes import Program, free_port, wait_until

START_TIMEOUT_SECS = 120.0
# Large enough for the window of each config.
SCREEN_SIZE = "1600x1200x24"


class Stage:
    """A screen, a master and a home, for one or several rviz after each other."""

    def __init__(self, folder, plugin_prefix=None, packages=(), environment=None):
        """Starts screen and master.

        folder: where logs and the home go; must be this stage's own.
        plugin_prefix: where the plugin is installed: `lib/librviz_camera_stream.so` and `share/rviz_camera_stream` with
            `package.xml` and `plugin_description.xml`. None: rviz runs without it.
        packages: folders below which `package://` addresses are found.
        environment: further variables of all programs.
        """
        self.folder = pathlib.Path(folder).absolute()
        self.folder.mkdir(parents=True, exist_ok=True)
        self.environment = _environment(self.folder, plugin_prefix, packages)
        self.environment.update(environment or {})
        self._programs = []
        try:
            self._start_screen()
            self._start_master()
        except BaseException:
            self.end()
            raise

    def _start_screen(self):
        reading, writing = os.pipe()
        command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", SCREEN_SIZE, "+extension", "GLX", "-noreset",
                   "-nolisten", "tcp"]
        try:
            screen = Program(command, self.environment, self.folder / "xvfb.log", pass_fds=(writing,))
        finally:
            os.close(writing)
        self._programs.append(screen)
        with os.fdopen(reading) as answer:
            number = answer.readline().strip()
        if not number:
            screen.process.wait(5)
            screen.check()
        self.environment["DISPLAY"] = f":{number}"

    def _start_master(self):
        for attempt in range(10):
            port = free_port()
            self.environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
            master = Program(["rosmaster", "--core", "-p", str(port)], self.environment, self.folder / f"master_{attempt}.log")
            self._programs.append(master)
            self.master: Any = xmlrpc.client.ServerProxy(self.environment["ROS_MASTER_URI"])
            wait_until(lambda: self._answers() or not master.is_running(), START_TIMEOUT_SECS, "the master does not answer")
            # Another program may have taken the port in between, and might answer instead.
            if master.is_running():
                return
        master.check()

    def _answers(self):
        try:
            return self.master.getPid("/scenes")[0] == 1
        except OSError:
            return False

    def set_parameter(self, name, value):
        """Sets a ROS parameter."""
        code, message, _ = self.master.setParam("/scenes", name, value)
        if code != 1:
            raise RuntimeError(f"parameter {name}: {message}")

    def delete_parameter(self, name):
        """Deletes a ROS parameter if it is set."""
        self.master.deleteParam("/scenes", name)

    def rviz(self, config, name="rviz", arguments=(), environment=None):
        """Starts rviz with the config and waits until it has registered at the master.

        environment: further variables. rviz gets a copy of the file, because it writes into it. Returns its Program, to be
        ended by the caller, as a `with` block does. Raises RuntimeError when rviz ends, TimeoutError when it does not come up.
        """
        copy = self.folder / f"{name}.rviz"
        shutil.copyfile(config, copy)
        command = ["rviz", "-d", str(copy), "--splash-screen", "", *arguments, f"__name:={name}"]
        rviz = _Node(self, f"/{name}", command, self.folder / f"{name}.log", environment)
        try:
            # rviz offers this service after it has loaded the config.
            wait_until(lambda: self.has_service(f"/{name}/load_config"), START_TIMEOUT_SECS, f"rviz is not ready: {rviz.log}",
                       [rviz])
        except BaseException:
            rviz.end()
            raise
        return rviz

    def forget(self, node):
        """Removes what the master still knows of a node that has ended without saying so, as rviz does on SIGTERM."""
        code, _, api = self.master.lookupNode("/scenes", node)
        if code != 1:
            return
        publishers, subscribers, services = self.system_state()
        for topic, _ in (each for each in publishers if node in each[1]):
            self.master.unregisterPublisher(node, topic, api)
        for topic, _ in (each for each in subscribers if node in each[1]):
            self.master.unregisterSubscriber(node, topic, api)
        for service, _ in (each for each in services if node in each[1]):
            self.master.unregisterService(node, service, self.master.lookupService("/scenes", service)[2])

    def has_service(self, name):
        """Whether a service is registered."""
        return self.master.lookupService("/scenes", name)[0] == 1

    def system_state(self):
        """Publishers, subscribers and services as the master knows them: lists of [name, [node, ...]]."""
        return self.master.getSystemState("/scenes")[2]

    def end(self):
        """Ends the stage's programs."""
        for program in reversed(self._programs):
            program.end()
        self._programs = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()


class _Node(Program):
    """A program that is a node, of which the master knows nothing any more when it has ended."""

    def __init__(self, stage, name, command, log, environment):
        self.stage, self.name = stage, name
        super().__init__(command, {**stage.environment, **(environment or {})}, log)

    def end(self, patience_secs=5.0):
        super().end(patience_secs)
        self.stage.forget(self.name)


def _environment(folder, plugin_prefix, packages):
    """The environment of a stage's programs: nothing of the user's but locale, path and where ROS is installed."""
    home = folder / "home"
    runtime = folder / "runtime"
    for each in (home, runtime):
        each.mkdir(exist_ok=True)
        each.chmod(0o700)
    ros = [prefix for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(":") if prefix] or ["/usr"]
    prefixes = ([str(plugin_prefix)] if plugin_prefix else []) + ros
    folders = [f"{plugin_prefix}/share"] if plugin_prefix else []
    folders += [str(package) for package in packages] + [f"{prefix}/share" for prefix in ros]
    kept = ("LANG", "LC_ALL", "PYTHONPATH", "LD_LIBRARY_PATH", "ROS_ROOT", "ROS_DISTRO", "ROS_ETC_DIR", "ROS_VERSION")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    environment.update({
        "HOME": str(home),
        "XDG_RUNTIME_DIR": str(runtime),
        "PATH": ":".join([f"{prefix}/bin" for prefix in ros] + ["/usr/bin:/bin"]),
        "ROS_HOME": str(home / ".ros"),
        "ROS_HOSTNAME": "127.0.0.1",
        "ROS_PACKAGE_PATH": ":".join(folders),
        "CMAKE_PREFIX_PATH": ":".join(prefixes),
        # Mesa's software renderer, whatever graphics the machine has.
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "GALLIUM_DRIVER": "llvmpipe",
        "QT_QPA_PLATFORM": "xcb",
        # Qt would scale rviz's fonts and window to the screen.
        "QT_AUTO_SCREEN_SCALE_FACTOR": "0",
    })
    return environment
