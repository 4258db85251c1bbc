// A camera of Ogre that draws rviz's scene into a texture.
#ifndef RVIZ_CAMERA_STREAM_SCENE_CAMERA_H
#define RVIZ_CAMERA_STREAM_SCENE_CAMERA_H

#include <cstdint>
#include <string>

#include <OgreColourValue.h>
#include <OgreNode.h>
#include <OgreTexture.h>

#include "rviz_camera_stream/core.h"

namespace Ogre
{
class Camera;
class RenderTexture;
class SceneManager;
class SceneNode;
}  // namespace Ogre

namespace rviz_camera_stream
{
/// Draws the scene from a CameraInfo's camera. The texture is created with the first picture and again when the size
/// changes. Used on the thread that draws.
class SceneCamera
{
public:
  /// `visibility_mask`: the bit of drawn objects.
  SceneCamera(Ogre::SceneManager& scene, uint32_t visibility_mask);
  ~SceneCamera();
  SceneCamera(const SceneCamera&) = delete;
  SceneCamera& operator=(const SceneCamera&) = delete;

  /// Places the camera at `position` and `orientation` of the optical frame (x right, y down, z forward) in the fixed
  /// frame. Throws Ogre::Exception if a texture of the view's size cannot be created.
  void setView(const Ogre::Vector3& position, const Ogre::Quaternion& orientation, const RcsView& view);

  /// Draws one picture on a background. Call setView before.
  void draw(const Ogre::ColourValue& background);

  /// The drawn texture; null before the first setView.
  Ogre::RenderTexture* target() const
  {
    return target_;
  }

  /// Releases the texture.
  void releaseTexture();

private:
  void prepareTexts();
  void createTexture(uint32_t width, uint32_t height);

  Ogre::SceneManager& scene_;
  uint32_t visibility_mask_;
  std::string name_;
  Ogre::Camera* camera_;
  Ogre::SceneNode* node_;
  Ogre::TexturePtr texture_;
  Ogre::RenderTexture* target_ = nullptr;
};
}  // namespace rviz_camera_stream

#endif
