#include "core_camera.h"

#include <algorithm>
#include <new>

#include "core_text.h"

namespace rviz_camera_stream
{
std::string coreError()
{
  return coreText([](char* buffer, size_t length) { return rcs_last_error(buffer, length); });
}

CoreCamera::CoreCamera() : camera_(rcs_camera_new())
{
  if (!camera_)
    throw std::bad_alloc();
}

std::string CoreCamera::setInfo(const sensor_msgs::CameraInfo& info, const CameraModel& model, RcsView& view)
{
  RcsCameraInfo plain{};
  plain.width = info.width;
  plain.height = info.height;
  plain.distortion_model = info.distortion_model.c_str();
  plain.d = info.D.data();
  plain.d_length = info.D.size();
  std::copy(info.K.begin(), info.K.end(), plain.k);
  std::copy(info.R.begin(), info.R.end(), plain.r);
  std::copy(info.P.begin(), info.P.end(), plain.p);
  plain.binning_x = info.binning_x;
  plain.binning_y = info.binning_y;
  plain.roi_x_offset = info.roi.x_offset;
  plain.roi_y_offset = info.roi.y_offset;
  plain.roi_width = info.roi.width;
  plain.roi_height = info.roi.height;
  const RcsResult result =
      rcs_camera_set_info(camera_.get(), &plain, model.projection, model.undistort, model.near_m, &view);
  return result == RCS_RESULT_OK ? std::string() : coreError();
}

std::string CoreCamera::warning() const
{
  return coreText([this](char* buffer, size_t length) { return rcs_camera_warning(camera_.get(), buffer, length); });
}

std::string CoreCamera::statistics(uint64_t now_ns) const
{
  return coreText([this, now_ns](char* buffer, size_t length) {
    return rcs_camera_statistics(camera_.get(), now_ns, buffer, length);
  });
}
}  // namespace rviz_camera_stream
