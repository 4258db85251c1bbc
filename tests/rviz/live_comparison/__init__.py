"""Random scenes that rviz with the plugin and `camera_stream` draw side by side, and the comparison of their pictures.

`scene` and `generator` make a scene from a seed, with the displays of `clouds`, `markers`, `poses`, `sensors` and `robots`,
the faulty messages of `spoil`, and the cameras of `view`. `stage` has rviz and the clock, `performance` has
both programs draw a scene, `comparison` judges.
"""
