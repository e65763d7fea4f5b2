#pragma once
/// Interface of a recorder that writes a run to a file; the room `recording` implements it.
#include <cstdint>
#include <filesystem>
#include <string>

#include "polyarm/base/time.hpp"

namespace polyarm::cell {

struct RecordOptions {
  std::filesystem::path file;  ///< empty: a new file in .state/recordings of the cell
  double rate = 100;           ///< Hz, for continuously changing values; at most the control loop's rate
};

struct RecordStatus {
  bool recording = false;
  std::filesystem::path file;  ///< of this recording, or of the last one
  double seconds = 0, rate = 0;
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t lost = 0;  ///< messages and cycles dropped because the disk was slow
  std::string problem;     ///< why recording has stopped
};

/// Cell thread.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Throws Error("recording") if it is already recording, and Error("unwritable").
  virtual void start(const RecordOptions& options) = 0;
  /// Starts to close the file; it is complete when the status says that recording has ended.
  virtual void stop() = 0;
  virtual RecordStatus status() const = 0;
  /// Call at the end of each tick.
  virtual void tick(Nanoseconds now) = 0;
};

}  // namespace polyarm::cell
