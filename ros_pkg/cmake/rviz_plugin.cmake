# The rviz plugin CameraPub: a C++ library that draws with rviz's Ogre and leaves decisions and pixels to the Rust core's
# C interface. Built where rviz's development files are; a robot without them gets the programs alone.
#
# Cache variables:
#   RVIZ_CAMERA_STREAM_PLUGIN  AUTO (default): built if rviz is found; ON: an error if it is not; OFF: never built
#
# Reads: prebuilt, or cargo_environment, rustc_program, workspace_root and the target folder of built_programs.cmake.
set(RVIZ_CAMERA_STREAM_PLUGIN AUTO CACHE STRING "Build the rviz plugin CameraPub: AUTO, ON or OFF")
set_property(CACHE RVIZ_CAMERA_STREAM_PLUGIN PROPERTY STRINGS AUTO ON OFF)

if(RVIZ_CAMERA_STREAM_PLUGIN STREQUAL "OFF")
  message(STATUS "rviz_camera_stream: the rviz plugin is not built (RVIZ_CAMERA_STREAM_PLUGIN is OFF)")
  return()
endif()

set(plugin_missing)
foreach(package rviz image_transport pluginlib roscpp sensor_msgs std_srvs)
  find_package(${package} QUIET)
  if(NOT ${package}_FOUND)
    list(APPEND plugin_missing ${package})
  endif()
endforeach()
set(OpenGL_GL_PREFERENCE GLVND)
find_package(OpenGL QUIET)
if(NOT OPENGL_FOUND)
  list(APPEND plugin_missing OpenGL)
endif()
# The Qt that rviz was built with, 5 or 6.
if(rviz_FOUND)
  string(REGEX MATCH "^[0-9]+" plugin_qt "${rviz_QT_VERSION}")
  find_package(Qt${plugin_qt} ${rviz_QT_VERSION} QUIET COMPONENTS Core Widgets)
  if(NOT Qt${plugin_qt}_FOUND)
    list(APPEND plugin_missing "Qt ${rviz_QT_VERSION}")
  endif()
endif()
if(prebuilt AND NOT EXISTS "${prebuilt}/lib/rviz_camera_stream/librcs_capi.tar.xz")
  list(APPEND plugin_missing "${prebuilt}/lib/rviz_camera_stream/librcs_capi.tar.xz")
endif()
if(plugin_missing)
  string(REPLACE ";" ", " plugin_missing "${plugin_missing}")
  if(RVIZ_CAMERA_STREAM_PLUGIN STREQUAL "ON")
    message(FATAL_ERROR "The rviz plugin needs ${plugin_missing}. Get them with: apt install librviz-dev \
libimage-transport-dev (Debian) or apt install ros-$ROS_DISTRO-rviz (Ubuntu), and the Qt of rviz: qtbase5-dev or qt6-base-dev")
  endif()
  message(STATUS "rviz_camera_stream: the rviz plugin is not built, as these were not found: ${plugin_missing}")
  return()
endif()
message(STATUS "rviz_camera_stream: the rviz plugin is built for rviz ${rviz_VERSION}, Qt ${rviz_QT_VERSION}")

# --- the Rust core as a static library --------------------------------------------------------------------------------

if(prebuilt)
  # An installed package has it beside the programs, packed.
  set(plugin_core "${CMAKE_CURRENT_BINARY_DIR}/librcs_capi.a")
  set(packed_core "${prebuilt}/lib/rviz_camera_stream/librcs_capi.tar.xz")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${packed_core}")
  execute_process(COMMAND "${CMAKE_COMMAND}" -E tar xf "${packed_core}"
    WORKING_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}" RESULT_VARIABLE plugin_unpacked)
  if(plugin_unpacked)
    message(FATAL_ERROR "${packed_core} cannot be unpacked; install the package again")
  endif()
  add_custom_target(rviz_camera_stream_core)
else()
  set(plugin_core "${RVIZ_CAMERA_STREAM_TARGET_DIR}/release/librcs_capi.a")
  # Together with the programs' library, which is built anyway: alone, it would ask for fewer features of what both depend on,
  # and cargo would build all of that twice.
  add_custom_target(rviz_camera_stream_core
    COMMAND "${CMAKE_COMMAND}" -E env --unset=MAKEFLAGS --unset=MFLAGS --unset=MAKELEVEL ${cargo_environment}
      "CARGO_TARGET_DIR=${RVIZ_CAMERA_STREAM_TARGET_DIR}" "RUSTC=${rustc_program}"
      "${RVIZ_CAMERA_STREAM_CARGO}" build --release --locked -p rcs_app -p rcs_capi --lib
    BYPRODUCTS "${plugin_core}"
    WORKING_DIRECTORY "${workspace_root}"
    COMMENT "cargo builds the rviz plugin's core"
    VERBATIM)
endif()

# --- the plugin -------------------------------------------------------------------------------------------------------

# Without a build type nothing would be optimised. Not in the cache: other packages of the workspace have their own.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_package(Threads REQUIRED)
add_library(rviz_camera_stream SHARED
  src/camera_pub.cpp src/camera_pub_properties.cpp src/core_camera.cpp src/headless_twin.cpp src/picture_publisher.cpp
  src/pixel_reader.cpp src/scene_camera.cpp src/trigger_service.cpp src/camera_pub.h)
add_dependencies(rviz_camera_stream rviz_camera_stream_core)
# All files as one: they include the same headers of rviz, which take most of the time to compile. (CMake 3.16 or newer.)
# What moc writes names the header by its place below src, not by that seen from the build folder.
set_target_properties(rviz_camera_stream PROPERTIES AUTOMOC ON AUTOMOC_PATH_PREFIX ON UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0
  LIBRARY_OUTPUT_DIRECTORY "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_LIB_DESTINATION}")
# Qt's short names for signals and slots clash with Boost's.
target_compile_definitions(rviz_camera_stream PRIVATE QT_NO_KEYWORDS)
target_compile_options(rviz_camera_stream PRIVATE -Wall -Wextra)
target_include_directories(rviz_camera_stream PRIVATE include src)
target_include_directories(rviz_camera_stream SYSTEM PRIVATE ${rviz_INCLUDE_DIRS} ${image_transport_INCLUDE_DIRS}
  ${pluginlib_INCLUDE_DIRS} ${roscpp_INCLUDE_DIRS} ${OPENGL_INCLUDE_DIR})
# What Rust's standard library needs comes last; none of its names leave the plugin.
target_link_libraries(rviz_camera_stream PRIVATE "${plugin_core}" ${rviz_LIBRARIES} ${image_transport_LIBRARIES}
  ${pluginlib_LIBRARIES} ${roscpp_LIBRARIES} Qt${plugin_qt}::Widgets ${OPENGL_LIBRARIES} Threads::Threads ${CMAKE_DL_LIBS} m
  "-Wl,--exclude-libs,librcs_capi.a" "-Wl,--gc-sections")

# A component of its own, so that it can be installed alone; package.xml, by which rviz finds it, belongs to both.
install(TARGETS rviz_camera_stream LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION} COMPONENT rviz_plugin)
install(FILES package.xml plugin_description.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION} COMPONENT rviz_plugin)
install(DIRECTORY icons DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION} COMPONENT rviz_plugin)
