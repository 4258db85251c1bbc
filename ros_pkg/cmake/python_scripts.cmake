# Installs the scripts in Python for the Python of this ROS: they name Python 3; with Melodic, whose rospy is of Python 2,
# the devel space and the install space get copies that name Python 2.
#
# Reads: python_scripts, devel_programs. Cache: RVIZ_CAMERA_STREAM_PYTHON.

set(default_python /usr/bin/python3)
if(PYTHON_VERSION_MAJOR EQUAL 2)
  set(default_python /usr/bin/python2)
endif()
set(RVIZ_CAMERA_STREAM_PYTHON "${default_python}" CACHE FILEPATH "the Python that runs this package's scripts")

foreach(script ${python_scripts})
  if(RVIZ_CAMERA_STREAM_PYTHON STREQUAL "/usr/bin/python3")
    install(PROGRAMS ${script} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  else()
    get_filename_component(name "${script}" NAME)
    set(copy "${CMAKE_CURRENT_BINARY_DIR}/scripts/${name}")
    file(READ "${script}" text)
    string(REGEX REPLACE "^#![^\n]*" "#!${RVIZ_CAMERA_STREAM_PYTHON}" text "${text}")
    file(WRITE "${copy}" "${text}")
    install(PROGRAMS "${copy}" DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
    file(COPY "${copy}" DESTINATION "${devel_programs}" FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
      GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endif()
endforeach()
