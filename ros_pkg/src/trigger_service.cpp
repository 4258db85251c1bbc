#include "trigger_service.h"

#include <map>
#include <vector>

#include <ros/exceptions.h>
#include <std_srvs/Trigger.h>

namespace rviz_camera_stream
{
/// A service of this process, with the displays that it triggers. A destroyed display leaves an expired entry.
class TriggerService::Shared
{
public:
  explicit Shared(ros::NodeHandle& handle)
  {
    server_ = handle.advertiseService("camera_trigger", &Shared::call, this);
    if (!server_)
      throw ros::Exception("another service of this process has the name " + handle.resolveName("camera_trigger"));
  }

  /// The service of the handle's namespace, which is started if necessary.
  static std::shared_ptr<Shared> of(ros::NodeHandle& handle)
  {
    static std::map<std::string, std::weak_ptr<Shared>> services;
    std::weak_ptr<Shared>& place = services[handle.resolveName("camera_trigger")];
    std::shared_ptr<Shared> shared = place.lock();
    if (!shared)
    {
      shared = std::make_shared<Shared>(handle);
      place = shared;
    }
    return shared;
  }

  void add(const std::shared_ptr<Trigger>& trigger)
  {
    triggers_.push_back(trigger);
  }

  /// The triggers of existing displays.
  std::vector<std::shared_ptr<Trigger>> triggers()
  {
    std::vector<std::shared_ptr<Trigger>> present;
    std::vector<std::weak_ptr<Trigger>> remaining;
    for (const std::weak_ptr<Trigger>& trigger : triggers_)
    {
      if (std::shared_ptr<Trigger> locked = trigger.lock())
      {
        present.push_back(locked);
        remaining.push_back(trigger);
      }
    }
    triggers_.swap(remaining);
    return present;
  }

private:
  bool call(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response)
  {
    response.success = false;
    for (const std::shared_ptr<Trigger>& trigger : triggers())
    {
      std::string message;
      response.success |= (*trigger)(message);
      response.message += (response.message.empty() ? "" : "\n") + message;
    }
    return true;
  }

  ros::ServiceServer server_;
  std::vector<std::weak_ptr<Trigger>> triggers_;
};

void TriggerService::join(ros::NodeHandle& handle, const Trigger& trigger)
{
  // Before leaving the old service: if both have one name, there is no gap.
  const std::shared_ptr<Shared> shared = Shared::of(handle);
  trigger_ = std::make_shared<Trigger>(trigger);
  shared->add(trigger_);
  shared_ = shared;
}

void TriggerService::leave()
{
  trigger_.reset();
  shared_.reset();
}
}  // namespace rviz_camera_stream
