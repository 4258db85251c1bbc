// CameraPub's properties: options, defaults and slots.

#include "camera_pub_properties.h"

#include <ros/message_traits.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>
#include <sensor_msgs/Image.h>

#include "camera_pub.h"

namespace rviz_camera_stream
{
namespace
{
template <typename Message>
QString datatype()
{
  return QString::fromStdString(ros::message_traits::datatype<Message>());
}
}  // namespace

void CameraPub::createProperties()
{
  using namespace properties;
  topic_ = new rviz::RosTopicProperty(IMAGE_TOPIC.name, "", datatype<sensor_msgs::Image>(), IMAGE_TOPIC.help, this,
                                      SLOT(updateOutput()));
  namespace_ = new rviz::StringProperty(NAMESPACE.name, "", NAMESPACE.help, this, SLOT(updateNamespace()));
  info_topic_ = new rviz::RosTopicProperty(CAMERA_INFO_TOPIC.name, "", datatype<sensor_msgs::CameraInfo>(),
                                           CAMERA_INFO_TOPIC.help, this, SLOT(updateInput()));
  queue_size_ = new rviz::IntProperty(QUEUE_SIZE.name, 2, QUEUE_SIZE.help, this, SLOT(updateInput()));
  queue_size_->setMin(1);
  frame_rate_ = new rviz::FloatProperty(FRAME_RATE.name, -1, FRAME_RATE.help, this, SLOT(updateFrameRate()));
  frame_rate_->setMin(-1);
  background_ =
      new rviz::ColorProperty(BACKGROUND_COLOR.name, Qt::black, BACKGROUND_COLOR.help, this, SLOT(updatePicture()));
  encoding_ = new rviz::EnumProperty(IMAGE_ENCODING.name, "rgb8", IMAGE_ENCODING.help, this, SLOT(updatePicture()));
  for (int encoding = RCS_ENCODING_RGB8; encoding <= RCS_ENCODING_MONO16; ++encoding)
    encoding_->addOption(rcs_encoding_name(static_cast<RcsEncoding>(encoding)), encoding);
  near_clip_ =
      new rviz::FloatProperty(NEAR_CLIP_DISTANCE.name, 0.01F, NEAR_CLIP_DISTANCE.help, this, SLOT(updatePicture()));
  near_clip_->setMin(0.01F);
}

void CameraPub::createAddedProperties()
{
  using namespace properties;
  projection_ = new rviz::EnumProperty(PROJECTION.name, "rviz", PROJECTION.help, this, SLOT(updatePicture()));
  projection_->addOption("rviz", RCS_PROJECTION_RVIZ);
  projection_->addOption("exact", RCS_PROJECTION_EXACT);
  undistort_ = new rviz::BoolProperty(UNDISTORT.name, false, UNDISTORT.help, this, SLOT(updatePicture()));
  depth_topic_ = new rviz::RosTopicProperty(DEPTH_TOPIC.name, "", datatype<sensor_msgs::Image>(), DEPTH_TOPIC.help, this,
                                            SLOT(updateOutput()));
  twin_path_ = new rviz::StringProperty(HEADLESS_TWIN.name, "", HEADLESS_TWIN.help, this, SLOT(updateTwin()));
  // Unused, they are not saved: the config is as with the plugin without them.
  projection_->setShouldBeSaved(false);
  undistort_->setShouldBeSaved(false);
  depth_topic_->setShouldBeSaved(false);
  twin_path_->setShouldBeSaved(false);
}
}  // namespace rviz_camera_stream
