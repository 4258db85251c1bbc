// The Rust core's state for one camera, owned: see rviz_camera_stream/core.h for what each function means.
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
/// What decides how a CameraInfo becomes a picture.
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

/// The clock of pacing and statistics, in nanoseconds.
inline uint64_t monotonicNow()
{
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

/// Why the core refused the last call on this thread.
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

  /// Computes the view of a CameraInfo. Returns an empty text, or why it cannot be drawn.
  std::string setInfo(const sensor_msgs::CameraInfo& info, const CameraModel& model, RcsView& view);

  /// What makes a projector with this CameraInfo miss, or an empty text.
  std::string warning() const;

  /// Rate and times of the last pictures in one line.
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
