#include "camera_pub.h"

#include <algorithm>
#include <cmath>

#include <OgreException.h>
#include <OgreRenderTexture.h>
#include <OgreRoot.h>

#include <ros/console.h>
#include <ros/names.h>
#include <ros/this_node.h>
#include <rviz/bit_allocator.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/load_resource.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/display_group_visibility_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>
#include <rviz/visualization_manager.h>
#include <sensor_msgs/Image.h>

#include "camera_pub_properties.h"

namespace rviz_camera_stream
{
namespace
{
using rviz::StatusProperty;

const char CAMERA_INFO[] = "Camera Info";
const char OUTPUT_TOPIC[] = "Output Topic";
const char NAMESPACE_STATUS[] = "Display namespace";
const char TRANSFORM[] = "getTransform";
const char PICTURE[] = "Picture";
const char TIMING[] = "Timing";
const char TWIN[] = "Headless Twin";
const char TWIN_NOT_DRAWN[] = "Headless Twin: not drawn";

/// Delay from a change of the config to writing its twin, so that loading or dragging a value writes it once.
const int TWIN_DELAY_MS = 500;
/// Poll period of a readback while rviz's window is drawn less often.
const int COLLECT_PERIOD_MS = 1;
const uint64_t STATISTICS_PERIOD_NS = 1000000000;

/// The message of an exception, without the file and line of Ogre's source.
std::string reason(const std::exception& error)
{
  const auto* of_ogre = dynamic_cast<const Ogre::Exception*>(&error);
  return of_ogre ? of_ogre->getDescription() : error.what();
}

uint8_t colourByte(float value)
{
  return static_cast<uint8_t>(std::lround(std::min(std::max(value, 0.0F), 1.0F) * 255.0F));
}
}  // namespace

CameraPub::CameraPub()
{
  createProperties();
  createAddedProperties();
  collect_timer_.setSingleShot(true);
  twin_timer_.setSingleShot(true);
  connect(&collect_timer_, SIGNAL(timeout()), this, SLOT(collect()));
  connect(&twin_timer_, SIGNAL(timeout()), this, SLOT(writeTwin()));
}

CameraPub::~CameraPub()
{
  if (publisher_)
  {
    Ogre::Root::getSingleton().removeFrameListener(this);
    trigger_service_.leave();
    unsubscribe();
  }
  if (visibility_bit_ != 0)
    context_->visibilityBits()->freeBits(visibility_bit_);
}

void CameraPub::onInitialize()
{
  Display::onInitialize();
  try
  {
    start();
  }
  catch (const std::exception& error)
  {
    // rviz goes on without this camera.
    setStatusStd(StatusProperty::Error, PICTURE, "Cannot start the camera: " + reason(error));
  }
}

/// Creates camera, reader and publisher. Throws std::exception without resources; the display then does nothing.
void CameraPub::start()
{
  visibility_bit_ = context_->visibilityBits()->allocBit();
  if (visibility_bit_ == 0)
    setStatus(StatusProperty::Error, PICTURE, "Too many cameras: rviz supports 32");
  visibility_ = new rviz::DisplayGroupVisibilityProperty(
      visibility_bit_, context_->getRootDisplayGroup(), this, properties::VISIBILITY.name, true,
      properties::VISIBILITY.help);
  visibility_->setIcon(rviz::loadPixmap("package://rviz/icons/visibility.svg", true));
  addChild(visibility_, 0);

  camera_.reset(new SceneCamera(*context_->getSceneManager(), visibility_bit_));
  reader_.reset(new PixelReader);
  // Created last, because the display does nothing without it.
  publisher_.reset(new PicturePublisher);
  Ogre::Root::getSingleton().addFrameListener(this);
  if (auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_))
    connect(manager, SIGNAL(configChanged()), this, SLOT(configChanged()));
  updateFrameRate();
  updateNamespace();
}

void CameraPub::onEnable()
{
  updateOutput();
  updateInput();
}

void CameraPub::onDisable()
{
  if (!publisher_)
    return;
  unsubscribe();
  camera_->releaseTexture();
}

void CameraPub::reset()
{
  Display::reset();
  if (!publisher_)
    return;
  // Display::reset has cleared the statuses.
  if (!namespace_ok_)
    updateNamespace();
  else if (!publisher_->isAdvertised())
    updateOutput();
  // Receives a latched CameraInfo again.
  updateInput();
}

void CameraPub::setTopic(const QString& topic, const QString& datatype)
{
  if (datatype == "sensor_msgs/CameraInfo")
    info_topic_->setValue(topic);
  else if (datatype == "sensor_msgs/Image")
    topic_->setValue(topic);
  else
    // A transport's topic, such as /image/compressed, is below the image's.
    topic_->setValue(topic.left(topic.lastIndexOf('/')));
}

