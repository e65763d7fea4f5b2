#pragma once
/// Diagnostics of a plugin lead nowhere: its tasks are kept, and run when it forces an update.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "diagnostic_updater/diagnostic_status_wrapper.hpp"
#include "polyarm_ros/door.hpp"

namespace diagnostic_updater {

using TaskFunction = std::function<void(DiagnosticStatusWrapper&)>;

class DiagnosticTask {
 public:
  explicit DiagnosticTask(const std::string& name) : name_(name) {}
  virtual ~DiagnosticTask() = default;
  const std::string& getName() const { return name_; }
  virtual void run(DiagnosticStatusWrapper& status) = 0;

 private:
  std::string name_;
};

class Updater {
 public:
  template <typename NodePointer>
  explicit Updater(const NodePointer& node, double = 1.0) {
    polyarm_ros::report_unavailable(node->get_name(), "topic", "/diagnostics");
  }
  template <typename... Interfaces>
  explicit Updater(Interfaces&&...) {}
  void add(const std::string& name, TaskFunction task) { tasks_.emplace_back(name, std::move(task)); }
  void add(DiagnosticTask& task) {
    add(task.getName(), [&task](DiagnosticStatusWrapper& status) { task.run(status); });
  }
  template <class T>
  void add(const std::string& name, T* object, void (T::*call)(DiagnosticStatusWrapper&)) {
    add(name, [object, call](DiagnosticStatusWrapper& status) { (object->*call)(status); });
  }
  bool removeByName(const std::string& name) {
    for (auto at = tasks_.begin(); at != tasks_.end(); ++at)
      if (at->first == name) return tasks_.erase(at), true;
    return false;
  }
  void setHardwareID(const std::string&) {}
  void setHardwareIDf(const char*, ...) {}
  void setPeriod(double) {}
  void force_update() {
    for (auto& [name, task] : tasks_) {
      DiagnosticStatusWrapper status;
      task(status);
    }
  }
  void broadcast(unsigned char, const std::string&) {}

 private:
  std::vector<std::pair<std::string, TaskFunction>> tasks_;
};

}  // namespace diagnostic_updater
