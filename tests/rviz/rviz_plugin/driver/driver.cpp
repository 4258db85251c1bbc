#include "driver.h"

#include <malloc.h>

#include <stdexcept>

#include <OgreResourceManager.h>
#include <OgreRoot.h>
#include <OgreSceneManager.h>
#include <OgreTextureManager.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/config.h>
#include <rviz/display_group.h>
#include <rviz/properties/status_list.h>
#include <rviz/properties/status_property.h>
#include <rviz/visualization_manager.h>
#include <rviz/yaml_config_writer.h>

namespace rviz_test_driver
{
namespace
{
std::runtime_error fault(const QString& text)
{
  return std::runtime_error(text.toStdString());
}

const QString& word(const QStringList& words, int index)
{
  if (index >= words.size())
    throw fault(QString("argument %1 is missing").arg(index + 1));
  return words[index];
}

rviz::Property& childOf(rviz::Property& parent, const QString& name)
{
  for (int i = 0; i < parent.numChildren(); ++i)
  {
    if (parent.childAt(i)->getName() == name)
      return *parent.childAt(i);
  }
  throw fault("no property " + name);
}

/// A line for each status: level (0 ok, 1 warning, 2 error), name and text, separated by tabs.
QString statuses(rviz::Property& display)
{
  QStringList lines;
  for (int i = 0; i < display.numChildren(); ++i)
  {
    const auto* list = dynamic_cast<rviz::StatusList*>(display.childAt(i));
    for (int j = 0; list && j < list->numChildren(); ++j)
    {
      const auto* status = dynamic_cast<rviz::StatusProperty*>(list->childAt(j));
      if (status)
        lines << QString("%1\t%2\t%3").arg(int(status->getLevel())).arg(status->getName(), status->getValue().toString());
    }
  }
  return lines.join("\n");
}

/// How many of what may leak there are.
QString resources(const Ogre::SceneManager& scene)
{
  size_t textures = 0;
  Ogre::ResourceManager::ResourceMapIterator all = Ogre::TextureManager::getSingleton().getResourceIterator();
  while (all.hasMoreElements())
  {
    all.getNext();
    ++textures;
  }
  return QString("textures %1 bytes %2 cameras %3")
      .arg(textures)
      .arg(Ogre::TextureManager::getSingleton().getMemoryUsage())
      .arg(scene.getCameras().size());
}

/// The bytes that are allocated in all of the process's arenas and mappings; not what was freed and is kept for reuse, which
/// depends on the order of events.
QString allocatedBytes()
{
#if __GLIBC_PREREQ(2, 33)
  const struct mallinfo2 heap = mallinfo2();
  return QString::number(heap.uordblks + heap.hblkhd);
#else
  // Numbers of 32 bits.
  const struct mallinfo heap = mallinfo();
  return QString::number(qulonglong(unsigned(heap.uordblks)) + unsigned(heap.hblkhd));
#endif
}
}  // namespace

void Driver::onInitialize()
{
  answers_ = update_nh_.advertise<std_msgs::String>("/driver/answer", 100);
  commands_ = update_nh_.subscribe("/driver/command", 100, &Driver::receive, this);
  connect(&manager(), SIGNAL(preUpdate()), this, SLOT(frameBegins()));
  Ogre::Root::getSingleton().addFrameListener(this);
}

Driver::~Driver()
{
  if (commands_)
    Ogre::Root::getSingleton().removeFrameListener(this);
}

void Driver::frameBegins()
{
  begun_ = Clock::now();
}

bool Driver::frameEnded(const Ogre::FrameEvent&)
{
  busy_secs_ += std::chrono::duration<double>(Clock::now() - begun_).count();
  ++busy_frames_;
  return true;
}

void Driver::receive(const std_msgs::String::ConstPtr& message)
{
  const QStringList words = QString::fromStdString(message->data).split('\t');
  QString answer = words.value(0) + "\t";
  try
  {
    answer += "ok\t" + obey(word(words, 1), words.mid(2));
  }
  catch (const std::exception& error)
  {
    answer += QString("error\t") + error.what();
  }
  std_msgs::String reply;
  reply.data = answer.toStdString();
  answers_.publish(reply);
}

rviz::VisualizationManager& Driver::manager()
{
  auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_);
  if (!manager)
    throw fault("no VisualizationManager");
  return *manager;
}

rviz::Display& Driver::display(const QString& name)
{
  rviz::DisplayGroup& root = *context_->getRootDisplayGroup();
  for (int i = 0; i < root.numDisplays(); ++i)
  {
    if (root.getDisplayAt(i)->getName() == name)
      return *root.getDisplayAt(i);
  }
  throw fault("no display " + name);
}

/// create NAME CLASS · reset · config · resources · allocated · frames · busy, or a command for the display that comes first.
QString Driver::obey(const QString& command, const QStringList& words)
{
  if (command == "create")
  {
    manager().createDisplay(word(words, 1), word(words, 0), true);
    return QString();
  }
  if (command == "reset")
  {
    manager().resetTime();
    return QString();
  }
  if (command == "config")
  {
    rviz::Config config;
    manager().save(config);
    return rviz::YamlConfigWriter().writeString(config);
  }
  if (command == "resources")
    return resources(*context_->getSceneManager());
  if (command == "allocated")
    return allocatedBytes();
  if (command == "busy")
  {
    // The frames since the last time, and the seconds that rviz's main thread spent on them.
    const QString text = QString("%1 %2").arg(busy_frames_).arg(busy_secs_);
    busy_frames_ = 0;
    busy_secs_ = 0.0;
    return text;
  }
  if (command == "frames")
    return QString::number(context_->getFrameCount());
  return obeyForDisplay(command, display(word(words, 0)), words);
}

/// remove · rename NEW · duplicate NEW · enable 0|1 · topic TOPIC TYPE · set PROPERTY VALUE · get PROPERTY · properties ·
/// statuses · settings
QString Driver::obeyForDisplay(const QString& command, rviz::Display& display, const QStringList& words)
{
  if (command == "remove")
  {
    // As rviz's panel removes one.
    delete &display;
    return QString();
  }
  if (command == "rename")
  {
    display.setName(word(words, 1));
    return QString();
  }
  if (command == "duplicate")
  {
    rviz::Config config;
    display.save(config);
    rviz::Display* copy = manager().createDisplay(display.getClassId(), display.getName(), true);
    copy->load(config);
    copy->setName(word(words, 1));
    return QString();
  }
  if (command == "enable")
  {
    display.setEnabled(word(words, 1) == "1");
    return QString();
  }
  if (command == "topic")
  {
    display.setTopic(word(words, 1), word(words, 2));
    return QString();
  }
  if (command == "set")
  {
    childOf(display, word(words, 1)).setValue(word(words, 2));
    return QString();
  }
  if (command == "get")
    return childOf(display, word(words, 1)).getValue().toString();
  if (command == "properties")
  {
    // A line for each: name, value and help, separated by tabs.
    QStringList lines;
    for (int i = 0; i < display.numChildren(); ++i)
    {
      rviz::Property& property = *display.childAt(i);
      lines << property.getName() + "\t" + property.getValue().toString() + "\t" + property.getDescription();
    }
    return lines.join("\n");
  }
  if (command == "statuses")
    return statuses(display);
  if (command == "settings")
  {
    rviz::Config config;
    display.save(config);
    return rviz::YamlConfigWriter().writeString(config);
  }
  throw fault("no command " + command);
}
}  // namespace rviz_test_driver

PLUGINLIB_EXPORT_CLASS(rviz_test_driver::Driver, rviz::Display)
