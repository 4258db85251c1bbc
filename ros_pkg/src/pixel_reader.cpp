#include "pixel_reader.h"

#include <cstdlib>
#include <cstring>

#include <OgreHardwarePixelBuffer.h>
#include <OgrePixelFormat.h>
#include <OgreRenderTexture.h>
#include <OgreRoot.h>
#include <OgreRenderSystem.h>

#define GL_GLEXT_PROTOTYPES 0
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>

namespace rviz_camera_stream
{
// Not in the anonymous namespace, because a class with external linkage has a member of this type.
namespace opengl
{
/// Loads a function of OpenGL; null if the driver lacks it.
template <typename Function>
void load(Function& function, const char* name)
{
  function = reinterpret_cast<Function>(glXGetProcAddressARB(reinterpret_cast<const GLubyte*>(name)));
}

/// Functions beyond OpenGL 1.1.
struct Functions
{
  PFNGLGENBUFFERSPROC gen_buffers = nullptr;
  PFNGLDELETEBUFFERSPROC delete_buffers = nullptr;
  PFNGLBINDBUFFERPROC bind_buffer = nullptr;
  PFNGLBUFFERDATAPROC buffer_data = nullptr;
  PFNGLMAPBUFFERPROC map_buffer = nullptr;
  PFNGLUNMAPBUFFERPROC unmap_buffer = nullptr;
  PFNGLFENCESYNCPROC fence_sync = nullptr;
  PFNGLCLIENTWAITSYNCPROC client_wait_sync = nullptr;
  PFNGLDELETESYNCPROC delete_sync = nullptr;
  bool complete = false;

  Functions()
  {
    load(gen_buffers, "glGenBuffers");
    load(delete_buffers, "glDeleteBuffers");
    load(bind_buffer, "glBindBuffer");
    load(buffer_data, "glBufferData");
    load(map_buffer, "glMapBuffer");
    load(unmap_buffer, "glUnmapBuffer");
    load(fence_sync, "glFenceSync");
    load(client_wait_sync, "glClientWaitSync");
    load(delete_sync, "glDeleteSync");
    complete = gen_buffers && delete_buffers && bind_buffer && buffer_data && map_buffer && unmap_buffer && fence_sync &&
               client_wait_sync && delete_sync;
  }
};

}  // namespace opengl

namespace
{
/// GLX returns an address for any name, so this checks for OpenGL 3.2 or the extension.
bool hasBuffersAndFences()
{
  const auto* version = reinterpret_cast<const char*>(glGetString(GL_VERSION));
  const double number = version ? std::atof(version) : 0.0;
  if (number >= 3.2)
    return true;
  const auto* extensions = reinterpret_cast<const char*>(glGetString(GL_EXTENSIONS));
  return number >= 2.1 && extensions && std::strstr(extensions, "GL_ARB_sync");
}

/// True if the texture's frame buffer is bound: with OpenGL, Ogre draws into textures through frame buffers, unless the
/// driver has none.
bool isReadable()
{
  const Ogre::String& name = Ogre::Root::getSingleton().getRenderSystem()->getName();
  if (name.find("OpenGL") == Ogre::String::npos)
    return false;
  GLint bound = 0;
  glGetIntegerv(GL_FRAMEBUFFER_BINDING, &bound);
  return bound != 0;
}

/// Clears earlier errors. There is one of each kind, but a lost context may report errors for ever.
void forgetErrors()
{
  const int most = 16;
  for (int i = 0; i < most && glGetError() != GL_NO_ERROR; ++i)
  {
  }
}

/// Selects the bound frame buffer's texture for reading colours, and restores the selection: Ogre 1.9 selects none.
class ReadingColours
{
public:
  ReadingColours()
  {
    glGetIntegerv(GL_READ_BUFFER, &before_);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
  }
  ~ReadingColours()
  {
    glReadBuffer(static_cast<GLenum>(before_));
  }
  ReadingColours(const ReadingColours&) = delete;
  ReadingColours& operator=(const ReadingColours&) = delete;

private:
  GLint before_ = GL_NONE;
};

/// Sets pixel packing without gaps, and restores it.
class TightPacking
{
public:
  TightPacking()
  {
    for (size_t i = 0; i < COUNT; ++i)
    {
      glGetIntegerv(NAMES[i], &before_[i]);
      glPixelStorei(NAMES[i], NAMES[i] == GL_PACK_ALIGNMENT ? 1 : 0);
    }
  }
  ~TightPacking()
  {
    for (size_t i = 0; i < COUNT; ++i)
      glPixelStorei(NAMES[i], before_[i]);
  }
  TightPacking(const TightPacking&) = delete;
  TightPacking& operator=(const TightPacking&) = delete;

private:
  static const size_t COUNT = 4;
  static const GLenum NAMES[COUNT];
  GLint before_[COUNT];
};
const GLenum TightPacking::NAMES[] = { GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH, GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS };
}  // namespace

/// A buffer for colours, one for depths, and the fence after the copies.
struct PixelReader::Buffers
{
  opengl::Functions gl;
  GLuint names[2] = { 0, 0 };
  GLsizeiptr sizes[2] = { 0, 0 };
  GLsync fence = nullptr;

  Buffers()
  {
    if (gl.complete)
      gl.gen_buffers(2, names);
  }
  ~Buffers()
  {
    dropFence();
    if (gl.complete)
      gl.delete_buffers(2, names);
  }

  void dropFence()
  {
    if (fence)
      gl.delete_sync(fence);
    fence = nullptr;
  }

