#pragma once
/// Keeps a log of the events of a cell for later requests.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "polyarm/protocol/programs.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::cell {

/// Forwards every event to the next observer and keeps the newest ones, except poses. Cell thread.
class EventLog : public Observer {
 public:
  static constexpr std::size_t kKept = 1000;

  /// `next` must outlive this object.
  explicit EventLog(Observer& next) : next_(next) {}

  const std::deque<protocol::Event>& events() const { return events_; }
  /// Number of the newest event; 0: none so far.
  std::uint64_t last() const { return last_; }

  void on_note(const std::string& text) override;
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override;
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override;
  void on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) override;
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override;
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override;
  void on_stop(Nanoseconds time, const StopReport& stop) override;
  void on_question(const std::string& text) override;
  void on_problem(Nanoseconds time, const Problem& problem) override;

 private:
  void keep(protocol::Event event);

  Observer& next_;
  std::deque<protocol::Event> events_;
  std::uint64_t last_ = 0;
};

}  // namespace polyarm::cell
