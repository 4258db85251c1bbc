# Looks for an installed package of this version, from which programs and core are taken in place of building them.
#
# Such a package has the file share/rviz_camera_stream/prebuilt with its version. Cache: RVIZ_CAMERA_STREAM_PREBUILT.
# Sets: prebuilt, the prefix of what is taken, or nothing.
#
#catkin_lint: ignore env_var

set(RVIZ_CAMERA_STREAM_PREBUILT "AUTO" CACHE STRING "AUTO, OFF, or the prefix of an installed rviz_camera_stream")
set(needed_version "${rviz_camera_stream_VERSION}")
set(prebuilt)

# Sets the variable to the version of what is installed below the prefix, or to nothing.
function(read_prebuilt_version prefix variable)
  set(version)
  if(EXISTS "${prefix}/share/rviz_camera_stream/prebuilt" AND EXISTS "${prefix}/lib/rviz_camera_stream/all_programs")
    file(STRINGS "${prefix}/share/rviz_camera_stream/prebuilt" version LIMIT_COUNT 1)
  endif()
  set(${variable} "${version}" PARENT_SCOPE)
endfunction()

if(RVIZ_CAMERA_STREAM_PREBUILT STREQUAL "AUTO")
  # With a toolchain that was chosen, the sources are meant.
  if(NOT RVIZ_CAMERA_STREAM_CARGO)
    string(REPLACE ":" ";" environment_prefixes "$ENV{CMAKE_PREFIX_PATH}")
    foreach(prefix ${CMAKE_PREFIX_PATH} ${environment_prefixes} "/opt/ros/$ENV{ROS_DISTRO}" /usr)
      if(NOT prebuilt AND NOT prefix STREQUAL CMAKE_INSTALL_PREFIX AND NOT prefix STREQUAL CATKIN_DEVEL_PREFIX)
        read_prebuilt_version("${prefix}" found_version)
        if(found_version STREQUAL needed_version AND found_version)
          set(prebuilt "${prefix}")
        elseif(found_version)
          message(STATUS "rviz_camera_stream: the package in ${prefix} is ${found_version}, this is ${needed_version}; \
the programs are built from source")
        endif()
      endif()
    endforeach()
  endif()
elseif(RVIZ_CAMERA_STREAM_PREBUILT)
  get_filename_component(prebuilt "${RVIZ_CAMERA_STREAM_PREBUILT}" ABSOLUTE)
  read_prebuilt_version("${prebuilt}" found_version)
  if(NOT found_version)
    message(FATAL_ERROR "RVIZ_CAMERA_STREAM_PREBUILT: no rviz_camera_stream is installed in ${prebuilt}; it is the prefix of \
the package (/opt/ros/noetic, /usr), or the folder of the tarball")
  elseif(NOT found_version STREQUAL needed_version)
    message(FATAL_ERROR "RVIZ_CAMERA_STREAM_PREBUILT: the package in ${prebuilt} is ${found_version}, this source is \
${needed_version}; use the source of that version, or build with -DRVIZ_CAMERA_STREAM_PREBUILT=OFF")
  endif()
endif()
if(prebuilt)
  message(STATUS "rviz_camera_stream: takes the programs of ${prebuilt} (${needed_version}); \
-DRVIZ_CAMERA_STREAM_PREBUILT=OFF builds them from source")
endif()
