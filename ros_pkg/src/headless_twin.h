// Keeps a copy of rviz's config for the node camera_stream, which draws it without rviz.
#ifndef RVIZ_CAMERA_STREAM_HEADLESS_TWIN_H
#define RVIZ_CAMERA_STREAM_HEADLESS_TWIN_H

#include <string>

namespace rviz
{
class VisualizationManager;
}

namespace rviz_camera_stream
{
/// Result of writing a twin.
struct TwinReport
{
  /// Error, or empty.
  std::string error;
  /// The displays and settings that the node cannot draw, separated by semicolons; empty if it draws all.
  std::string not_drawn;
  /// The command that draws the config without rviz.
  std::string launch_line;
};

/// Writes rviz's current config to a file whenever it has changed.
class HeadlessTwin
{
public:
  /// Writes the config to `path` (`~/` is the home folder; relative to rviz's working directory) if its text differs
  /// from the last one. The file is replaced atomically. Returns true if the report is new.
  bool write(const rviz::VisualizationManager& manager, const std::string& path);

  const TwinReport& report() const
  {
    return report_;
  }

  /// Forgets the written config, so that the next one is written.
  void forget();

private:
  std::string written_path_;
  std::string written_text_;
  TwinReport report_;
};
}  // namespace rviz_camera_stream

#endif
