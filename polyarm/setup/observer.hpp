#pragma once
/// Receives the events of a running cell.
#include <algorithm>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::cell {

struct StopReport;

/// Base class of observers; functions are called in the order of events, on the cell thread.
class Observer {
 public:
  virtual ~Observer() = default;
  virtual void on_note(const std::string& text) {}
  virtual void on_line(Nanoseconds time, const std::string& task, const Location& where,
                       const std::string& source) {}
  virtual void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
                      const std::string& who) {}
  virtual void on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) {}
  virtual void on_log(Nanoseconds time, const std::string& task, const std::string& text) {}
  /// The state of the loop has changed. `cause`: like LifeCycle::stop_cause().
  virtual void on_state(Nanoseconds time, const std::string& state, const Problem& cause) {}
  /// A stop has ended.
  virtual void on_stop(Nanoseconds time, const StopReport& stop) {}
  virtual void on_question(const std::string& text) {}
  virtual void on_problem(Nanoseconds time, const Problem& problem) {}
};

/// Forwards events to several observers, in order of addition. Cell thread; do not add or remove one during
/// an event.
class Observers : public Observer {
 public:
  /// Adds an observer once, even if called again.
  void add(Observer& observer) {
    if (std::find(list_.begin(), list_.end(), &observer) == list_.end()) list_.push_back(&observer);
  }
  void remove(Observer& observer) { std::erase(list_, &observer); }

  void on_note(const std::string& text) override {
    for (Observer* each : list_) each->on_note(text);
  }
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override {
    for (Observer* each : list_) each->on_line(time, task, where, source);
  }
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override {
    for (Observer* each : list_) each->on_tag(time, name, value, who);
  }
  void on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) override {
    for (Observer* each : list_) each->on_pose(time, robot, tcp);
  }
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    for (Observer* each : list_) each->on_log(time, task, text);
  }
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override {
    for (Observer* each : list_) each->on_state(time, state, cause);
  }
  void on_stop(Nanoseconds time, const StopReport& stop) override {
    for (Observer* each : list_) each->on_stop(time, stop);
  }
  void on_question(const std::string& text) override {
    for (Observer* each : list_) each->on_question(text);
  }
  void on_problem(Nanoseconds time, const Problem& problem) override {
    for (Observer* each : list_) each->on_problem(time, problem);
  }

 private:
  std::vector<Observer*> list_;
};

}  // namespace polyarm::cell
