// A camera that works as plainly as can be, to compare with.
#ifndef RVIZ_TEST_DRIVER_PLAIN_CAMERA_H
#define RVIZ_TEST_DRIVER_PLAIN_CAMERA_H

#include <string>

#include <OgreTexture.h>
#include <image_transport/image_transport.h>
#include <ros/subscriber.h>
#include <rviz/display.h>
#include <sensor_msgs/CameraInfo.h>

namespace Ogre
{
class Camera;
class RenderTexture;
class SceneNode;
}  // namespace Ogre

namespace rviz
{
class StringProperty;
}

namespace rviz_test_driver
{
/// Draws with each of rviz's frames, waits for the pixels, and converts and publishes them on rviz's main thread, whether or
/// not somebody subscribes. That is how the plugin worked that CameraPub replaces; the benchmark compares with it.
/// Shows all displays; P with one focal length and no offset.
class PlainCamera : public rviz::Display
{
  Q_OBJECT

public:
  PlainCamera();
  ~PlainCamera() override;
  void update(float wall_dt, float ros_dt) override;

protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

private:
  void createTexture(unsigned width, unsigned height);
  void removeTexture();
  bool place();
  void publish();

  rviz::StringProperty* image_topic_;
  rviz::StringProperty* info_topic_;
  ros::Subscriber subscriber_;
  image_transport::CameraPublisher publisher_;
  sensor_msgs::CameraInfo::ConstPtr info_;
  Ogre::Camera* camera_ = nullptr;
  Ogre::SceneNode* node_ = nullptr;
  Ogre::TexturePtr texture_;
  Ogre::RenderTexture* target_ = nullptr;
};
}  // namespace rviz_test_driver

#endif
