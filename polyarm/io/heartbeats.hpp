#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// The sign of life that the cell gives, and those that it watches. Cell thread.
class Heartbeats {
 public:
  /// Declares its own tag. Problems: names that are no tags or no booleans.
  Heartbeats(const signals::Signals& signals, data::DataStore& store, Problems& problems);

  /// Once each tick. `cycles`: of the control loop; where it makes no more, the own heartbeat stops.
  void tick(Nanoseconds now, std::uint64_t cycles, data::DataStore& store);
  /// Which watched one has stopped; watched only from its first change on.
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
