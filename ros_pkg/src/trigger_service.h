// The service that asks CameraPub displays for one picture.
#ifndef RVIZ_CAMERA_STREAM_TRIGGER_SERVICE_H
#define RVIZ_CAMERA_STREAM_TRIGGER_SERVICE_H

#include <functional>
#include <memory>
#include <string>

#include <ros/node_handle.h>

namespace rviz_camera_stream
{
/// A display's place at the service `camera_trigger` of its namespace (std_srvs/Trigger). Displays of one namespace share
/// the service: a call triggers all of them, and it stays until the last of them leaves. Used on the thread that spins
/// ROS's global queue, as rviz's main loop does.
class TriggerService
{
public:
  /// Is asked for a picture. Sets the answer's message, returns whether a picture will come.
  using Trigger = std::function<bool(std::string& message)>;

  /// Joins the service of the handle's namespace, which begins with the first display. Throws ros::Exception where the
  /// service's name is invalid or another service of this process has it.
  void join(ros::NodeHandle& handle, const Trigger& trigger);

  /// Leaves the service, which ends with the last display.
  void leave();

  /// The other displays that share the service.
  size_t others() const;

private:
  class Shared;
  std::shared_ptr<Shared> shared_;
  std::shared_ptr<Trigger> trigger_;
};
}  // namespace rviz_camera_stream

#endif
