# Completes what stands behind `rosrun rviz_camera_stream PROGRAM` as behind PROGRAM.
function __rviz_camera_stream_words
    set -l words (commandline -opc)
    test "$words[2]" = rviz_camera_stream; and test (count $words) -ge 3
    and string join ' ' -- (string escape -- $words[3..-1]) (commandline -ct)
end
complete -c rosrun -n __rviz_camera_stream_words -xa '(complete -C (__rviz_camera_stream_words))'
