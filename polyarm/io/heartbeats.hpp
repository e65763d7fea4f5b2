#pragma once
/// Heartbeat signals between the cell and external devices.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// Toggles the cell's own heartbeat tag and monitors those of others. Cell thread.
class Heartbeats {
 public:
  /// Declares the cell's own tag. Adds problems for names that are no tags or not boolean.
  Heartbeats(const signals::Signals& signals, data::DataStore& store, Problems& problems);

  /// Call once each tick. `cycles`: cycle count of the control loop; the own heartbeat stops when the loop
  /// stops.
  void tick(Nanoseconds now, std::uint64_t cycles, data::DataStore& store);
  /// The monitored heartbeat that has stopped; each is monitored only after its first change.
  const std::optional<Problem>& stopped() const { return stopped_; }

 private:
  struct Watched {
    signals::Heartbeat beat;
    std::optional<data::Value> last;
    Nanoseconds changed_at = -1;
  };
  std::optional<signals::Heartbeat> own_;
  std::vector<Watched> watched_;
  Nanoseconds toggled_at_ = 0;
  std::uint64_t cycles_ = 0;
  bool high_ = false;
  std::optional<Problem> stopped_;
};

}  // namespace polyarm::cell
