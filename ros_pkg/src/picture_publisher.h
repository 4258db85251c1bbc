// Publishes pictures on a thread of its own.
#ifndef RVIZ_CAMERA_STREAM_PICTURE_PUBLISHER_H
#define RVIZ_CAMERA_STREAM_PICTURE_PUBLISHER_H

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>

#include "core_camera.h"
#include "pixel_reader.h"

namespace rviz_camera_stream
{
/// A picture from drawing to publishing.
struct Frame
{
  ReadPixels pixels;
  /// As received; its header is replaced by the picture's.
  sensor_msgs::CameraInfo::ConstPtr info;
  CameraModel model;
  RcsEncoding encoding = RCS_ENCODING_RGB8;
  /// Colour outside of the drawn picture, for lens correction.
  uint8_t background_rgb[3] = { 0, 0, 0 };
  /// Time of the scene.
  ros::Time stamp;
  RcsTimes times{};
  /// Set by the publisher, which drops frames of earlier series.
  uint64_t series = 0;
};

/// Converts pictures to messages and publishes them through image_transport, so that conversion, compression and lens
/// correction do not delay rviz. While one picture is published, only the newest one waits. All functions are called on
/// one thread.
class PicturePublisher
{
public:
  PicturePublisher();
  /// Ends the topics and the thread.
  ~PicturePublisher();
  PicturePublisher(const PicturePublisher&) = delete;
  PicturePublisher& operator=(const PicturePublisher&) = delete;

  /// Advertises the picture's topic with camera_info beside it and, unless its name is empty, the depth topic. Ends
  /// earlier topics. Throws ros::Exception if a name is invalid.
  void advertise(const ros::NodeHandle& handle, const std::string& topic, const std::string& depth_topic);

  /// Ends the topics, and drops unpublished pictures.
  void shutdown();

  /// Drops all pictures that were drawn before.
  void drop();

  bool isAdvertised() const;

  /// Resolved topic; empty if nothing is advertised.
  std::string topic() const;
  std::string infoTopic() const;

  /// True if pictures, depths or CameraInfo have subscribers.
  bool isWatched() const;

  /// True if depths have subscribers.
  bool areDepthsWatched() const;

  /// A frame to fill, reusing a published one's memory.
  std::unique_ptr<Frame> takeFree();

  /// Publishes a frame after the one before.
  void publish(std::unique_ptr<Frame> frame);

  /// Rate and durations of the last pictures in one line.
  std::string statistics() const;

  /// Error of the last picture, or empty.
  std::string error() const;

private:
  void run();
  void publishNow(Frame& frame);
  std::string publishPicture(const Frame& frame, const std_msgs::Header& header);
  std::string publishDepths(const Frame& frame, const std_msgs::Header& header);

  /// Used by the calling thread alone.
  image_transport::CameraPublisher picture_;
  image_transport::Publisher depths_;

  /// Used by the publishing thread alone.
  CoreCamera converter_;
  sensor_msgs::CameraInfo::ConstPtr converted_info_;
  CameraModel converted_model_;
  RcsView view_{};
  std::string info_error_;

  /// Locked while publishing, so that topics do not end.
  std::mutex publishing_;
  image_transport::CameraPublisher publishing_picture_;
  image_transport::Publisher publishing_depths_;
  uint64_t series_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::unique_ptr<Frame> waiting_;
  std::unique_ptr<Frame> free_;
  CoreCamera statistics_;
  std::string error_;
  bool end_ = false;
  std::thread thread_;
};
}  // namespace rviz_camera_stream

#endif
