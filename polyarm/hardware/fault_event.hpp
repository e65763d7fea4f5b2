#pragma once
/// The record of a fault in a cycle. Hardware, limits and controllers push fault events; only the supervisor
/// (control/supervisor.hpp) decides on the reaction.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

namespace polyarm::hardware {

/// Why the loop is not running. Recorded faults store these numbers, so add new causes at the end.
enum class StopCause : std::uint8_t {
  none,
  asked,          ///< a person or a program asked for a stop
  gap,            ///< wall time was missing
  cell_silent,    ///< the cell thread sent no heartbeat
  component,      ///< a component's read or write failed
  controller,     ///< a controller's update failed
  program,        ///< the program ended
  late,           ///< cycles, or a component's thread, were late too often in a row
  not_a_number,   ///< a joint's measured position became NaN or infinite
  jump,           ///< a joint's measured position changed by more than the joint can have moved
  not_following,  ///< a joint is too far from its command for too long
  limits,         ///< a joint is far outside its limits
  contact,        ///< a contact in a simulated world
  deactivated,    ///< a component asked to be deactivated; outside the loop this is `component`
};
inline constexpr int kStopCauses = 14;

/// The cause that the loop reports to the outside.
constexpr StopCause reported(StopCause cause) noexcept {
  return cause == StopCause::deactivated ? StopCause::component : cause;
}

/// Reaction to cycles of the loop, or runs of a component's thread, that are late too often in a row.
/// Lateness is reported in any case.
enum class WhenLate : std::uint8_t {
  report,  ///< nothing more
  hold,    ///< the loop stops on the path and holds
  fault,   ///< a fault, as if the component had failed
};

/// A fault, as numbers; texts are made outside the loop. -1: does not apply.
struct FaultEvent {
  StopCause cause = StopCause::none;
  std::int32_t component = -1;   ///< index of the component; -1: the loop as a whole
  std::int32_t interface = -1;   ///< index of the state (for `limits`: of the command) that shows it
  std::int32_t controller = -1;  ///< id of the controller
  double value = std::numeric_limits<double>::quiet_NaN();  ///< measured value, rad or m
  explicit operator bool() const noexcept { return cause != StopCause::none; }
};
static_assert(std::is_trivially_copyable_v<FaultEvent>);

/// The fault events of a cycle that were not handled yet, oldest first. Control thread.
class FaultEvents {
 public:
  FaultEvents() { make_room(256); }
  /// Call before the loop runs.
  void make_room(std::size_t events) { list_.reserve(events); }
  /// Drops the event if there is no room.
  void push(const FaultEvent& event) noexcept {
    if (list_.size() < list_.capacity()) list_.push_back(event);
  }
  std::span<const FaultEvent> list() const noexcept { return list_; }
  bool empty() const noexcept { return list_.empty(); }
  void clear() noexcept { list_.clear(); }

 private:
  std::vector<FaultEvent> list_;
};

}  // namespace polyarm::hardware
