"""Tests of the rviz plugin CameraPub in a real rviz, on a screen and a master of their own.

`driver` is a display that operates rviz from outside; `window` starts rviz with it, `camera_topics` are the topics of a camera.

    python3 -m unittest discover -s tests -t tests -p 'test_*.py'     with RVIZ_PLUGIN_PREFIX, see `stage`
"""