// --- topics and services ---------------------------------------------------------------------------------------------

void CameraPub::updateNamespace()
{
  if (!publisher_)
    return;
  trigger_service_.leave();
  namespace_ok_ = false;
  try
  {
    handle_ = ros::NodeHandle(namespace_->getStdString());
    trigger_service_.join(handle_, [this](std::string& message) { return trigger(message); });
    namespace_ok_ = true;
    setStatus(StatusProperty::Ok, NAMESPACE_STATUS, "OK");
  }
  catch (const ros::InvalidNameException& error)
  {
    setStatus(StatusProperty::Error, NAMESPACE_STATUS, QString("Invalid namespace: ") + error.what());
  }
  catch (const ros::Exception& error)
  {
    // Images are published at the frame rate without it.
    namespace_ok_ = true;
    setStatus(StatusProperty::Warn, NAMESPACE_STATUS, QString("Could not create the trigger service: ") + error.what());
  }
  updateOutput();
}

void CameraPub::updateOutput()
{
  depth_topic_->setShouldBeSaved(!depth_topic_->getTopicStd().empty());
  output_changed_ = true;
  if (publisher_)
    context_->queueRender();
}

void CameraPub::updateInput()
{
  input_changed_ = true;
  if (publisher_)
    context_->queueRender();
}

void CameraPub::applyTopics()
{
  if (output_changed_)
  {
    output_changed_ = false;
    publisher_->shutdown();
    if (namespace_ok_)
      advertise();
  }
  if (input_changed_)
  {
    input_changed_ = false;
    info_subscriber_.shutdown();
    forgetCameraInfo();
    subscribe();
  }
}

void CameraPub::advertise()
{
  const std::string topic = topic_->getTopicStd();
  if (topic.empty())
  {
    setStatus(StatusProperty::Error, OUTPUT_TOPIC, "No topic set");
    return;
  }
  try
  {
    publisher_->advertise(handle_, topic, depth_topic_->getTopicStd());
    setStatus(StatusProperty::Ok, OUTPUT_TOPIC, "Topic set");
  }
  catch (const ros::Exception& error)
  {
    publisher_->shutdown();
    setStatus(StatusProperty::Error, OUTPUT_TOPIC, error.what());
  }
}

void CameraPub::subscribe()
{
  const std::string topic = info_topic_->getTopicStd();
  if (topic.empty())
  {
    setStatus(StatusProperty::Error, CAMERA_INFO, "No topic set");
    return;
  }
  try
  {
    const auto queue_size = static_cast<uint32_t>(queue_size_->getInt());
    info_subscriber_ = update_nh_.subscribe(topic, queue_size, &CameraPub::receive, this);
    setStatusStd(StatusProperty::Warn, CAMERA_INFO,
                 "No CameraInfo received on [" + info_subscriber_.getTopic() + "]. Topic may not exist.");
  }
  catch (const ros::Exception& error)
  {
    setStatus(StatusProperty::Error, CAMERA_INFO, QString("Error subscribing: ") + error.what());
  }
}

void CameraPub::unsubscribe()
{
  info_subscriber_.shutdown();
  forgetCameraInfo();
  publisher_->shutdown();
}

void CameraPub::forgetCameraInfo()
{
  info_.reset();
  viewed_info_.reset();
  reader_->abandon();
  reading_.reset();
  publisher_->drop();
  rcs_camera_clear_info(core_.get());
}

/// True if the CameraInfo's topic is the one that this display publishes beside its images.
bool CameraPub::isOwnInfoTopic() const
{
  return !publisher_->infoTopic().empty() && info_subscriber_.getTopic() == publisher_->infoTopic();
}

void CameraPub::receive(const ros::MessageEvent<sensor_msgs::CameraInfo const>& event)
{
  // A CameraInfo of this display itself would never change.
  if (isOwnInfoTopic() && event.getPublisherName() == ros::this_node::getName())
    return;
  info_ = event.getConstMessage();
}

bool CameraPub::trigger(std::string& message)
{
  if (!isEnabled() || !publisher_->isAdvertised())
  {
    message = "Image publisher not configured";
    return false;
  }
  rcs_camera_trigger(core_.get());
  context_->queueRender();
  message = "New image will be published on: " + publisher_->topic();
  return true;
}

// --- drawing ---------------------------------------------------------------------------------------------------------

void CameraPub::updateFrameRate()
{
  rcs_camera_set_frame_rate(core_.get(), frame_rate_->getFloat());
}

