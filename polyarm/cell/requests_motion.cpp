/// Requests that stop the motion of the cell and let it go on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/cell/jogging.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/cell/ways.hpp"

namespace polyarm::cell {

namespace {

using control::RunState;

void request(Cell& cell, control::Request what) {
  if (!cell.loop().post(what)) throw Error("busy", "the control loop has not taken the last requests yet");
}

/// Switches the components off that are active, one after the other.
Poll switch_off(Cell& cell, std::size_t next, Json answer) {
  hardware::Hardware& hardware = cell.loop().hardware();
  for (; next < hardware.size(); ++next) {
    if (hardware.state_of(next) != hardware::LifecycleState::active) continue;
    answer["inactive"].push_back(hardware.component_name(next));
    return then(take_to(cell, next, hardware::LifecycleState::inactive),
                [next, answer](Cell& c) { return switch_off(c, next + 1, answer); });
  }
  return at_once(std::move(answer));
}

/// Until all stand that was to stop.
Poll wait_until_held(Cell& cell) {
  return [asked = cell.snapshot().cycle.index](Cell& c) {
    const control::Snapshot& seen = c.snapshot();
    const bool over = seen.cycle.index > asked + 1 && seen.standing &&
                      (seen.state == RunState::held || seen.state == RunState::fault);
    return over ? Progress::done(nullptr) : Progress{};
  };
}

/// Until it is held again; says how far every joint has gone.
Poll wait_for_step_back(Cell& cell) {
  return
      [asked = cell.snapshot().cycle.index, from = cell.joint_places().commanded(cell.snapshot())](Cell& c) {
        const control::Snapshot& seen = c.snapshot();
        if (seen.cycle.index <= asked + 3 || seen.state == RunState::backing) return Progress{};
        const std::vector<double> at = c.joint_places().commanded(seen);
        Json joints = Json::object();
        for (std::size_t j = 0; j < at.size() && j < from.size(); ++j)
          if (at[j] != from[j]) joints[c.joint_places().all()[j].name] = at[j] - from[j];
        if (joints.empty())
          throw Error("nothing-to-step-back", "nothing moved: no planned path is held, or it is at its start",
                      "polyarm control resume goes on, polyarm control discard forgets the rest");
        return Progress::done({{"asked", "back"}, {"state", control::name(seen.state)}, {"joints", joints}});
      };
}

double above_zero(const Json& arguments, const char* name, double fallback) {
  const double value = number_argument(arguments, name, fallback);
  if (value > 0) return value;
  throw Error("bad-argument", fmt::format("'{}' of control.back is {:g}, it must be above 0", name, value));
}

Poll control_hold(Cell& cell, const Json&) {
  cell.loop().supervisor().latch().request(realtime::StopKind::controlled);
  return at_once({{"asked", "hold"}});
}

Poll control_stop(Cell& cell, const Json& arguments) {
  const double category = number_argument(arguments, "category", 2);
  if (category != 1 && category != 2)
    throw Error(
        "bad-argument", fmt::format("there is no stop category {:g} here", category),
        "1: stop, then the drives are switched off; 2: stop and hold; 0 is the emergency stop's wire");
  cell.loop().supervisor().latch().request(realtime::StopKind::immediate);
  cell.stop_watch().set_category(static_cast<int>(category));
  Json answer{{"asked", "stop"}, {"category", static_cast<int>(category)}};
  if (category == 2) return at_once(std::move(answer));
  answer["inactive"] = Json::array();
  return then(wait_until_held(cell), [answer](Cell& c) { return switch_off(c, 0, answer); });
}

Poll control_resume(Cell& cell, const Json& arguments) {
  if (const auto why = why_no_resume(cell)) {
    const bool may_insist = why->code == "in-contact" || why->code == "moved-while-held";
    if (!may_insist || !flag_argument(arguments, "anyway")) throw Error(*why);
  }
  cell.jogging().end_all();
  cell.forget_pushes();
  cell.loop().supervisor().latch().clear();
  request(cell, control::Request::resume);
  return at_once({{"asked", "resume"}});
}

/// Answered when nothing of the motion is left, so that whoever asked may move the robot otherwise.
Poll control_discard(Cell& cell, const Json&) {
  if (const auto why = why_no_discard(cell)) throw Error(*why);
  const bool held = cell.motion_left();
  request(cell, control::Request::discard);
  cell.drop_bases();
  cell.forget_pushes();
  return [held, asked = cell.now()](Cell& c) {
    constexpr Nanoseconds kPatience = 500'000'000;
    if (c.motion_left() && c.now() - asked < kPatience) return Progress{};
    c.forget_pushes();
    return Progress::done({{"asked", "discard"},
                           {"discarded", held},
                           {"next", "the robot may be jogged; polyarm control resume lets the cell go on"}});
  };
}

Poll control_recover(Cell& cell, const Json&) {
  if (const auto why = why_no_recover(cell)) throw Error(*why);
  request(cell, control::Request::recover);
  return [asked = cell.now()](Cell& c) {  // so that a resume that follows finds it held
    constexpr Nanoseconds kPatience = 100'000'000;
    const bool waits = c.snapshot().state == RunState::fault && c.now() - asked < kPatience;
    return waits ? Progress{} : Progress::done({{"asked", "recover"}});
  };
}

Poll control_contacts(Cell& cell, const Json&) {
  return at_once(contacts_json(cell));
}

Poll control_back(Cell& cell, const Json& arguments) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  control::Supervisor& supervisor = cell.loop().supervisor();
  const bool stated = arguments.contains("time") || arguments.contains("distance");
  const double time = above_zero(arguments, "time", stated ? kAll : 1),
               distance = above_zero(arguments, "distance", kAll);
  if (const auto why = why_no_back(cell)) throw Error(*why);
  if (!(supervisor.override_share() > 0))
    throw Error("no-speed", "the override is 0 %", "polyarm control override 50%");
  supervisor.latch().clear();
  supervisor.set_back(time, distance);
  request(cell, control::Request::back);
  return wait_for_step_back(cell);
}

Poll control_override(Cell& cell, const Json& arguments) {
  control::Supervisor& supervisor = cell.loop().supervisor();
  const double now = 100 * supervisor.override_share();
  const double percent = number_argument(arguments, "percent", now);
  if (!(percent >= 0 && percent <= 100))
    throw Error("bad-argument", fmt::format("an override of {:g} % cannot be", percent),
                "0 to 100 % of the planned speed");
  if (percent != now) {
    supervisor.set_override(percent / 100);
    cell.tell(fmt::format("override {:g} %", percent));
  }
  return at_once({{"asked", "override"}, {"percent", percent}, {"allowed", supervisor.share()}});
}

}  // namespace

