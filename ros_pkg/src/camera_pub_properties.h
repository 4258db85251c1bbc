// Names and help texts of CameraPub's properties. The names are keys of saved configs.
#ifndef RVIZ_CAMERA_STREAM_CAMERA_PUB_PROPERTIES_H
#define RVIZ_CAMERA_STREAM_CAMERA_PUB_PROPERTIES_H

namespace rviz_camera_stream
{
namespace properties
{
struct Text
{
  const char* name;
  const char* help;
};

// Properties of the plugin that this one replaces, in its order.
const Text VISIBILITY = { "Visibility", "Changes the visibility of other Displays in the camera view." };
const Text IMAGE_TOPIC = { "Image Topic", "sensor_msgs::Image topic to publish to." };
const Text NAMESPACE = { "Display namespace", "Namespace for this display." };
const Text CAMERA_INFO_TOPIC = { "Camera Info Topic", "sensor_msgs::CameraInfo topic to subscribe to." };
const Text QUEUE_SIZE = { "Queue Size",
                          "Advanced: set the size of the incoming message queue.  Increasing this is useful if your "
                          "incoming TF data is delayed significantly from your image data, but it can greatly increase "
                          "memory usage if the messages are big." };
const Text FRAME_RATE = { "Frame Rate",
                          "Sets target frame rate. Set to < 0 for maximum speed, set to 0 to stop, you can trigger single "
                          "images with the /rviz_camera_trigger service." };
const Text BACKGROUND_COLOR = { "Background Color", "Sets background color, values from 0.0 to 1.0." };
const Text IMAGE_ENCODING = { "Image Encoding", "Sets the image encoding" };
const Text NEAR_CLIP_DISTANCE = { "Near Clip Distance", "Set the near clip distance" };

// Added properties.
const Text PROJECTION = { "Projection",
                          "Projection of the CameraInfo's P. rviz: as in rviz's own cameras, with one focal length for "
                          "both axes. exact: exactly P, to the pixel, which a projector needs." };
const Text UNDISTORT = { "Undistort",
                         "Corrects the image for a projector's lens with the K and D of the CameraInfo. P is then "
                         "followed exactly." };
const Text DEPTH_TOPIC = { "Depth Topic",
                           "sensor_msgs::Image topic for the depths of the image: metres along the optical axis, 32FC1, "
                           "NaN where nothing is drawn. Translucent objects have no depth. Empty: none." };
const Text HEADLESS_TWIN = { "Headless Twin",
                             "File that is kept equal to rviz's current config, for the node camera_stream, which draws it "
                             "without rviz, window or graphics card. The status has the roslaunch command and the displays "
                             "that the node cannot draw. Empty: none." };
}  // namespace properties
}  // namespace rviz_camera_stream

#endif
