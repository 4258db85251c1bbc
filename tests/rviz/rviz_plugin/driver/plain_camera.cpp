#include "plain_camera.h"

#include <OgreCamera.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreRenderTexture.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>
#include <OgreViewport.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/string_property.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

namespace rviz_test_driver
{
PlainCamera::PlainCamera()
{
  image_topic_ = new rviz::StringProperty("Image Topic", "", "Where pictures are published.", this);
  info_topic_ = new rviz::StringProperty("Camera Info Topic", "", "Where the CameraInfo comes from.", this);
}

PlainCamera::~PlainCamera()
{
  if (!camera_)
    return;
  removeTexture();
  node_->detachAllObjects();
  scene_manager_->destroySceneNode(node_);
  scene_manager_->destroyCamera(camera_);
}

void PlainCamera::onInitialize()
{
  camera_ = scene_manager_->createCamera("plain_camera");
  node_ = scene_manager_->getRootSceneNode()->createChildSceneNode();
  node_->attachObject(camera_);
}

void PlainCamera::onEnable()
{
  publisher_ = image_transport::ImageTransport(ros::NodeHandle()).advertiseCamera(image_topic_->getStdString(), 1);
  subscriber_ = update_nh_.subscribe<sensor_msgs::CameraInfo>(
      info_topic_->getStdString(), 1, [this](const sensor_msgs::CameraInfo::ConstPtr& info) { info_ = info; });
}

void PlainCamera::onDisable()
{
  subscriber_.shutdown();
  publisher_.shutdown();
}

void PlainCamera::removeTexture()
{
  if (target_)
  {
    target_->removeAllViewports();
    Ogre::TextureManager::getSingleton().remove(texture_->getHandle());
  }
  target_ = nullptr;
}

void PlainCamera::createTexture(unsigned width, unsigned height)
{
  removeTexture();
  texture_ = Ogre::TextureManager::getSingleton().createManual(
      "plain_camera_texture", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME, Ogre::TEX_TYPE_2D, width, height, 0,
      Ogre::PF_R8G8B8, Ogre::TU_RENDERTARGET);
  target_ = texture_->getBuffer()->getRenderTarget();
  target_->setAutoUpdated(false);
  Ogre::Viewport* viewport = target_->addViewport(camera_);
  viewport->setOverlaysEnabled(false);
  viewport->setBackgroundColour(Ogre::ColourValue::Black);
}

bool PlainCamera::place()
{
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  if (!context_->getFrameManager()->getTransform(info_->header.frame_id, ros::Time(), position, orientation))
    return false;
  node_->setPosition(position);
  node_->setOrientation(orientation * Ogre::Quaternion(Ogre::Degree(180), Ogre::Vector3::UNIT_X));
  const double near_m = 0.01, far_m = 100.0, width = info_->width, height = info_->height;
  Ogre::Matrix4 projection = Ogre::Matrix4::ZERO;
  projection[0][0] = static_cast<Ogre::Real>(2.0 * info_->P[0] / width);
  projection[0][2] = static_cast<Ogre::Real>(1.0 - 2.0 * info_->P[2] / width);
  projection[1][1] = static_cast<Ogre::Real>(2.0 * info_->P[5] / height);
  projection[1][2] = static_cast<Ogre::Real>(2.0 * info_->P[6] / height - 1.0);
  projection[2][2] = static_cast<Ogre::Real>(-(far_m + near_m) / (far_m - near_m));
  projection[2][3] = static_cast<Ogre::Real>(-2.0 * far_m * near_m / (far_m - near_m));
  projection[3][2] = -1.0F;
  camera_->setNearClipDistance(static_cast<Ogre::Real>(near_m));
  camera_->setCustomProjectionMatrix(true, projection);
  return true;
}

void PlainCamera::update(float, float)
{
  if (!info_ || !place())
    return;
  if (!target_ || target_->getWidth() != info_->width || target_->getHeight() != info_->height)
    createTexture(info_->width, info_->height);
  target_->update();
  publish();
}

void PlainCamera::publish()
{
  sensor_msgs::Image image;
  image.header.stamp = ros::Time::now();
  image.header.frame_id = info_->header.frame_id;
  image.width = info_->width;
  image.height = info_->height;
  image.encoding = sensor_msgs::image_encodings::RGB8;
  image.step = 3 * image.width;
  image.data.resize(size_t(image.step) * image.height);
  const Ogre::PixelBox box(image.width, image.height, 1, Ogre::PF_BYTE_RGB, image.data.data());
#if OGRE_VERSION < ((1 << 16) | (10 << 8))
  target_->copyContentsToMemory(box, Ogre::RenderTarget::FB_AUTO);
#else
  target_->copyContentsToMemory(Ogre::Box(0, 0, image.width, image.height), box, Ogre::RenderTarget::FB_AUTO);
#endif
  sensor_msgs::CameraInfo info = *info_;
  info.header = image.header;
  publisher_.publish(image, info);
}
}  // namespace rviz_test_driver

PLUGINLIB_EXPORT_CLASS(rviz_test_driver::PlainCamera, rviz::Display)
