// Keeps a copy of rviz's config for the node camera_stream, which draws it without rviz.
#ifndef RVIZ_CAMERA_STREAM_HEADLESS_TWIN_H
#define RVIZ_CAMERA_STREAM_HEADLESS_TWIN_H

#include <cstdint>
#include <string>

namespace rviz
{
class VisualizationManager;
}

namespace rviz_camera_stream
{
/// What became of a twin.
struct TwinReport
{
  /// Why there is none, or empty.
  std::string error;
  /// The displays and settings that the node cannot draw, separated by semicolons; empty if it draws all.
  std::string not_drawn;
  uint32_t displays_not_drawn = 0;
  /// The command that draws the same without rviz.
  std::string launch_line;
};

/// Writes rviz's current config to a file whenever it has changed.
class HeadlessTwin
{
public:
  /// Writes the config to `path` (`~/` is the home folder; relative to rviz's working directory) if its text differs from
  /// what was written there last. A file is replaced in one step, so that a node that watches it never reads half of it.
  /// Returns whether there is something new to report.
  bool write(const rviz::VisualizationManager& manager, const std::string& path);

  const TwinReport& report() const
  {
    return report_;
  }

  /// Forgets what was written, so that the next one is written again.
  void forget();

private:
  std::string written_path_;
  std::string written_text_;
  TwinReport report_;
};
}  // namespace rviz_camera_stream

#endif
