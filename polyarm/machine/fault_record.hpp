#pragma once
/// Fault records: a folder with the last cycles and files of a run that failed, to inspect and replay it.
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

/// The contents of a record, collected from the running cell on the cell thread. Any thread may write it to
/// disk.
struct FaultRecord {
  std::filesystem::path cell_folder;
  Problem problem;
  std::string stop;  ///< duration and distance of the stop in one line; empty: it has not ended
  double period_s = 1e-3;
  std::vector<std::string> states, commands;                ///< column names
  std::map<std::string, std::string> files;                 ///< name → text, written beside the cycles
  std::shared_ptr<control::ControlLoop::TakeBlackBox> box;  ///< of a continuing loop; null: use `stopped`
  const control::BlackBox* stopped = nullptr;               ///< from a loop that is no longer stepped
};

/// `stop`: duration and distance of the stop in one line; empty: it has not ended.
FaultRecord begin_record(const CellSetup& setup, control::ControlLoop& loop, Problem problem,
                         const std::string& stop);

/// Writes a record into the next free folder `<cell>/.state/KIND/NNNN/`: the cell's files, each robot's URDF,
/// `cycles.csv` with cycle, state, cause, request, all states and all commands, and `fault.txt`, which begins
/// with the problem and the stop. Returns the folder; empty if it could not be written, because the run's
/// result does not depend on it.
std::filesystem::path write_record(const FaultRecord& record, const char* kind) noexcept;

/// Saves the black box of a running cell a short time after a fault. Cell thread.
class FaultRecorder {
 public:
  void begin(FaultRecord record, Nanoseconds now);
  /// Adds the stop to a record that is not written yet.
  void note_stop(const std::string& sentence) {
    if (record_) record_->stop = sentence;
  }
  /// Takes the black box from the loop when it is due and lets the worker write it. Returns a sentence when
  /// the record was written.
  std::optional<std::string> tick(Nanoseconds now, control::ControlLoop& loop, Worker& worker);

 private:
  std::unique_ptr<FaultRecord> record_;
  Nanoseconds due_ = 0;
  std::future<std::filesystem::path> written_;
};

/// A record read from disk.
struct RecordedCycles {
  struct Row {
    std::uint64_t cycle = 0;
    std::string state, cause, request;
    std::vector<double> states, commands;
  };
  std::vector<std::string> states, commands;
  std::vector<Row> rows;
};
/// Throws Error with the line that is malformed.
RecordedCycles read_cycles(const std::filesystem::path& csv);

/// Deviation of a simulated driver from the recording when it executes the recorded commands.
struct ReplayedJoint {
  std::string name;
  double worst = 0;         ///< largest deviation, rad or m
  std::uint64_t cycle = 0;  ///< cycle of the largest deviation
};
struct Replay {
  RecordedCycles recorded;
  std::string problem;  ///< as it was reported
  std::vector<ReplayedJoint> joints;
  std::string driver;
};
/// Replays a record: the recorded commands, from the recorded start, on the robots of the record. `hardware`:
/// mock or mujoco. Throws Error if the folder contains no record.
Replay replay_record(const std::filesystem::path& folder, const std::string& hardware);

}  // namespace polyarm::cell
