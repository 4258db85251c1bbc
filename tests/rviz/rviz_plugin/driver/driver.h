// A display that operates rviz from outside.
#ifndef RVIZ_TEST_DRIVER_DRIVER_H
#define RVIZ_TEST_DRIVER_DRIVER_H

#include <chrono>

#include <OgreFrameListener.h>
#include <QStringList>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <rviz/display.h>
#include <std_msgs/String.h>

namespace rviz
{
class VisualizationManager;
}

namespace rviz_test_driver
{
/// Obeys commands on the topic /driver/command and answers on /driver/answer (std_msgs/String). A command's words are
/// separated by tabs: a number, the command, its arguments. An answer is the number, `ok` or `error`, and a text, separated
/// by tabs. Commands run on rviz's main thread, between two frames; see `obey` for what there is.
class Driver : public rviz::Display, public Ogre::FrameListener
{
  Q_OBJECT

public:
  ~Driver() override;

  /// rviz's window has been drawn.
  bool frameEnded(const Ogre::FrameEvent& event) override;

protected:
  void onInitialize() override;

private Q_SLOTS:
  /// rviz begins to update its displays.
  void frameBegins();

private:
  using Clock = std::chrono::steady_clock;

  void receive(const std_msgs::String::ConstPtr& message);
  QString obey(const QString& command, const QStringList& words);
  QString obeyForDisplay(const QString& command, rviz::Display& display, const QStringList& words);
  rviz::VisualizationManager& manager();
  rviz::Display& display(const QString& name);

  ros::Subscriber commands_;
  ros::Publisher answers_;
  Clock::time_point begun_;
  /// Time between `frameBegins` and `frameEnded`, and how often that was.
  double busy_secs_ = 0.0;
  unsigned busy_frames_ = 0;
};
}  // namespace rviz_test_driver

#endif
