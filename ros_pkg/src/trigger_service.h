// The service that triggers CameraPub displays.
#ifndef RVIZ_CAMERA_STREAM_TRIGGER_SERVICE_H
#define RVIZ_CAMERA_STREAM_TRIGGER_SERVICE_H

#include <functional>
#include <memory>
#include <string>

#include <ros/node_handle.h>

namespace rviz_camera_stream
{
/// A display's membership of the service `camera_trigger` in its namespace (std_srvs/Trigger). Displays of one
/// namespace share the service: a call triggers all of them, and it ends with the last one. Used on the thread that
/// spins ROS's global queue, which is rviz's main loop.
class TriggerService
{
public:
  /// Requests a picture. Sets the answer's message, returns true if a picture follows.
  using Trigger = std::function<bool(std::string& message)>;

  /// Joins the service of the handle's namespace, which is started by the first display. Throws ros::Exception if the
  /// service's name is invalid or used by another service of this process.
  void join(ros::NodeHandle& handle, const Trigger& trigger);

  /// Leaves the service, which ends with the last display.
  void leave();

private:
  class Shared;
  std::shared_ptr<Shared> shared_;
  std::shared_ptr<Trigger> trigger_;
};
}  // namespace rviz_camera_stream

#endif
