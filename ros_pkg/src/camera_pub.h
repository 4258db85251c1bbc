// The display CameraPub: a camera in rviz's scene that publishes images.
#ifndef RVIZ_CAMERA_STREAM_CAMERA_PUB_H
#define RVIZ_CAMERA_STREAM_CAMERA_PUB_H

#include <memory>
#include <string>

#include <OgreFrameListener.h>
#include <QTimer>
#include <ros/message_event.h>
#include <ros/subscriber.h>
#include <rviz/display.h>
#include <sensor_msgs/CameraInfo.h>

#include "core_camera.h"
#include "headless_twin.h"
#include "picture_publisher.h"
#include "pixel_reader.h"
#include "scene_camera.h"
#include "trigger_service.h"

namespace rviz
{
class BoolProperty;
class ColorProperty;
class DisplayGroupVisibilityProperty;
class EnumProperty;
class FloatProperty;
class IntProperty;
class RosTopicProperty;
class StringProperty;
}  // namespace rviz

namespace rviz_camera_stream
{
/// Draws rviz's scene from a CameraInfo's camera and publishes the image. Properties, their defaults and saved configs
/// are compatible with the plugin that this one replaces; added properties are saved only if used. Runs on rviz's main
/// thread, except for the conversion and publishing of finished pictures.
class CameraPub : public rviz::Display, public Ogre::FrameListener
{
  Q_OBJECT

public:
  CameraPub();
  ~CameraPub() override;

  void update(float wall_dt, float ros_dt) override;
  void reset() override;
  void setTopic(const QString& topic, const QString& datatype) override;

  /// Publishes a picture that was read back while rviz's window was drawn.
  bool frameEnded(const Ogre::FrameEvent& event) override;

protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

private Q_SLOTS:
  /// Changes of output or input topics are applied with the next frame, all changes of a loading config at once: a
  /// subscriber may miss one of several changes in a row.
  void updateOutput();
  void updateInput();
  void updateNamespace();
  void updateFrameRate();
  void updatePicture();
  void updateTwin();
  /// Publishes the picture that is being read back, or polls again.
  void collect();
  /// Handles a change of rviz's config.
  void configChanged();
  void writeTwin();

private:
  void start();
  void createProperties();
  void createAddedProperties();
  void applyTopics();
  void subscribe();
  void advertise();
  void unsubscribe();
  void forgetCameraInfo();
  void receive(const ros::MessageEvent<sensor_msgs::CameraInfo const>& event);
  bool trigger(std::string& message);
  CameraModel model() const;
  bool updateView();
  bool placeCamera();
  void drawPicture();
  void publishRead();
  void showLost(const std::string& what, const std::exception& error);
  bool isOwnInfoTopic() const;
  void showPublishers();
  void showPublishing();
  void showStatistics(uint64_t now_ns);
  void showTwin();

  rviz::DisplayGroupVisibilityProperty* visibility_ = nullptr;
  rviz::RosTopicProperty* topic_;
  rviz::StringProperty* namespace_;
  rviz::RosTopicProperty* info_topic_;
  rviz::IntProperty* queue_size_;
  rviz::FloatProperty* frame_rate_;
  rviz::ColorProperty* background_;
  rviz::EnumProperty* encoding_;
  rviz::FloatProperty* near_clip_;
  rviz::EnumProperty* projection_;
  rviz::BoolProperty* undistort_;
  rviz::RosTopicProperty* depth_topic_;
  rviz::StringProperty* twin_path_;

  ros::NodeHandle handle_;
  ros::Subscriber info_subscriber_;
  TriggerService trigger_service_;
  bool namespace_ok_ = false;
  bool output_changed_ = false;
  bool input_changed_ = false;

  CoreCamera core_;
  sensor_msgs::CameraInfo::ConstPtr info_;
  /// The inputs of the view.
  sensor_msgs::CameraInfo::ConstPtr viewed_info_;
  CameraModel viewed_model_;
  RcsView view_{};
  std::string info_error_;
  std::string info_warning_;

  uint32_t visibility_bit_ = 0;
  std::unique_ptr<SceneCamera> camera_;
  std::unique_ptr<PixelReader> reader_;
  /// Null until the display has started; properties may change before that.
  std::unique_ptr<PicturePublisher> publisher_;
  /// The frame that is being read back, without its pixels.
  std::unique_ptr<Frame> reading_;
  QTimer collect_timer_;
  uint64_t statistics_shown_ns_ = 0;

  HeadlessTwin twin_;
  QTimer twin_timer_;
};
}  // namespace rviz_camera_stream

#endif
