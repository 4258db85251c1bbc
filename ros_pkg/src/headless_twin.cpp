#include "headless_twin.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

#include <QDir>
#include <QFileInfo>
#include <QString>

#include <rviz/config.h>
#include <rviz/visualization_manager.h>
#include <rviz/yaml_config_writer.h>

#include "core_camera.h"

namespace rviz_camera_stream
{
namespace
{
std::string absolutePath(const std::string& path)
{
  QString file = QString::fromStdString(path);
  if (file == "~" || file.startsWith("~/"))
    file = QDir::homePath() + file.mid(1);
  return QFileInfo(file).absoluteFilePath().toStdString();
}

/// Writes a temporary file and renames it. Returns an error, or an empty text.
std::string replaceFile(const std::string& path, const std::string& text)
{
  const std::string beside = path + ".new";
  {
    std::ofstream out(beside, std::ios::binary | std::ios::trunc);
    out << text;
    out.close();
    if (!out)
      return "cannot write " + beside + ": " + std::strerror(errno);
  }
  if (std::rename(beside.c_str(), path.c_str()) != 0)
  {
    const std::string why = std::strerror(errno);
    std::remove(beside.c_str());
    return "cannot write " + path + ": " + why;
  }
  return std::string();
}

/// The config as written by rviz's "Save Config", without the window's layout.
std::string configText(const rviz::VisualizationManager& manager, std::string& error)
{
  rviz::Config config;
  manager.save(config.mapMakeChild("Visualization Manager"));
  rviz::YamlConfigWriter writer;
  const QString text = writer.writeString(config);
  if (writer.error())
    error = writer.errorMessage().toStdString();
  // The writer ends without a line break.
  return text.toStdString() + "\n";
}

/// The core's report on the config.
TwinReport check(const std::string& text, const std::string& path)
{
  TwinReport report;
  std::vector<char> lines(256), launch(256);
  RcsText lines_text{}, launch_text{};
  RcsResult result = RCS_RESULT_OK;
  for (int attempt = 0; attempt < 2; ++attempt)
  {
    lines_text = { lines.data(), lines.size(), 0 };
    launch_text = { launch.data(), launch.size(), 0 };
    result = rcs_config_report(text.data(), text.size(), path.c_str(), &lines_text, &launch_text);
    if (result != RCS_RESULT_OK || (lines_text.needed < lines.size() && launch_text.needed < launch.size()))
      break;
    lines.resize(lines_text.needed + 1);
    launch.resize(launch_text.needed + 1);
  }
  if (result != RCS_RESULT_OK)
  {
    report.error = coreError();
    return report;
  }
  report.not_drawn = lines.data();
  // A status is one line.
  for (size_t at = report.not_drawn.find('\n'); at != std::string::npos; at = report.not_drawn.find('\n', at))
    report.not_drawn.replace(at, 1, "; ");
  report.launch_line = launch.data();
  return report;
}
}  // namespace

bool HeadlessTwin::write(const rviz::VisualizationManager& manager, const std::string& path)
{
  const std::string absolute = absolutePath(path);
  TwinReport report;
  const std::string text = configText(manager, report.error);
  if (report.error.empty() && text == written_text_ && absolute == written_path_)
    return false;
  if (report.error.empty())
    report.error = replaceFile(absolute, text);
  const std::string error = report.error;
  if (error.empty())
    report = check(text, absolute);
  written_text_ = error.empty() ? text : std::string();
  written_path_ = absolute;
  const bool is_new = report.error != report_.error || report.not_drawn != report_.not_drawn ||
                      report.launch_line != report_.launch_line || error.empty();
  report_ = report;
  return is_new;
}

void HeadlessTwin::forget()
{
  *this = HeadlessTwin();
}
}  // namespace rviz_camera_stream
