// Texts of the C interface, which writes to the caller's buffer and returns the whole length, as snprintf does.
#ifndef RVIZ_CAMERA_STREAM_CORE_TEXT_H
#define RVIZ_CAMERA_STREAM_CORE_TEXT_H

#include <cstddef>
#include <string>

namespace rviz_camera_stream
{
/// The whole text of `write(buffer, length)`.
template <typename Write>
std::string coreText(const Write& write)
{
  std::string text(256, '\0');
  const size_t needed = write(&text[0], text.size());
  if (needed >= text.size())
  {
    text.resize(needed + 1);
    write(&text[0], text.size());
  }
  text.resize(needed);
  return text;
}
}  // namespace rviz_camera_stream

#endif
