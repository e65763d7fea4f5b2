#pragma once
/// Log lines and alarms of a cell, kept for clients that connect later.
#include <cstdint>
#include <deque>
#include <string>

#include "polyarm/setup/observer.hpp"

namespace polyarm::server {

/// Forwards everything to the next observer. Cell thread.
class Journal : public cell::Observer {
 public:
  static constexpr std::size_t kKept = 500;

  /// `next` must outlive this.
  explicit Journal(cell::Observer& next) : next_(next) {}

  struct Line {
    std::uint64_t number = 0;    ///< counts up from 1
    double time = 0;             ///< cell time, s
    const char* level = "info";  ///< info, warning, error, log (a program's own), question
    std::string text;
    /// Code and facts let pages translate the line; without a code there is only `text`.
    std::string code = {};
    Facts facts = {};
  };
  struct Alarm {
    std::uint64_t number = 0;
    double time = 0;
    Problem problem;
  };
  const std::deque<Line>& lines() const { return lines_; }
  const std::deque<Alarm>& alarms() const { return alarms_; }
  std::uint64_t last_line() const { return last_line_; }
  std::uint64_t last_alarm() const { return last_alarm_; }
  /// Cell time for events that carry no time.
  void set_now(Nanoseconds now) { now_ = seconds(now); }

  void on_note(const std::string& text) override;
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override;
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override;
  void on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) override;
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override;
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override;
  void on_stop(Nanoseconds time, const cell::StopReport& stop) override;
  void on_question(const std::string& text) override;
  void on_problem(Nanoseconds time, const Problem& problem) override;

 private:
  void keep(double time, const char* level, std::string text, std::string code = {}, Facts facts = {});

  cell::Observer& next_;
  std::deque<Line> lines_;
  std::deque<Alarm> alarms_;
  std::uint64_t last_line_ = 0, last_alarm_ = 0;
  double now_ = 0;
};

}  // namespace polyarm::server
