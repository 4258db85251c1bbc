// Reads a drawn texture back without waiting for the graphics card.
#ifndef RVIZ_CAMERA_STREAM_PIXEL_READER_H
#define RVIZ_CAMERA_STREAM_PIXEL_READER_H

#include <cstdint>
#include <memory>
#include <vector>

namespace Ogre
{
class RenderTexture;
}

namespace rviz_camera_stream
{
/// Pixels as OpenGL has them, four bytes each: blue, green, red, alpha; and depths, where they were asked for.
struct ReadPixels
{
  uint32_t width = 0;
  uint32_t height = 0;
  /// The first row is the picture's last one.
  bool bottom_up = false;
  std::vector<uint8_t> bgra;
  /// One for each pixel, 0 at the near clip distance to 1 at the far one; empty if they were not asked for.
  std::vector<float> depths;
};

/// Copies what was drawn into pixel buffers of OpenGL: `begin` returns at once, and the pixels are fetched when the
/// graphics card is done with them. Where the driver has no such buffers or has failed with them once, or the environment
/// variable RVIZ_CAMERA_STREAM_READBACK is `direct`, `begin` waits and copies.
///
/// Used on the thread that draws. All of Ogre's contexts share their buffers, so any of them may be current.
class PixelReader
{
public:
  PixelReader();
  ~PixelReader();
  PixelReader(const PixelReader&) = delete;
  PixelReader& operator=(const PixelReader&) = delete;

  /// Begins to read what was just drawn into the texture, whose frame buffer is still bound. Abandons what was being
  /// read. Throws Ogre::Exception if the pixels cannot be copied at all, std::bad_alloc if they do not fit memory.
  void begin(Ogre::RenderTexture& drawn, bool with_depths);

  /// Whether something is being read.
  bool pending() const;

  /// Whether it can be fetched without waiting.
  bool ready() const;

  /// Fetches what is being read, waiting for it where that is necessary. Returns false if nothing is being read or the
  /// driver lost it. Throws std::bad_alloc if the pixels do not fit memory.
  bool fetch(ReadPixels& pixels);

  /// Abandons what is being read.
  void abandon();

private:
  struct Buffers;
  void copyNow(Ogre::RenderTexture& drawn);
  void giveUpBuffers();

  std::unique_ptr<Buffers> buffers_;
  ReadPixels layout_;
  bool with_depths_ = false;
  bool pending_ = false;
  /// Whether the driver has failed with pixel buffers, which are then not tried again.
  bool buffers_failed_ = false;
  /// Copied already, without buffers.
  bool copied_ = false;
};
}  // namespace rviz_camera_stream

#endif
