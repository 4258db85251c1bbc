"""The scenes of the golden cases as scripts, and the recording of what the real rviz draws of them.

`scene` and `displays` say what a scene is, `messages`, `geometry`, `clouds`, `images` and `interaction` make its contents,
`subjects` holds the cases, one module for each subject. `rviz_runner` and `recorder` start rviz with the plugin, play a scene
and take the picture.
"""
