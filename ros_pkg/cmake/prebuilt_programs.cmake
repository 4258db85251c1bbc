# Takes the programs of an installed package: links to them in the devel space, and installs them.
#
# Reads: prebuilt, programs, devel_programs.
#
#catkin_lint: ignore external_file missing_file

set(prebuilt_programs "${prebuilt}/lib/rviz_camera_stream")
set(links)
foreach(program ${programs})
  list(APPEND links COMMAND "${CMAKE_COMMAND}" -E create_symlink "${prebuilt_programs}/${program}" "${devel_programs}/${program}")
endforeach()
add_custom_target(rviz_camera_stream_programs ALL
  COMMAND "${CMAKE_COMMAND}" -E make_directory "${devel_programs}"
  ${links}
  COMMENT "Links to the programs of ${prebuilt}"
  VERBATIM)

# Each program is a link to the file that holds all.
foreach(program all_programs ${programs})
  install(PROGRAMS "${prebuilt_programs}/${program}" DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endforeach()
