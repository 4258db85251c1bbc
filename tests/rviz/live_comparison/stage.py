"""rviz with the plugin on a stage of its own, with a simulated clock.

The clock stands still except when a scene sets it, so that nothing ages while programs draw, however slow they are.
"""

import os
import threading

import rospy
from rosgraph_msgs.msg import Clock
from golden.scenes.rviz_runner import Stage

START_SECS = 1000.0
TICK_SECS = 0.05
RVIZ = 'rviz'
# rviz keeps something of each scene (frames, materials), and another one starts within seconds.
SCENES_PER_RVIZ = 40
EMPTY = """Panels: []
Visualization Manager:
  Displays: []
  Global Options: {Fixed Frame: map, Frame Rate: 10}
  Tools: [{Class: rviz/Interact, Hide Inactive Objects: true}]
Window Geometry: {Height: 120, Width: 160, X: 0, Y: 0}
"""


class LiveStage:
    """A stage with rviz and the clock. A process can have one only, because it is a node of that stage's master."""

    def __init__(self, folder, plugin_prefix, packages, camera_stream, renderers):
        """folder: for logs and scenes; must be this stage's own. plugin_prefix, packages: as of `Stage`.

        camera_stream: the program; renderers: those that it draws with, one program each.
        """
        self.folder, self.camera_stream, self.renderers = folder, camera_stream, renderers
        self.stage = Stage(folder, plugin_prefix, packages)
        self.stage.set_parameter('/use_sim_time', True)
        self.rviz, self.scenes_of_rviz = None, 0
        self.now = START_SECS
        # rospy reads these at its start.
        os.environ.update({name: self.stage.environment[name] for name in ('ROS_MASTER_URI', 'ROS_HOME', 'ROS_HOSTNAME')})
        rospy.init_node('publisher', disable_signals=True, disable_rosout=True)
        self.clock = rospy.Publisher('/clock', Clock, queue_size=10)
        self.ended = threading.Event()
        self.ticking = threading.Thread(target=self._tick, daemon=True)
        self.ticking.start()

    def _tick(self):
        while not self.ended.wait(TICK_SECS):
            self.clock.publish(Clock(rospy.Time.from_sec(self.now)))

    def set_time(self, secs):
        self.now = secs
        self.clock.publish(Clock(rospy.Time.from_sec(secs)))

    def ready_rviz(self):
        """An rviz that runs and has not drawn too many scenes."""
        if self.rviz is not None and self.rviz.is_running() and self.scenes_of_rviz < SCENES_PER_RVIZ:
            return
        self.end_rviz()
        config = self.folder / 'empty.rviz'
        config.write_text(EMPTY)
        self.rviz, self.scenes_of_rviz = self.stage.rviz(config, RVIZ), 0

    def end_rviz(self):
        if self.rviz is not None:
            self.rviz.end()
        self.rviz = None

    def end(self):
        self.ended.set()
        self.ticking.join()
        rospy.signal_shutdown('the comparison has ended')
        self.end_rviz()
        self.stage.end()
