#pragma once
/// What is kept of a run that went wrong, in one folder: enough to look at it and to play it again.
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/io/worker.hpp"

namespace polyarm::cell {

struct CellSetup;

/// Everything a record needs, taken from the running cell by the cell thread; writing it may then be left to
/// any thread.
struct FaultRecord {
  std::filesystem::path cell_folder;
  Problem problem;
  std::string stop;  ///< what the stop took, in one line; empty: it has not ended
  double period_s = 1e-3;
  std::vector<std::string> states, commands;                ///< names of the columns
  std::map<std::string, std::string> files;                 ///< name → text, written beside the cycles
  std::shared_ptr<control::ControlLoop::TakeBlackBox> box;  ///< of a loop that goes on; null: `stopped`
  const control::BlackBox* stopped = nullptr;               ///< of a loop that nobody steps any more
};

/// `stop`: what the stop took, in one line; empty: it has not ended.
FaultRecord begin_record(const CellSetup& setup, control::ControlLoop& loop, Problem problem,
                         const std::string& stop);

/// Writes into the next free `<cell>/.state/KIND/NNNN/`: the cell's files, each robot's URDF, `cycles.csv`
/// with cycle, state, cause, request, all states and all commands, and `fault.txt`, which begins with what
/// happened and what the stop took. Returns the folder; empty
/// where it could not be written, since the run's result stands without it.
std::filesystem::path write_record(const FaultRecord& record, const char* kind) noexcept;

/// Keeps the black box of a running cell after a fault, with a little of what came after. Cell thread.
class FaultRecorder {
 public:
  void begin(FaultRecord record, Nanoseconds now);
  /// What the stop took, for a record that is not written yet.
  void note_stop(const std::string& sentence) {
    if (record_) record_->stop = sentence;
  }
  /// Takes the box out of the loop when it is time, and lets the worker write it. A sentence when that is
  /// done.
  std::optional<std::string> tick(Nanoseconds now, control::ControlLoop& loop, Worker& worker);

 private:
  std::unique_ptr<FaultRecord> record_;
  Nanoseconds due_ = 0;
  std::future<std::filesystem::path> written_;
};

/// A record that was read back.
struct RecordedCycles {
  struct Row {
    std::uint64_t cycle = 0;
    std::string state, cause, request;
    std::vector<double> states, commands;
  };
  std::vector<std::string> states, commands;
  std::vector<Row> rows;
};
/// Throws Error with the line of what is no record.
RecordedCycles read_cycles(const std::filesystem::path& csv);

/// How far what a simulated driver measures is from what was recorded when it is given the commands that were
/// recorded.
struct ReplayedJoint {
  std::string name;
  double worst = 0;         ///< rad or m
  std::uint64_t cycle = 0;  ///< where that was
};
struct Replay {
  RecordedCycles recorded;
  std::string problem;  ///< as it was told
  std::vector<ReplayedJoint> joints;
  std::string driver;
};
/// Plays a record again: the recorded commands, from the recorded start, on the robots of the record.
/// `hardware`: mock or mujoco. Throws Error for a folder that holds no record.
Replay replay_record(const std::filesystem::path& folder, const std::string& hardware);

}  // namespace polyarm::cell
