#include "scene_camera.h"

#include <OgreCamera.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreManualObject.h>
#include <OgreRenderTexture.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>
#include <OgreViewport.h>

namespace rviz_camera_stream
{
namespace
{
/// Names in Ogre are unique in the process.
std::string uniqueName(const char* what)
{
  static unsigned count = 0;
  return "rviz_camera_stream/" + std::string(what) + std::to_string(count++);
}
}  // namespace

SceneCamera::SceneCamera(Ogre::SceneManager& scene, uint32_t visibility_mask)
  : scene_(scene), visibility_mask_(visibility_mask), name_(uniqueName("camera"))
{
  camera_ = scene_.createCamera(name_);
  node_ = scene_.getRootSceneNode()->createChildSceneNode();
  node_->attachObject(camera_);
  prepareTexts();
}

/// Draws a triangle into a temporary texture. rviz's texts inherit the last row of their matrix from the object drawn
/// before; without one they would be missing or distorted, also in rviz's window.
void SceneCamera::prepareTexts()
{
  Ogre::ManualObject* triangle = scene_.createManualObject(name_ + "/triangle");
  triangle->begin("BaseWhiteNoLighting", Ogre::RenderOperation::OT_TRIANGLE_LIST);
  triangle->position(-0.1F, -0.1F, -1.0F);
  triangle->position(0.1F, -0.1F, -1.0F);
  triangle->position(0.0F, 0.1F, -1.0F);
  triangle->end();
  triangle->setVisibilityFlags(visibility_mask_);
  Ogre::SceneNode* place = scene_.getRootSceneNode()->createChildSceneNode();
  place->attachObject(triangle);
  createTexture(16, 16);
  draw(Ogre::ColourValue::Black);
  releaseTexture();
  place->detachAllObjects();
  scene_.destroySceneNode(place);
  scene_.destroyManualObject(triangle);
}

SceneCamera::~SceneCamera()
{
  releaseTexture();
  node_->detachAllObjects();
  scene_.destroySceneNode(node_);
  scene_.destroyCamera(camera_);
}

void SceneCamera::releaseTexture()
{
  if (target_)
    target_->removeAllViewports();
  target_ = nullptr;
  const Ogre::TexturePtr texture = texture_;
  texture_ = Ogre::TexturePtr();
  if (texture.get())
    Ogre::TextureManager::getSingleton().remove(texture->getHandle());
}

void SceneCamera::createTexture(uint32_t width, uint32_t height)
{
  releaseTexture();
  texture_ = Ogre::TextureManager::getSingleton().createManual(
      uniqueName("picture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME, Ogre::TEX_TYPE_2D, width, height, 0,
      Ogre::PF_X8R8G8B8, Ogre::TU_RENDERTARGET);
  target_ = texture_->getBuffer()->getRenderTarget();
  target_->setAutoUpdated(false);
  Ogre::Viewport* viewport = target_->addViewport(camera_);
  viewport->setClearEveryFrame(true);
  viewport->setOverlaysEnabled(false);
  viewport->setVisibilityMask(visibility_mask_);
}

void SceneCamera::setView(const Ogre::Vector3& position, const Ogre::Quaternion& orientation, const RcsView& view)
{
  if (!target_ || target_->getWidth() != view.drawn_width || target_->getHeight() != view.drawn_height)
  {
    try
    {
      createTexture(view.drawn_width, view.drawn_height);
    }
    catch (...)
    {
      releaseTexture();
      throw;
    }
  }
  // Ogre looks along -z with y up.
  const Ogre::Quaternion turned = orientation * Ogre::Quaternion(Ogre::Degree(180), Ogre::Vector3::UNIT_X);
  // One axis after the other: the order decides rounding, and so pixels at the edges of lines.
  Ogre::Vector3 eye = position + turned * Ogre::Vector3::UNIT_X * static_cast<Ogre::Real>(view.optical_from_eye[0]);
  eye += turned * Ogre::Vector3::UNIT_Y * static_cast<Ogre::Real>(-view.optical_from_eye[1]);
  eye -= turned * Ogre::Vector3::UNIT_Z * static_cast<Ogre::Real>(view.optical_from_eye[2]);
  node_->setPosition(eye);
  node_->setOrientation(turned);

  camera_->setNearClipDistance(static_cast<Ogre::Real>(view.near_m));
  Ogre::Matrix4 projection;
  for (size_t row = 0; row < 4; ++row)
    for (size_t column = 0; column < 4; ++column)
      projection[row][column] = static_cast<Ogre::Real>(view.clip_from_view[4 * row + column]);
  camera_->setCustomProjectionMatrix(true, projection);
}

void SceneCamera::draw(const Ogre::ColourValue& background)
{
  target_->getViewport(0)->setBackgroundColour(background);
  target_->update(false);
}
}  // namespace rviz_camera_stream
