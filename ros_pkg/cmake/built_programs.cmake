# Has cargo build the programs, copies them to the devel space, and installs them with their man pages and completions.
#
# Reads: workspace_root, programs, devel_programs, cargo_environment, rustc_program, RVIZ_CAMERA_STREAM_CARGO.
# Cache: RVIZ_CAMERA_STREAM_TARGET_DIR.
#
#catkin_lint: ignore env_var missing_file

set(default_target_dir "${CMAKE_CURRENT_BINARY_DIR}/cargo")
if(NOT "$ENV{CARGO_TARGET_DIR}" STREQUAL "")
  set(default_target_dir "$ENV{CARGO_TARGET_DIR}")
endif()
set(RVIZ_CAMERA_STREAM_TARGET_DIR "${default_target_dir}" CACHE PATH "cargo's build folder")
set(built "${RVIZ_CAMERA_STREAM_TARGET_DIR}/release")
set(help "${CMAKE_CURRENT_BINARY_DIR}/help")

# Every build calls cargo, which knows what has changed. make's job server is not available to custom commands, so cargo
# must not see its variables.
set(copies)
foreach(program ${programs})
  # A link to an installed program, from a build that took those, must not be written through.
  if(IS_SYMLINK "${devel_programs}/${program}")
    file(REMOVE "${devel_programs}/${program}")
  endif()
  list(APPEND copies COMMAND "${CMAKE_COMMAND}" -E copy_if_different "${built}/${program}" "${devel_programs}/${program}")
endforeach()
add_custom_target(rviz_camera_stream_programs ALL
  COMMAND "${CMAKE_COMMAND}" -E env --unset=MAKEFLAGS --unset=MFLAGS --unset=MAKELEVEL ${cargo_environment}
    "CARGO_TARGET_DIR=${RVIZ_CAMERA_STREAM_TARGET_DIR}" "RUSTC=${rustc_program}"
    "${RVIZ_CAMERA_STREAM_CARGO}" build --release --locked -p rcs_app --bins
  COMMAND "${CMAKE_COMMAND}" -E make_directory "${devel_programs}"
  ${copies}
  COMMAND "${built}/all_programs" --write-help "${help}"
  COMMAND "${built}/all_programs" --write-help "${CATKIN_DEVEL_PREFIX}/share"
  WORKING_DIRECTORY "${workspace_root}"
  COMMENT "cargo builds the nodes (the first time this takes minutes)"
  VERBATIM)

foreach(program ${programs})
  install(PROGRAMS "${built}/${program}" DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endforeach()
# The build writes it.
#catkin_lint: ignore_once missing_directory
install(DIRECTORY "${help}/" DESTINATION ${CATKIN_GLOBAL_SHARE_DESTINATION})