const std::vector<RequestRow>& motion_rows() {
  static const std::vector<RequestRow> table = {
      {{"control.hold", {}, "{asked}", "stop on the path", true}, control_hold, true},
      {{"control.stop",
        {{"category", kNumber}},
        "{asked, category, inactive}",
        "stop at once, on the path as hard as the joints can; category 1 then switches the drives off, 2 "
        "(otherwise) holds",
        true},
       control_stop,
       true},
      {{"control.resume",
        {{"anyway", kFlag}},
        "{asked}",
        "go on along the path after a hold; refused where the robot was moved meanwhile or still touches "
        "something that the motion goes on into, unless `anyway`",
        true},
       control_resume},
      {{"control.back",
        {{"time", kNumber}, {"distance", kNumber}},
        "{asked, state, joints}",
        "from a hold, slowly back along the planned path: by `time` s of the plan (1) or `distance` along "
        "the "
        "path, then held again",
        true},
       control_back},
      {{"control.override",
        {{"percent", kNumber}},
        "{asked, percent, allowed}",
        "how much of the planned speed is used, 0 to 100; without `percent` it is only told",
        true},
       control_override},
      {{"control.discard",
        {},
        "{asked, discarded, next}",
        "forget what is left of a motion that is held, and where it was to go on from",
        true},
       control_discard},
      {{"contacts",
        {},
        "{checked, stop, touching, unchecked, unchecked_why, list: [{a, b, robot, at_s, depth, position, "
        "now, doing, where, text}]}",
        "what touched what in physics and where, what touches now, and what contacts are not detected for",
        false},
       control_contacts},
      {{"control.recover", {}, "{asked}", "leave the fault state for held; nothing moves", true},
       control_recover},
  };
  return table;
}

}  // namespace polyarm::cell
