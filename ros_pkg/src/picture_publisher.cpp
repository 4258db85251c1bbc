#include "picture_publisher.h"

#include <boost/make_shared.hpp>
#include <pthread.h>
#include <sensor_msgs/image_encodings.h>

namespace rviz_camera_stream
{
PicturePublisher::PicturePublisher()
{
  thread_ = std::thread([this] { run(); });
  pthread_setname_np(thread_.native_handle(), "camera_pub");
}

PicturePublisher::~PicturePublisher()
{
  shutdown();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void PicturePublisher::advertise(const ros::NodeHandle& handle, const std::string& topic, const std::string& depth_topic)
{
  shutdown();
  image_transport::ImageTransport transport(handle);
  picture_ = transport.advertiseCamera(topic, 1);
  if (!depth_topic.empty())
    depths_ = transport.advertise(depth_topic, 1);
  const std::lock_guard<std::mutex> lock(publishing_);
  publishing_picture_ = picture_;
  publishing_depths_ = depths_;
}

void PicturePublisher::drop()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.reset();
    error_.clear();
  }
  const std::lock_guard<std::mutex> lock(publishing_);
  ++series_;
}

void PicturePublisher::shutdown()
{
  drop();
  const std::lock_guard<std::mutex> lock(publishing_);
  publishing_picture_ = image_transport::CameraPublisher();
  publishing_depths_ = image_transport::Publisher();
  picture_ = image_transport::CameraPublisher();
  depths_ = image_transport::Publisher();
}

bool PicturePublisher::isAdvertised() const
{
  return picture_;
}

std::string PicturePublisher::topic() const
{
  return picture_ ? picture_.getTopic() : std::string();
}

std::string PicturePublisher::infoTopic() const
{
  return picture_ ? picture_.getInfoTopic() : std::string();
}

bool PicturePublisher::isWatched() const
{
  return (picture_ && picture_.getNumSubscribers() > 0) || areDepthsWatched();
}

bool PicturePublisher::areDepthsWatched() const
{
  return depths_ && depths_.getNumSubscribers() > 0;
}

std::unique_ptr<Frame> PicturePublisher::takeFree()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::unique_ptr<Frame> frame = std::move(free_);
  if (!frame)
    frame.reset(new Frame);
  return frame;
}

void PicturePublisher::publish(std::unique_ptr<Frame> frame)
{
  // Changed by the calling thread alone.
  frame->series = series_;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_ = std::move(frame);
  }
  wake_.notify_all();
}

std::string PicturePublisher::statistics() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return statistics_.statistics(monotonicNow());
}

std::string PicturePublisher::error() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return error_;
}

void PicturePublisher::run()
{
  while (true)
  {
    std::unique_ptr<Frame> frame;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [this] { return end_ || waiting_; });
      if (end_)
        return;
      frame = std::move(waiting_);
    }
    try
    {
      publishNow(*frame);
    }
    catch (const std::exception& error)
    {
      // The image does not fit memory: frees it, because the next one may be smaller.
      frame.reset();
      const std::lock_guard<std::mutex> lock(mutex_);
      error_ = std::string("Cannot publish the image: ") + error.what();
      continue;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    free_ = std::move(frame);
  }
}

void PicturePublisher::publishNow(Frame& frame)
{
  if (frame.info != converted_info_ || !(frame.model == converted_model_))
  {
    info_error_ = converter_.setInfo(*frame.info, frame.model, view_);
    converted_info_ = frame.info;
    converted_model_ = frame.model;
  }
  std_msgs::Header header;
  header.stamp = frame.stamp;
  header.frame_id = frame.info->header.frame_id;
  std::string error = info_error_;
  if (error.empty())
    error = publishPicture(frame, header);
  if (error.empty() && !frame.pixels.depths.empty())
    error = publishDepths(frame, header);

  frame.times.published_ns = monotonicNow();
  const std::lock_guard<std::mutex> lock(mutex_);
  error_ = error;
  if (error.empty())
    rcs_camera_record(statistics_.get(), &frame.times);
}

std::string PicturePublisher::publishPicture(const Frame& frame, const std_msgs::Header& header)
{
  const ReadPixels& read = frame.pixels;
  RcsPixels pixels{};
  pixels.data = read.bgra.data();
  pixels.length = read.bgra.size();
  pixels.width = read.width;
  pixels.height = read.height;
  pixels.row_bytes = size_t(4) * read.width;
  pixels.order = RCS_PIXEL_ORDER_BGRA;
  pixels.bottom_up = read.bottom_up;

  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->header = header;
  image->width = view_.image_width;
  image->height = view_.image_height;
  image->encoding = rcs_encoding_name(frame.encoding);
  image->is_bigendian = false;
  image->step = static_cast<uint32_t>(view_.image_width * rcs_encoding_bytes_per_pixel(frame.encoding));
  image->data.resize(size_t(image->step) * image->height);
  if (rcs_camera_encode(converter_.get(), &pixels, frame.encoding, frame.background_rgb, image->data.data(),
                        image->data.size()) != RCS_RESULT_OK)
    return coreError();
  const auto info = boost::make_shared<sensor_msgs::CameraInfo>(*frame.info);
  info->header = header;
  // Binning and region of interest are not applied.
  info->binning_x = info->binning_y = 0;
  info->roi = sensor_msgs::RegionOfInterest();
  const std::lock_guard<std::mutex> lock(publishing_);
  if (publishing_picture_ && frame.series == series_)
    publishing_picture_.publish(image, info);
  return std::string();
}

std::string PicturePublisher::publishDepths(const Frame& frame, const std_msgs::Header& header)
{
  const ReadPixels& read = frame.pixels;
  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->header = header;
  image->width = view_.image_width;
  image->height = view_.image_height;
  image->encoding = sensor_msgs::image_encodings::TYPE_32FC1;
  image->is_bigendian = false;
  image->step = view_.image_width * static_cast<uint32_t>(sizeof(float));
  const size_t count = size_t(image->width) * image->height;
  image->data.resize(sizeof(float) * count);
  // A vector's memory is aligned for every type.
  if (rcs_camera_encode_depth(converter_.get(), read.depths.data(), read.depths.size(), read.bottom_up,
                              reinterpret_cast<float*>(image->data.data()), count) != RCS_RESULT_OK)
    return coreError();
  const std::lock_guard<std::mutex> lock(publishing_);
  if (publishing_depths_ && frame.series == series_)
    publishing_depths_.publish(image);
  return std::string();
}
}  // namespace rviz_camera_stream
