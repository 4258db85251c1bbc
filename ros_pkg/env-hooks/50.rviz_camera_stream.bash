# Completes what stands behind `rosrun rviz_camera_stream PROGRAM` and lets man find the programs' pages, in a shell that a user
# types in. setup.bash sources this; with Debian's own ROS, which has none, a line in ~/.bashrc does.

_rviz_camera_stream_shares=("${CATKIN_ENV_HOOK_WORKSPACE:-/usr}/share" /usr/share)
_rviz_camera_stream_rosrun() {
  local share file program=${COMP_WORDS[2]:-}
  if ((COMP_CWORD > 2)) && [[ ${COMP_WORDS[1]} == rviz_camera_stream ]]; then
    for share in "${_rviz_camera_stream_shares[@]}"; do
      file=$share/bash-completion/completions/$program
      if [[ -f $file ]]; then
        source "$file"
        local COMP_WORDS=("${COMP_WORDS[@]:2}") COMP_CWORD=$((COMP_CWORD - 2))
        "_$program" "$program" "$2" "$3"
        return
      fi
    done
  fi
  _roscomplete_exe
}
if [[ $- == *i* ]]; then
  if ! declare -F _roscomplete_exe >/dev/null && [[ -f /usr/share/bash-completion/completions/rosbash ]]; then
    source /usr/share/bash-completion/completions/rosbash
  fi
  if [[ -f $_rviz_camera_stream_shares/man/man1/camera_stream.1 && :${MANPATH:-}: != *":$_rviz_camera_stream_shares/man:"* ]]; then
    # An empty entry at the end stands for the system's.
    export MANPATH=$_rviz_camera_stream_shares/man:${MANPATH:-}
  fi
  complete -o bashdefault -o default -F _rviz_camera_stream_rosrun rosrun
fi
