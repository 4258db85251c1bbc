// Publishes pictures that were read back, on a thread of its own.
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
/// A picture on its way to its topic.
struct Frame
{
  ReadPixels pixels;
  /// As it was received; its header is replaced by the picture's.
  sensor_msgs::CameraInfo::ConstPtr info;
  CameraModel model;
  RcsEncoding encoding = RCS_ENCODING_RGB8;
  /// What lies outside of what was drawn, for a picture that is bent for a lens.
  uint8_t background_rgb[3] = { 0, 0, 0 };
  /// Of the scene that is shown.
  ros::Time stamp;
  RcsTimes times{};
  /// Set by the publisher: a frame of an earlier series is dropped.
  uint64_t series = 0;
};

/// Converts pictures to messages and publishes them through image_transport, so that neither conversion nor compression
/// nor a lens delays rviz. While one picture is published, the newest one waits; it replaces an older one that still does.
/// All functions are called on one thread.
class PicturePublisher
{
public:
  PicturePublisher();
  /// Ends the topics and the thread.
  ~PicturePublisher();
  PicturePublisher(const PicturePublisher&) = delete;
  PicturePublisher& operator=(const PicturePublisher&) = delete;

  /// Advertises the picture's topic with camera_info beside it and, unless its name is empty, that of the depths. Ends
  /// earlier ones. Throws ros::Exception if a name is invalid.
  void advertise(const ros::NodeHandle& handle, const std::string& topic, const std::string& depth_topic);

  /// Ends the topics, and drops what is on its way.
  void shutdown();

  /// Drops what is on its way: nothing that was drawn before is published any more.
  void drop();

  bool isAdvertised() const;

  /// Resolved; empty if nothing is advertised.
  std::string topic() const;
  std::string infoTopic() const;

  /// Whether somebody subscribes to pictures, depths or CameraInfo.
  bool isWatched() const;

  /// Whether somebody subscribes to depths.
  bool areDepthsWatched() const;

  /// A frame to fill, with the memory of one that was published.
  std::unique_ptr<Frame> takeFree();

  /// Publishes it as soon as the one before is published.
  void publish(std::unique_ptr<Frame> frame);

  /// Rate and times of the last pictures in one line, and why the last one could not be converted, if that is so.
  std::string statistics() const;
  std::string error() const;

private:
  void run();
  void publishNow(Frame& frame);
  std::string publishPicture(const Frame& frame, const std_msgs::Header& header);
  std::string publishDepths(const Frame& frame, const std_msgs::Header& header);

  /// Of the calling thread alone.
  image_transport::CameraPublisher picture_;
  image_transport::Publisher depths_;

  /// Of the publishing thread alone.
  CoreCamera converter_;
  sensor_msgs::CameraInfo::ConstPtr converted_info_;
  CameraModel converted_model_;
  RcsView view_{};
  std::string info_error_;

  /// Held while publishing: topics do not end meanwhile.
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
