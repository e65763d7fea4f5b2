#pragma once
/// Where a program can go on after a loss of power: written to the cell's .state folder while it runs.
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/data/data_store.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/tasks/task.hpp"
#include "polyarm/vm/saved_state.hpp"

namespace polyarm::cell {

/// A program's state, its PLC's, the data of its sets and the tags at the same moment.
struct SafePoint {
  std::string program;  ///< file of the program
  std::string line;     ///< "file:line" and its text, for people
  program::SavedState state;
  std::vector<std::pair<std::string, data::Value>> values;
  std::optional<program::SavedState> plc;  ///< nothing: there is none, or it stood where it cannot go on
  bool plc_ended = false;
  std::vector<std::pair<std::string, data::Value>> tags;  ///< but those that hardware and cell tell
  std::vector<std::string> held;  ///< what grippers held at last, which may be later than the rest
};
std::string to_json(const SafePoint& point);
/// Throws Error("bad-state").
SafePoint safe_point_from_json(const std::string& text, const std::string& file);

/// Cell thread; the disk is touched by the worker. In lock-step it is written at the end alone.
class SafePoints {
 public:
  SafePoints(std::filesystem::path file, Worker& worker, bool lock_step)
      : file_(std::move(file)), worker_(worker), lock_step_(lock_step) {}

  /// Between statements and after each tick of the program: takes the state down at safe points, when it or
  /// the data have changed; one write is under way at most, and the newest is written next.
  /// `plc`: null where the cell has none.
  void tick(Nanoseconds now, const Task& task, const Task* plc, const data::DataStore& store);
  /// A gripper has taken or let go something; where the program is then makes no difference.
  void set_held(std::vector<std::string> held);
  /// What is not written yet. A program that has come to its own end leaves nothing.
  void finish(const Task& task);

  /// The one that an earlier run has left. Throws Error("no-state").
  static SafePoint read(const std::filesystem::path& file);
  const std::filesystem::path& file() const { return file_; }

 private:
  void post();
  void post_when_free() {
    if (pending_ && !lock_step_ && !busy_->load()) post();
  }

  std::filesystem::path file_;
  Worker& worker_;
  bool lock_step_;
  std::shared_ptr<const SafePoint> last_;  ///< the newest
  bool pending_ = false;                   ///< it is not on its way to the disk yet
  std::vector<std::string> held_;
  std::shared_ptr<std::atomic<bool>> busy_ = std::make_shared<std::atomic<bool>>(false);
  std::uint64_t seen_version_ = 0;
  program::Place seen_at_, plc_seen_at_;
  Nanoseconds taken_ = -1;
};

}  // namespace polyarm::cell