  /// Copies from the frame buffer into the buffer of this index.
  void copy(int index, GLsizei width, GLsizei height, GLenum format, GLenum type)
  {
    const GLsizeiptr size = GLsizeiptr(4) * width * height;
    gl.bind_buffer(GL_PIXEL_PACK_BUFFER, names[index]);
    if (sizes[index] != size)
    {
      gl.buffer_data(GL_PIXEL_PACK_BUFFER, size, nullptr, GL_STREAM_READ);
      sizes[index] = size;
    }
    glReadPixels(0, 0, width, height, format, type, nullptr);
  }

  /// Copies `size` bytes of a buffer into memory, waiting for the driver.
  bool fetch(int index, void* to, size_t size)
  {
    gl.bind_buffer(GL_PIXEL_PACK_BUFFER, names[index]);
    const void* mapped = gl.map_buffer(GL_PIXEL_PACK_BUFFER, GL_READ_ONLY);
    if (mapped)
      std::memcpy(to, mapped, size);
    // Unmapping fails if the buffer was lost.
    return mapped && gl.unmap_buffer(GL_PIXEL_PACK_BUFFER);
  }
};

PixelReader::PixelReader() = default;
PixelReader::~PixelReader() = default;

void PixelReader::begin(Ogre::RenderTexture& drawn, bool with_depths)
{
  abandon();
  layout_.width = drawn.getWidth();
  layout_.height = drawn.getHeight();
  // Ogre draws into a texture upside down, so OpenGL's lowest row is the picture's first.
  layout_.bottom_up = !drawn.requiresTextureFlipping();
  with_depths_ = with_depths;

  const char* how = std::getenv("RVIZ_CAMERA_STREAM_READBACK");
  const bool direct = how && std::strcmp(how, "direct") == 0;
  const bool readable = isReadable();
  if (!buffers_ && !buffers_failed_ && readable && !direct && hasBuffersAndFences())
  {
    buffers_.reset(new Buffers);
    if (!buffers_->gl.complete)
      giveUpBuffers();
  }
  if (!buffers_ || !readable || direct)
  {
    copyNow(drawn);
    return;
  }

  forgetErrors();
  {
    const ReadingColours colours;
    const TightPacking packing;
    const GLsizei width = static_cast<GLsizei>(layout_.width), height = static_cast<GLsizei>(layout_.height);
    buffers_->copy(0, width, height, GL_BGRA, GL_UNSIGNED_BYTE);
    if (with_depths)
      buffers_->copy(1, width, height, GL_DEPTH_COMPONENT, GL_FLOAT);
    buffers_->gl.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
  }
  buffers_->fence = buffers_->gl.fence_sync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (glGetError() != GL_NO_ERROR)
  {
    giveUpBuffers();
    copyNow(drawn);
    return;
  }
  pending_ = true;
}

/// Disables buffers, because the driver failed: pixels are then copied directly.
void PixelReader::giveUpBuffers()
{
  abandon();
  buffers_.reset();
  buffers_failed_ = true;
}

/// Waits for the texture and copies its colours, and the depths if its frame buffer can be read.
void PixelReader::copyNow(Ogre::RenderTexture& drawn)
{
  const uint32_t width = layout_.width, height = layout_.height;
  layout_.bgra.resize(size_t(4) * width * height);
  layout_.depths.clear();
  if (isReadable())
  {
    const ReadingColours colours;
    const TightPacking packing;
    const GLsizei w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
    glReadPixels(0, 0, w, h, GL_BGRA, GL_UNSIGNED_BYTE, layout_.bgra.data());
    if (with_depths_)
    {
      layout_.depths.resize(size_t(width) * height);
      glReadPixels(0, 0, w, h, GL_DEPTH_COMPONENT, GL_FLOAT, layout_.depths.data());
    }
  }
  else
  {
    // Ogre returns the rows from the top.
    layout_.bottom_up = false;
    const Ogre::PixelBox box(width, height, 1, Ogre::PF_BYTE_BGRA, layout_.bgra.data());
#if OGRE_VERSION < ((1 << 16) | (10 << 8))
    drawn.copyContentsToMemory(box, Ogre::RenderTarget::FB_AUTO);
#else
    drawn.copyContentsToMemory(Ogre::Box(0, 0, width, height), box, Ogre::RenderTarget::FB_AUTO);
#endif
  }
  copied_ = pending_ = true;
}

bool PixelReader::pending() const
{
  return pending_;
}

bool PixelReader::ready() const
{
  if (!pending_ || copied_)
    return pending_;
  const GLenum state = buffers_->gl.client_wait_sync(buffers_->fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
  // On failure, fetching fails.
  return state != GL_TIMEOUT_EXPIRED;
}

bool PixelReader::fetch(ReadPixels& pixels)
{
  if (!pending_)
    return false;
  pixels.width = layout_.width;
  pixels.height = layout_.height;
  pixels.bottom_up = layout_.bottom_up;
  bool fetched = true;
  if (copied_)
  {
    pixels.bgra.swap(layout_.bgra);
    pixels.depths.swap(layout_.depths);
  }
  else
  {
    const size_t count = size_t(pixels.width) * pixels.height;
    pixels.bgra.resize(4 * count);
    pixels.depths.resize(with_depths_ ? count : 0);
    fetched = buffers_->fetch(0, pixels.bgra.data(), 4 * count);
    if (with_depths_)
      fetched = buffers_->fetch(1, pixels.depths.data(), 4 * count) && fetched;
    buffers_->gl.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
  }
  abandon();
  return fetched;
}

void PixelReader::abandon()
{
  if (buffers_)
    buffers_->dropFence();
  pending_ = copied_ = false;
}
}  // namespace rviz_camera_stream
