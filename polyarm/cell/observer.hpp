#pragma once
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::cell {

struct StopReport;

/// Told what happens in a running cell, in order, on the cell thread.
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
  virtual void on_state(Nanoseconds time, const std::string& state, const std::string& cause) {}
  /// A stop has ended.
  virtual void on_stop(Nanoseconds time, const StopReport& stop) {}
  virtual void on_question(const std::string& text) {}
  virtual void on_problem(Nanoseconds time, const Problem& problem) {}
};

}  // namespace polyarm::cell
