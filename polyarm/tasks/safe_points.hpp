#pragma once
/// Safe points: states from which a program can continue after a power failure; written to the cell's .state
/// folder while it runs.
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

/// A consistent state: the program, its PLC, the data of its sets, and the tags.
struct SafePoint {
  std::string program;  ///< file of the program
  std::string line;     ///< "file:line" and its text, for people
  program::SavedState state;
  std::vector<std::pair<std::string, data::Value>> values;
  std::optional<program::SavedState> plc;  ///< empty: no PLC, or it cannot continue from its line
  bool plc_ended = false;
  std::vector<std::pair<std::string, data::Value>> tags;  ///< without those that hardware and cell set
  std::vector<std::string> held;  ///< what grippers held last; may be newer than the rest
};
std::string to_json(const SafePoint& point);
/// Throws Error("bad-state").
SafePoint safe_point_from_json(const std::string& text, const std::string& file);

/// Cell thread; the worker accesses the disk. In lock-step a safe point is written only at the end.
class SafePoints {
 public:
  SafePoints(std::filesystem::path file, Worker& worker, bool lock_step)
      : file_(std::move(file)), worker_(worker), lock_step_(lock_step) {}

  /// Call between statements and after each tick of the program: records the state at safe points if it or
  /// the data have changed. At most one write is in progress, and the newest state is written next. `plc`:
  /// null without one. `may_take`: false where a program that is continued would lack something.
  void tick(Nanoseconds now, const Task& task, const Task* plc, const data::DataStore& store, bool may_take);
  /// Call when a gripper has picked or released a part, at any line of the program.
  void set_held(std::vector<std::string> held);
  /// Writes the pending state. A program that has completed leaves no safe point.
  void finish(const Task& task);

  /// The safe point of an earlier run. Throws Error("no-state").
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
  bool pending_ = false;                   ///< not yet being written
  std::vector<std::string> held_;
  std::shared_ptr<std::atomic<bool>> busy_ = std::make_shared<std::atomic<bool>>(false);
  std::uint64_t seen_version_ = 0;
  program::Place seen_at_, plc_seen_at_;
  Nanoseconds taken_ = -1;
};

}  // namespace polyarm::cell
