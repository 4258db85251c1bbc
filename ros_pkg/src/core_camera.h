// Owner of the Rust core's camera, see rviz_camera_stream/core.h.
#ifndef RVIZ_CAMERA_STREAM_CORE_CAMERA_H
#define RVIZ_CAMERA_STREAM_CORE_CAMERA_H

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <sensor_msgs/CameraInfo.h>

#include "rviz_camera_stream/core.h"

namespace rviz_camera_stream
{
/// Settings for the view of a CameraInfo.
struct CameraModel
{
  RcsProjection projection = RCS_PROJECTION_RVIZ;
  bool undistort = false;
  double near_m = 0.01;
};

inline bool operator==(const CameraModel& a, const CameraModel& b)
{
  return a.projection == b.projection && a.undistort == b.undistort && a.near_m == b.near_m;
}

/// Time of the clock for pacing and statistics, in nanoseconds.
inline uint64_t monotonicNow()
{
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

/// Error of the core's last failed call on this thread.
std::string coreError();

/// An RcsCamera. Used by one thread at a time.
class CoreCamera
{
public:
  /// Throws std::bad_alloc if there is no memory.
  CoreCamera();

  RcsCamera* get() const
  {
    return camera_.get();
  }

  /// Computes the view of a CameraInfo. Returns an error, or an empty text.
  std::string setInfo(const sensor_msgs::CameraInfo& info, const CameraModel& model, RcsView& view);

  /// Reasons why a projection with this CameraInfo misses its objects, or an empty text.
  std::string warning() const;

  /// Rate and durations of the last pictures in one line.
  std::string statistics(uint64_t now_ns) const;

private:
  struct Free
  {
    void operator()(RcsCamera* camera) const
    {
      rcs_camera_free(camera);
    }
  };
  std::unique_ptr<RcsCamera, Free> camera_;
};
}  // namespace rviz_camera_stream

#endif
