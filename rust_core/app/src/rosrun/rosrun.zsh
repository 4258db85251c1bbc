#compdef rosrun
# Completes what stands behind `rosrun rviz_camera_stream PROGRAM` as behind PROGRAM, and all else as rosbash does.
if ((CURRENT > 3)) && [[ $words[2] == rviz_camera_stream ]]; then
  shift 2 words
  ((CURRENT -= 2))
  _normal
else
  _default
fi