void CameraPub::updatePicture()
{
  projection_->setShouldBeSaved(projection_->getOptionInt() != RCS_PROJECTION_RVIZ);
  undistort_->setShouldBeSaved(undistort_->getBool());
  if (publisher_)
    context_->queueRender();
}

CameraModel CameraPub::model() const
{
  CameraModel model;
  model.projection = static_cast<RcsProjection>(projection_->getOptionInt());
  model.undistort = undistort_->getBool();
  model.near_m = near_clip_->getFloat();
  return model;
}

void CameraPub::update(float, float)
{
  if (!publisher_)
    return;
  // Before the next picture, which may overwrite it.
  if (reader_->pending())
    publishRead();
  applyTopics();
  if (!info_subscriber_)
    return;
  const bool can_draw = visibility_bit_ != 0 && updateView() && placeCamera();
  showPublishers();
  const uint64_t now_ns = monotonicNow();
  if (can_draw && publisher_->isAdvertised() && rcs_camera_due(core_.get(), now_ns, publisher_->isWatched()))
  {
    rcs_camera_begin(core_.get(), now_ns);
    drawPicture();
  }
  showStatistics(now_ns);
}

/// Updates the view of the CameraInfo. Returns false if there is none.
bool CameraPub::updateView()
{
  if (!info_)
    return false;
  const CameraModel wanted = model();
  if (info_ != viewed_info_ || !(wanted == viewed_model_))
  {
    info_error_ = core_.setInfo(*info_, wanted, view_);
    info_warning_ = info_error_.empty() ? core_.warning() : std::string();
    viewed_info_ = info_;
    viewed_model_ = wanted;
  }
  if (!info_error_.empty())
  {
    setStatusStd(StatusProperty::Error, CAMERA_INFO, info_error_);
    return false;
  }
  return true;
}

/// Moves the camera to its frame. Returns false on failure.
bool CameraPub::placeCamera()
{
  rviz::FrameManager& frames = *context_->getFrameManager();
  const std_msgs::Header& header = info_->header;
  if (frames.getSyncMode() == rviz::FrameManager::SyncExact && frames.getTime() != header.stamp)
  {
    setStatusStd(StatusProperty::Warn, "Time",
                 "Time-syncing active and no info at timestamp " + std::to_string(frames.getTime().toSec()) + ".");
    return false;
  }
  setStatus(StatusProperty::Ok, "Time", "ok");

  // At the latest pose: a CameraInfo may be sent once while its frame moves.
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  std::string error;
  if (!frames.getTransform(header.frame_id, ros::Time(), position, orientation))
  {
    if (!frames.transformHasProblems(header.frame_id, ros::Time(), error))
      error = "No transform from [" + header.frame_id + "] to [" + fixed_frame_.toStdString() + "]";
    setStatusStd(StatusProperty::Error, TRANSFORM, error);
    return false;
  }
  deleteStatus(TRANSFORM);

  try
  {
    camera_->setView(position, orientation, view_);
  }
  catch (const std::exception& error)
  {
    setStatusStd(StatusProperty::Error, PICTURE,
                 "Cannot create a texture of " + std::to_string(view_.drawn_width) + "x" +
                     std::to_string(view_.drawn_height) + " pixels: " + reason(error));
    return false;
  }
  return true;
}

void CameraPub::drawPicture()
{
  std::unique_ptr<Frame> frame = publisher_->takeFree();
  frame->info = info_;
  frame->model = viewed_model_;
  frame->encoding = static_cast<RcsEncoding>(encoding_->getOptionInt());
  frame->stamp = ros::Time::now();
  frame->times = RcsTimes{};
  frame->times.begun_ns = monotonicNow();
  const Ogre::ColourValue background = background_->getOgreColor();
  frame->background_rgb[0] = colourByte(background.r);
  frame->background_rgb[1] = colourByte(background.g);
  frame->background_rgb[2] = colourByte(background.b);
  try
  {
    visibility_->update();
    camera_->draw(background);
    reader_->begin(*camera_->target(), publisher_->areDepthsWatched());
  }
  catch (const std::exception& error)
  {
    showLost("Cannot draw the image", error);
    return;
  }
  frame->times.drawn_ns = monotonicNow();
  reading_ = std::move(frame);
  collect();
}

bool CameraPub::frameEnded(const Ogre::FrameEvent&)
{
  if (reader_->pending() && reader_->ready())
    publishRead();
  return true;
}

void CameraPub::collect()
{
  if (!reader_->pending())
    return;
  if (reader_->ready())
    publishRead();
  else
    collect_timer_.start(COLLECT_PERIOD_MS);
}

