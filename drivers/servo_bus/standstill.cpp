#include "drivers/servo_bus/standstill.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace polyarm::servo_bus {

namespace {
constexpr int kUnderWay = 30;  // steps between goal and joint: a smaller distance is play and load
using Ids = std::array<std::uint8_t, ServoBus::kMostServos>;

/// True if all report a register value of at most `most(k)` in either direction.
template <typename Most>
Outcome all_within(ServoBus& bus, std::span<const std::uint8_t> ids, const Register& reg,
                   Most most) noexcept {
  std::array<std::uint8_t, 4 * ServoBus::kMostServos> bytes{};
  std::array<Reply, ServoBus::kMostServos> replies{};
  const Outcome outcome =
      bus.sync_read(ids, reg.address, reg.size, bytes, std::span(replies).first(ids.size()));
  if (outcome != Outcome::ok) return outcome;
  for (std::size_t k = 0; k < ids.size(); ++k)
    if (!replies[k].here || std::abs(decode(reg, Bytes(bytes).subspan(k * reg.size, reg.size))) > most(k))
      return Outcome::lost;
  return Outcome::ok;
}

Outcome stop_turning(ServoBus& bus, std::span<const std::uint8_t> ids, std::span<const int> slow) noexcept {
  const Family& family = bus.family();
  constexpr std::array<std::int32_t, ServoBus::kMostServos> kZero{};
  const auto zero = std::span(kZero).first(ids.size());
  // A servo's own watchdog that has tripped write-protects the goal.
  Outcome outcome = family.watchdog ? bus.sync_write(ids, family.watchdog, zero) : Outcome::ok;
  if (outcome == Outcome::ok) outcome = bus.sync_write(ids, family.goal_velocity, zero);
  if (outcome == Outcome::ok)
    outcome = all_within(bus, ids, family.goal_velocity, [](std::size_t) { return 0; });
  if (outcome == Outcome::ok)
    outcome = all_within(bus, ids, family.present_velocity, [&](std::size_t k) { return slow[k]; });
  return outcome;
}
}  // namespace

const Register& goal_register(const Family& family, Mode mode) noexcept {
  return mode == Mode::position   ? family.goal_position
         : mode == Mode::velocity ? family.goal_velocity
                                  : family.goal_current;
}

Outcome stand(ServoBus& bus, std::uint8_t id, Mode mode, int min, int max) noexcept {
  const Family& family = bus.family();
  if (mode == Mode::position) {
    std::int32_t at = 0, goal = 0;
    Outcome outcome = bus.read(id, family.present_position, at);
    if (outcome == Outcome::ok) outcome = bus.read(id, family.goal_position, goal);
    if (outcome != Outcome::ok || std::abs(at - goal) <= kUnderWay) return outcome;
    return bus.write_checked(id, family.goal_position, std::clamp(at, min, max));
  }
  // A servo's own watchdog that has tripped write-protects the goal.
  const Outcome open = family.watchdog ? bus.write_checked(id, family.watchdog, 0) : Outcome::ok;
  if (open == Outcome::gone || open == Outcome::failed) return open;
  return bus.write_checked(id, goal_register(family, mode), 0);
}

Outcome all_at_rest(ServoBus& bus, std::span<const StandingJoint> joints) noexcept {
  Ids turning{};
  std::array<int, ServoBus::kMostServos> slow{};
  std::size_t count = 0;
  for (const StandingJoint& joint : joints)
    if (joint.mode == Mode::velocity) {
      turning[count] = joint.id;
      slow[count++] = joint.slow;
    }
  Outcome all = Outcome::ok;
  if (count > 0) all = stop_turning(bus, std::span(turning).first(count), std::span(slow).first(count));
  for (const StandingJoint& joint : joints) {
    if (all == Outcome::gone || all == Outcome::failed) return all;
    if (joint.mode == Mode::velocity) continue;
    const Outcome one = stand(bus, joint.id, joint.mode, -32767, 32767);
    if (one != Outcome::ok) all = one;
  }
  return all;
}

}  // namespace polyarm::servo_bus
