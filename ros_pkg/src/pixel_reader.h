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
/// Pixels of four bytes, blue, green, red, alpha, and depths if requested.
struct ReadPixels
{
  uint32_t width = 0;
  uint32_t height = 0;
  /// True if the first row is the picture's last one.
  bool bottom_up = false;
  std::vector<uint8_t> bgra;
  /// Depth of each pixel, 0 at the near clip distance to 1 at the far one; empty if not requested.
  std::vector<float> depths;
};

/// Copies the drawn picture into pixel buffers of OpenGL: `begin` returns at once, and the pixels are fetched when the
/// graphics card has copied them. If the driver has no such buffers or has failed with them, or the environment
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

  /// Begins to read the texture that was just drawn and whose frame buffer is still bound. Abandons an earlier read.
  /// Throws Ogre::Exception if the pixels cannot be copied, std::bad_alloc if they do not fit memory.
  void begin(Ogre::RenderTexture& drawn, bool with_depths);

  /// True during a read.
  bool pending() const;

  /// True if the pixels can be fetched without waiting.
  bool ready() const;

  /// Fetches the pixels, waiting if necessary. Returns false without a read or if the driver lost them. Throws
  /// std::bad_alloc if the pixels do not fit memory.
  bool fetch(ReadPixels& pixels);

  /// Abandons the read.
  void abandon();

private:
  struct Buffers;
  void copyNow(Ogre::RenderTexture& drawn);
  void giveUpBuffers();

  std::unique_ptr<Buffers> buffers_;
  ReadPixels layout_;
  bool with_depths_ = false;
  bool pending_ = false;
  /// True after the driver has failed with pixel buffers.
  bool buffers_failed_ = false;
  /// True if the pixels were copied without buffers.
  bool copied_ = false;
};
}  // namespace rviz_camera_stream

#endif
