/// Requests that stop the motion of the cell and continue it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/inside/requests_work.hpp"
#include "polyarm/inside/ways.hpp"
#include "polyarm/operation/jogging.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/requests/component_states.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that requests about stopped motion need.
struct StopOwners {
  const CellSetup& setup;
  Machine& machine;
  Motions& motions;
  const Programs& programs;
  Jogging& jogging;
  Watches& watches;
  const ContactWatch& contacts;
  const Arming& arming;
  Observer& events;
};
using control::RunState;

/// Deactivates all active components, one after the other.
Poll<ControlStop::Answer> switch_off(const StopOwners& cell, std::size_t next, ControlStop::Answer answer) {
  hardware::Hardware& hardware = cell.machine.hardware();
  for (; next < hardware.size(); ++next) {
    if (hardware.state_of(next) != hardware::LifecycleState::active) continue;
    answer.inactive->push_back(hardware.component_name(next));
    return then(take_to(cell.machine, next, hardware::LifecycleState::inactive),
                [cell, next, answer](const Taken&) { return switch_off(cell, next + 1, answer); });
  }
  return at_once(std::move(answer));
}

/// Waits until all stopped motion has come to rest.
Poll<Done> wait_until_held(const StopOwners& cell) {
  return [cell, asked = cell.machine.snapshot().cycle.index] {
    const control::Snapshot& seen = cell.machine.snapshot();
    const bool over = seen.cycle.index > asked + 1 && seen.standing &&
                      (seen.state == RunState::held || seen.state == RunState::fault);
    return over ? Progress<Done>::done({}) : Progress<Done>{};
  };
}

/// Waits until the cell is held again; answers with the distance that each joint has moved.
Poll<ControlBack::Answer> wait_for_step_back(const StopOwners& cell) {
  using Back = Progress<ControlBack::Answer>;
  return [cell, asked = cell.machine.snapshot().cycle.index,
          from = cell.machine.joint_places().commanded(cell.machine.snapshot())] {
    const control::Snapshot& seen = cell.machine.snapshot();
    if (seen.cycle.index <= asked + 3 || seen.state == RunState::backing) return Back{};
    const std::vector<double> at = cell.machine.joint_places().commanded(seen);
    ControlBack::Answer answer;
    answer.state = control::name(seen.state);
    for (std::size_t j = 0; j < at.size() && j < from.size(); ++j)
      if (at[j] != from[j]) answer.joints[cell.machine.joint_places().all()[j].name] = at[j] - from[j];
    if (answer.joints.empty())
      throw Error("nothing-to-step-back", "nothing moved: no planned path is held, or it is at its start",
                  "polyarm control resume continues, polyarm control discard drops the rest");
    return Back::done(std::move(answer));
  };
}

double above_zero(const std::optional<double>& given, const char* name, double fallback) {
  const double value = given.value_or(fallback);
  if (value > 0) return value;
  throw Error("bad-argument", fmt::format("'{}' of control.back is {:g}, it must be above 0", name, value));
}

Asked control_hold(const StopOwners& cell, const ControlHold&) {
  cell.machine.supervisor().latch().request(realtime::StopKind::controlled);
  return {"hold"};
}

Poll<ControlStop::Answer> control_stop(const StopOwners& cell, const ControlStop& request) {
  const double category = request.category.value_or(2);
  if (category != 1 && category != 2)
    throw Error("bad-argument", fmt::format("there is no stop category {:g} here", category),
                "1: stop, then the drives are switched off; 2: stop and hold; 0 is the circuit of the "
                "emergency stop");
  cell.machine.supervisor().latch().request(realtime::StopKind::immediate);
  cell.watches.stop_watch().set_category(static_cast<int>(category));
  ControlStop::Answer answer;
  answer.category = static_cast<int>(category);
  if (category == 2) return at_once(std::move(answer));
  answer.inactive.emplace();
  return then(wait_until_held(cell), [cell, answer](Done) { return switch_off(cell, 0, answer); });
}

Asked control_resume(const StopOwners& cell, const ControlResume& request) {
  if (const auto why = why_no_resume(cell.machine, cell.motions, cell.contacts, cell.watches)) {
    const bool may_insist = why->code == "in-contact" || why->code == "moved-while-held";
    if (!may_insist || !request.anyway) throw Error(*why);
  }
  cell.jogging.end_all();
  cell.watches.forget_pushes();
  cell.machine.supervisor().latch().clear();
  cell.machine.post(control::Request::resume);
  return {"resume"};
}

/// Answers when the motion is discarded completely, so the client may then move the robot in another way.
Poll<ControlDiscard::Answer> control_discard(const StopOwners& cell, const ControlDiscard&) {
  using Discarded = Progress<ControlDiscard::Answer>;
  if (const auto why = why_no_discard(cell.machine)) throw Error(*why);
  const bool held = cell.motions.motion_left();
  cell.machine.post(control::Request::discard);
  cell.motions.drop();  // also what no controller follows yet, and what a trap has set apart
  cell.watches.forget_pushes();
  return [cell, held, asked = cell.machine.now()] {
    constexpr Nanoseconds kTimeout = 500'000'000;
    if (cell.motions.motion_left() && cell.machine.now() - asked < kTimeout) return Discarded{};
    cell.watches.forget_pushes();
    return Discarded::done(
        {"discard", held, "the robot can be jogged; polyarm control resume lets the cell continue"});
  };
}

Poll<Asked> control_recover(const StopOwners& cell, const ControlRecover&) {
  if (const auto why = why_no_recover(cell.machine)) throw Error(*why);
  cell.machine.post(control::Request::recover);
  return [cell, asked = cell.machine.now()] {  // so a resume that follows finds the cell held
    constexpr Nanoseconds kTimeout = 100'000'000;
    const bool waits =
        cell.machine.snapshot().state == RunState::fault && cell.machine.now() - asked < kTimeout;
    return waits ? Progress<Asked>{} : Progress<Asked>::done({"recover"});
  };
}

ContactState control_contacts(const StopOwners& cell, const Contacts&) {
  return contact_state(cell.setup, cell.machine, cell.contacts);
}

Poll<ControlBack::Answer> control_back(const StopOwners& cell, const ControlBack& request) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  control::Supervisor& supervisor = cell.machine.supervisor();
  const bool stated = request.time || request.distance;
  const double time = above_zero(request.time, "time", stated ? kAll : 1),
               distance = above_zero(request.distance, "distance", kAll);
  if (const auto why = why_no_back(cell.machine, cell.watches)) throw Error(*why);
  if (!(supervisor.override_share() > 0))
    throw Error("no-speed", "the override is 0 %", "polyarm control override 50%");
  supervisor.latch().clear();
  supervisor.set_back(time, distance);
  cell.machine.post(control::Request::back);
  return wait_for_step_back(cell);
}

ControlOverride::Answer control_override(const StopOwners& cell, const ControlOverride& request) {
  control::Supervisor& supervisor = cell.machine.supervisor();
  const double now = 100 * supervisor.override_share();
  const double percent = request.percent.value_or(now);
  if (!(percent >= 0 && percent <= 100))
    throw Error("bad-argument", fmt::format("an override of {:g} % is not possible", percent),
                "0 to 100 % of the planned speed");
  if (percent != now) {
    supervisor.set_override(percent / 100);
    cell.events.on_note(fmt::format("override {:g} %", percent));
  }
  return {"override", percent, supervisor.share()};
}

}  // namespace

std::vector<Handler> motion_handlers() {
  return handlers<control_hold, control_stop, control_resume, control_back, control_override, control_discard,
                  control_contacts, control_recover>();
}

}  // namespace polyarm::cell
