#pragma once
/// The place of what writes a cell's doings into a file, as the cell sees it; `recording/` fills it.
#include <cstdint>
#include <filesystem>
#include <string>

#include "polyarm/base/time.hpp"

namespace polyarm::cell {

struct RecordOptions {
  std::filesystem::path file;  ///< empty: a new one in .state/recordings of the cell
  double rate = 100;           ///< Hz of what changes all the time; at most the control loop's
};

struct RecordStatus {
  bool recording = false;
  std::filesystem::path file;  ///< of this recording, or the last one
  double seconds = 0, rate = 0;
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t lost = 0;  ///< messages and cycles that found no room while the disk was slow
  std::string problem;     ///< why nothing is written any more
};

/// Cell thread.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Throws Error("recording") while it records, and Error("unwritable").
  virtual void start(const RecordOptions& options) = 0;
  /// Begins to close the file; it is whole when the status says that nothing is recorded any more.
  virtual void stop() = 0;
  virtual RecordStatus status() const = 0;
  /// At the end of each tick.
  virtual void tick(Nanoseconds now) = 0;
};

}  // namespace polyarm::cell
