/// The component and its watchdog process.
#include <cmath>

#include "drivers/servo_bus/component.hpp"
#include "drivers/servo_bus/standstill.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::servo_bus {

watchdog::Names ServoComponent::watchdog_names() const {
  return {kServoWatchdog,       "the servos on " + setup_.port,         setup_.port,
          "joints are stopped", "stopped the joints on " + setup_.port, setup_.watchdog_ms};
}

bool ServoComponent::fine(watchdog::Health health) noexcept {
  if (health == watchdog::Health::fine) return true;
  const auto all = static_cast<std::uint32_t>((std::uint64_t{1} << ids_.size()) - 1);
  fault(FaultKind::watchdog, all, static_cast<unsigned>(health));
  return false;
}

/// Keeps a running one; else starts one that gets the port as this process has opened it.
bool ServoComponent::start_watchdog(Problems& problems) {
  if (!setup_.watched) return true;
  if (watchdog_.running() && watchdog_.listen() == watchdog::Health::fine) return true;
  // With `auto`, joints in position mode are not stopped: they go to their last goal and stay there.
  WatchdogSettings settings{family_.name, setup_.port, setup_.baud,
                            static_cast<int>(setup_.answer_timeout / 1'000'000), setup_.watchdog_ms};
  for (std::size_t j = 0; j < ids_.size(); ++j)
    if (setup_.all_watched || setup_.joints[j].mode == Mode::velocity)
      settings.joints.push_back({ids_[j], setup_.joints[j].mode,
                                 static_cast<int>(std::floor(kStandstill / servos_[j].velocity_unit))});
  watchdog_.expect(setup_.watchdog_ms, setup_.period);
  const watchdog::Health health = watchdog_.start(program_, words_of(settings), bus_.descriptors());
  if (health == watchdog::Health::fine) return true;
  problems.error("no-watchdog", {}, watchdog::sentence(health, watchdog_names()),
                 "without it a joint in velocity would turn on when this process dies; `watchdog: off` "
                 "accepts that");
  return false;
}

/// True if this process hung for so long that servos with their own watchdog have stopped, and refuse goals.
bool ServoComponent::servos_have_waited() noexcept {
  if (!family_.watchdog || setup_.bus_watchdog_ms == 0 || last_written_ == 0) return false;
  if (realtime::monotonic_now() - last_written_ <= Nanoseconds{setup_.bus_watchdog_ms} * 1'000'000)
    return false;
  std::uint32_t stopped = 0;
  for (std::size_t j = 0; j < ids_.size(); ++j)
    if (setup_.joints[j].mode != Mode::position) stopped |= 1u << j;
  if (stopped == 0) return false;
  fault(FaultKind::stood_still, stopped, 0);
  return true;
}

/// Joints that this process could not stop are left to the watchdog, which then continues alone.
void ServoComponent::leave_watchdog() noexcept {
  if (held_)
    watchdog_.stop();
  else
    watchdog_.abandon();
}

}  // namespace polyarm::servo_bus
