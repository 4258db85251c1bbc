# Finds cargo and a rustc that is new enough, or reports in one line what is missing and how to get it.
#
# Reads: workspace_root. Cache: RVIZ_CAMERA_STREAM_CARGO. Sets: RVIZ_CAMERA_STREAM_CARGO, rustc_program.
#
#catkin_lint: ignore env_var

file(STRINGS "${workspace_root}/Cargo.toml" rust_version_line REGEX "^rust-version *=")
string(REGEX REPLACE ".*\"([0-9.]+)\".*" "\\1" rust_version_needed "${rust_version_line}")
if(NOT rust_version_needed MATCHES "^[0-9]+[.][0-9.]+$")
  message(FATAL_ERROR "${workspace_root}/Cargo.toml: no rust-version; the package needs the whole repository around ros_pkg")
endif()
set(how_to_get_rust "Get it with: curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y  (or, with rustup \
installed: rustup update stable), then build again from a new shell. \
If it is installed elsewhere: -DRVIZ_CAMERA_STREAM_CARGO=/path/to/cargo")

# rustup's cargo is preferred: the distribution's is often too old, and /usr/bin often comes first on ROS machines.
find_program(RVIZ_CAMERA_STREAM_CARGO cargo HINTS "$ENV{CARGO_HOME}/bin" "$ENV{HOME}/.cargo/bin"
  DOC "The cargo that builds the Rust programs")
if(NOT RVIZ_CAMERA_STREAM_CARGO)
  unset(RVIZ_CAMERA_STREAM_CARGO CACHE)
  message(FATAL_ERROR "No Rust toolchain: found no cargo in ~/.cargo/bin or on PATH; \
rviz_camera_stream needs Rust ${rust_version_needed} or newer. ${how_to_get_rust}")
endif()
get_filename_component(cargo_folder "${RVIZ_CAMERA_STREAM_CARGO}" DIRECTORY)
find_program(rustc_program rustc HINTS "${cargo_folder}")
mark_as_advanced(rustc_program)
set(rustc_output "no rustc beside ${RVIZ_CAMERA_STREAM_CARGO} or on PATH")
if(rustc_program)
  execute_process(COMMAND "${rustc_program}" --version WORKING_DIRECTORY "${workspace_root}"
    OUTPUT_VARIABLE rustc_output ERROR_VARIABLE rustc_output OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_STRIP_TRAILING_WHITESPACE)
endif()
if(NOT rustc_output MATCHES "^rustc ([0-9]+[.][0-9]+[.][0-9]+)")
  unset(rustc_program CACHE)
  unset(RVIZ_CAMERA_STREAM_CARGO CACHE)
  message(FATAL_ERROR "The Rust toolchain of ${cargo_folder} does not work: ${rustc_output}; \
rviz_camera_stream needs Rust ${rust_version_needed} or newer. ${how_to_get_rust}")
endif()
set(rust_version_found "${CMAKE_MATCH_1}")
if(rust_version_found VERSION_LESS rust_version_needed)
  # Not cached, so that the next run looks again.
  set(old_rustc "${rustc_program}")
  unset(rustc_program CACHE)
  unset(RVIZ_CAMERA_STREAM_CARGO CACHE)
  message(FATAL_ERROR "The Rust toolchain is too old: ${old_rustc} is ${rust_version_found}; \
rviz_camera_stream needs Rust ${rust_version_needed} or newer. ${how_to_get_rust}")
endif()
message(STATUS "rviz_camera_stream: Rust ${rust_version_found} (${RVIZ_CAMERA_STREAM_CARGO})")