void CameraPub::publishRead()
{
  std::unique_ptr<Frame> frame = std::move(reading_);
  try
  {
    if (!frame || !reader_->fetch(frame->pixels))
    {
      // The driver lost it, for example by a change of the screen's mode.
      reader_->abandon();
      return;
    }
  }
  catch (const std::exception& error)
  {
    showLost("Cannot read the image", error);
    return;
  }
  frame->times.read_ns = monotonicNow();
  publisher_->publish(std::move(frame));
  showPublishing();
}

/// Drops the image that was being drawn or read, and sets the status.
void CameraPub::showLost(const std::string& what, const std::exception& error)
{
  reader_->abandon();
  reading_.reset();
  setStatusStd(StatusProperty::Error, PICTURE,
               what + " of " + std::to_string(view_.drawn_width) + "x" + std::to_string(view_.drawn_height) +
                   " pixels: " + reason(error));
}

// --- statuses --------------------------------------------------------------------------------------------------------

void CameraPub::showPublishers()
{
  const std::string topic = info_subscriber_.getTopic();
  const uint32_t own = isOwnInfoTopic() ? 1 : 0;
  if (info_subscriber_.getNumPublishers() <= own)
    setStatusStd(StatusProperty::Warn, CAMERA_INFO, "No publishers on [" + topic + "]. Topic may not exist.");
  else if (!info_)
    setStatusStd(StatusProperty::Warn, CAMERA_INFO, "No CameraInfo received on [" + topic + "]. Topic may not exist.");
  else if (info_error_.empty() && !info_warning_.empty())
    setStatusStd(StatusProperty::Warn, CAMERA_INFO, info_warning_);
  else if (info_error_.empty())
    setStatus(StatusProperty::Ok, CAMERA_INFO, "OK");
}

/// Sets the status of the last published image.
void CameraPub::showPublishing()
{
  const std::string error = publisher_->error();
  if (error.empty())
    deleteStatus(PICTURE);
  else
    setStatusStd(StatusProperty::Error, PICTURE, error);
}

void CameraPub::showStatistics(uint64_t now_ns)
{
  if (now_ns - statistics_shown_ns_ < STATISTICS_PERIOD_NS)
    return;
  statistics_shown_ns_ = now_ns;
  if (!publisher_->error().empty())
    showPublishing();
  const std::string statistics = publisher_->statistics();
  if (!statistics.empty())
    setStatusStd(StatusProperty::Ok, TIMING, statistics);
}

// --- the headless twin -----------------------------------------------------------------------------------------------

void CameraPub::updateTwin()
{
  const bool used = !twin_path_->getStdString().empty();
  twin_path_->setShouldBeSaved(used);
  if (!publisher_)
    return;
  twin_.forget();
  deleteStatus(TWIN);
  deleteStatus(TWIN_NOT_DRAWN);
  // Later: the rest of a config may still be loading.
  if (used)
    twin_timer_.start(TWIN_DELAY_MS);
  else
    twin_timer_.stop();
}

void CameraPub::configChanged()
{
  if (!twin_path_->getStdString().empty())
    twin_timer_.start(TWIN_DELAY_MS);
}

void CameraPub::writeTwin()
{
  const auto* manager = dynamic_cast<const rviz::VisualizationManager*>(context_);
  if (!manager)
  {
    setStatus(StatusProperty::Error, TWIN, "Cannot save the config of this program");
    return;
  }
  if (twin_.write(*manager, twin_path_->getStdString()))
    showTwin();
}

void CameraPub::showTwin()
{
  const TwinReport& report = twin_.report();
  if (!report.error.empty())
  {
    setStatusStd(StatusProperty::Error, TWIN, report.error);
    deleteStatus(TWIN_NOT_DRAWN);
    return;
  }
  setStatusStd(StatusProperty::Ok, TWIN, report.launch_line);
  ROS_INFO_STREAM("Headless twin of " << getNameStd() << ": " << report.launch_line);
  if (report.not_drawn.empty())
  {
    deleteStatus(TWIN_NOT_DRAWN);
    return;
  }
  setStatusStd(StatusProperty::Warn, TWIN_NOT_DRAWN, report.not_drawn);
  ROS_WARN_STREAM("Headless twin of " << getNameStd() << ", not drawn by it: " << report.not_drawn);
}
}  // namespace rviz_camera_stream

#if __has_include(<pluginlib/class_list_macros.hpp>)
#include <pluginlib/class_list_macros.hpp>
#else
#include <pluginlib/class_list_macros.h>
#endif
PLUGINLIB_EXPORT_CLASS(rviz_camera_stream::CameraPub, rviz::Display)
