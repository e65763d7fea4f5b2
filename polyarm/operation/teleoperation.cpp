#include "polyarm/operation/teleoperation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/operation/jogging.hpp"
#include "polyarm/teleop/teleop_map.hpp"

namespace polyarm::cell {

using teleop::Clutch;
using teleop::TeleopPhase;
using teleop::TeleopSeen;

namespace {
/// A target is valid for kHold and is sent again after kAgain even if the leader rests, ns.
constexpr Nanoseconds kHold = 100'000'000, kAgain = 20'000'000;
/// A leader whose thread has not finished a run for this long is late, ns.
constexpr Nanoseconds kLate = 100'000'000;
/// A follower this near to the leader's pose matches it, rad or m.
constexpr double kMatches = 0.035;
/// The hand of the leader as a clutch, and as a switch of the gripper: closed below the first, open above the
/// second; 0 to 1.
constexpr double kClutchOn = 0.25, kClutchOff = 0.4, kGripOn = 0.4, kGripOff = 0.6;

bool is_true(const data::Value* value) {
  if (!value) return false;
  if (const bool* flag = value->as_boolean()) return *flag;
  const data::Number* const number = value->as_number();
  return number && std::isfinite(number->value) && number->value != 0;
}

std::size_t joint_of(const CellRobot& robot, const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints) {
    names.push_back(joint.name.substr(joint.name.find('/') + 1));
    if (names.back() == name || joint.name == name) return names.size() - 1;
  }
  throw Error(Problem{"unknown-joint", where,
                      "'" + robot.entry.name + "' has no joint '" + name + "'" + did_you_mean(name, names),
                      "it has: " + join(names, ", ")});
}
}  // namespace

struct Teleoperation::Pair {
  explicit Pair(const teleop::PairSettings& from) : settings(from) {}
  const teleop::PairSettings& settings;
  std::size_t leader = 0, follower = 0;  // robots
  std::optional<teleop::TeleopMap> map;
  std::vector<std::size_t> states;  // of the leader's joints
  std::size_t clutch_joint = 0, grip_joint = 0;
  int component = -1;

  // the leader, as seen in this tick
  std::vector<double> q, seen;
  teleop::LeaderWatch watch;
  bool changed = false, good = false;
  std::uint64_t runs = 0;
  Nanoseconds ran = 0;

  TeleopPhase phase = TeleopPhase::blocked;
  std::string reason = "release the clutch and hold it again";
  Nanoseconds key_until = -1, sent = 0;
  bool hand_closed = false, gripped = false;
  std::uint32_t session = 0;
};

Teleoperation::Teleoperation(const Owners& cell) : cell_(cell) {
  for (const teleop::PairSettings& settings : cell.setup.file.teleop)
    pairs_.push_back(std::make_unique<Pair>(settings));
}
Teleoperation::~Teleoperation() = default;

const teleop::PairSettings& Teleoperation::settings(std::size_t pair) const {
  return pairs_[pair]->settings;
}

void Teleoperation::build(Problems& problems) {
  const CellRobots& robots = cell_.setup.robots;
  const auto index_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find_if(robots.begin(), robots.end(),
                                                 [&](const auto& each) { return each->entry.name == name; }) -
                                    robots.begin());
  };
  const auto require_tag = [&](const std::string& tag, const Location& where) {
    if (!cell_.data.store.find(tag))
      throw Error(Problem{
          "unknown-name", where,
          "the cell has no tag or variable '" + tag + "'" + did_you_mean(tag, cell_.data.store.names()),
          "declare it in the signals file"});
  };
  for (const auto& each : pairs_)
    collect(problems, [&] {
      Pair& pair = *each;
      const teleop::PairSettings& settings = pair.settings;
      pair.leader = index_of(settings.leader);
      pair.follower = index_of(settings.follower);
      const CellRobot& leader = *robots[pair.leader];
      pair.map.emplace(settings, leader.facts->chain, robots[pair.follower]->facts->chain);
      for (const controllers::JointFacts& joint : leader.joints) {
        const auto state = cell_.machine.table().find_state(joint.name + "/position");
        if (!state)
          throw Error(Problem{"unknown-interface", settings.where,
                              "'" + joint.name + "' of the leader has no measured position",
                              "`polyarm interfaces` lists what its hardware offers"});
        pair.states.push_back(*state);
      }
      if (!pair.states.empty())
        pair.component = cell_.machine.hardware().component_of_state(pair.states.front());
      if (settings.clutch == Clutch::tag) require_tag(settings.tag, settings.where);
      if (settings.clutch == Clutch::gripper)
        pair.clutch_joint = joint_of(leader, settings.hand.joint, settings.where);
      if (settings.grip) {
        pair.grip_joint = joint_of(leader, settings.grip->hand.joint, settings.where);
        require_tag(settings.grip->tag, settings.where);
      }
      pair.q.assign(pair.states.size(), 0);
      pair.seen = pair.q;
    });
}

std::size_t Teleoperation::find(const std::optional<std::string>& name) const {
  std::vector<std::string> names;
  for (const auto& pair : pairs_) names.push_back(pair->settings.name);
  if (!name && names.size() == 1) return 0;
  if (!name)
    throw Error("which-pair", names.empty() ? "no robot of the cell leads another" : "which pair?",
                names.empty() ? "write a 'teleop' block into the cell" : "name one: " + join(names, ", "));
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found == names.end())
    throw Error("unknown-pair",
                "the cell has no pair '" + shortened(*name) + "'" + did_you_mean(*name, names),
                names.empty() ? "write a 'teleop' block into the cell" : "it has: " + join(names, ", "));
  return static_cast<std::size_t>(found - names.begin());
}

void Teleoperation::hold_key(std::size_t i, Nanoseconds hold) {
  Pair& pair = *pairs_[i];
  if (pair.settings.clutch != Clutch::key)
    throw Error(
        "other-clutch",
        "the clutch of '" + pair.settings.name + "' is " +
            (pair.settings.clutch == Clutch::tag ? "the tag " + pair.settings.tag : "the leader's hand"),
        "use that, or write 'clutch: key' into the cell");
  pair.key_until = hold > 0 ? cell_.machine.now() + hold : -1;
}

Teleoperation::State Teleoperation::state(std::size_t pair) const {
  return state_of(*pairs_[pair]);
}

Teleoperation::State Teleoperation::state_of(const Pair& pair) const {
  State out{pair.phase, pair.phase == TeleopPhase::blocked ? pair.reason : "", "", 0};
  if (pair.phase != TeleopPhase::approaching) return out;
  const jog::JogStatus status = cell_.jogging.status(pair.follower);
  const CellRobot& follower = *cell_.setup.robots[pair.follower];
  const auto far = pair.map->furthest(pair.q, std::span(status.joints).first(follower.joints.size()));
  out.furthest = follower.facts->chain.names()[far.joint];
  out.distance = far.much;
  return out;
}

/// Reads the leader's joints, and judges them. Sets the reason if they may not be followed.
void Teleoperation::see_leader(Pair& pair) const {
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const hardware::Hardware& hardware = cell_.machine.hardware();
  const Nanoseconds now = cell_.machine.now();
  bool there = true, late = false;
  if (pair.component >= 0) {
    const auto component = static_cast<std::size_t>(pair.component);
    there = hardware.state_of(component) == hardware::LifecycleState::active;
    if (const realtime::ThreadHealth* const thread = hardware.diagnostics().thread_health(component)) {
      const std::uint64_t runs = thread->runs;
      if (std::exchange(pair.runs, runs) != runs) pair.ran = now;
      late = now - pair.ran > kLate;
    }
  }
  pair.changed = false;
  pair.watch.begin();
  for (std::size_t j = 0; j < pair.states.size(); ++j) {
    const double q = snapshot.states[pair.states[j]];
    pair.watch.see(pair.seen[j], q);
    pair.changed = pair.changed || q != pair.seen[j];
    pair.seen[j] = q;
  }
  const bool plausible = pair.watch.end();
  pair.good = there && !late && plausible;
  if (plausible) pair.q = pair.seen;
  const std::string who = "the leader '" + pair.settings.leader + "' ";
  if (!there)
    pair.reason = who + "is not active";
  else if (late)
    pair.reason = who + "has sent nothing for 0.1 s";
  else if (!pair.watch.finite())
    pair.reason = who + "measures NaN";
  else if (pair.watch.jumped())
    pair.reason = who + "jumped";
}

/// A clutch that is not seen counts as held, and nothing moves: it must be seen released before it can be
/// held.
bool Teleoperation::clutch_held(Pair& pair, TeleopSeen& seen) const {
  const teleop::PairSettings& settings = pair.settings;
  switch (settings.clutch) {
    case Clutch::key:
      return cell_.machine.now() <= pair.key_until;
    case Clutch::tag:
      if (const auto source = cell_.data.links().source_of(settings.tag);
          source && source->direction != "out" && source->quality != "good") {
        pair.reason = "the link '" + source->link + "' has no news of the clutch " + settings.tag;
        seen.allowed = false;
        return true;
      }
      return is_true(cell_.data.store.find(settings.tag));
    case Clutch::gripper:
      pair.hand_closed = !pair.good || teleop::closed_with_play(
                                           pair.hand_closed, settings.hand.opening(pair.q[pair.clutch_joint]),
                                           kClutchOn, kClutchOff);
      return pair.hand_closed;
  }
  return false;
}

/// Takes the follower over, and the poses from which both move.
void Teleoperation::take_over(Pair& pair, TeleopSeen& seen) const {
  Jogging& jogging = cell_.jogging;
  try {
    if (!jogging.engage(pair.follower)) return;
    pair.session = jogging.session(pair.follower, 0);
    const jog::JogStatus status = jogging.status(pair.follower);
    const std::size_t joints = cell_.setup.robots[pair.follower]->joints.size();
    pair.map->engage(pair.q, std::span(status.joints).first(joints));
    seen.taken = true;
  } catch (const Error& e) {
    seen.allowed = false;
    pair.reason = e.problems().front().what;
  }
}

void Teleoperation::judge_follower(Pair& pair, TeleopSeen& seen) const {
  if (pair.session == 0) return;
  const jog::JogStatus status = cell_.jogging.status(pair.follower);
  if (status.ended >= pair.session || !cell_.jogging.engaged(pair.follower)) {
    seen.allowed = false;
    pair.reason = "'" + pair.settings.follower + "' was stopped";
    return;
  }
  const bool approaches = pair.settings.mapping == teleop::Mapping::joints && !pair.settings.relative;
  const std::size_t joints = cell_.setup.robots[pair.follower]->joints.size();
  seen.matches =
      !approaches || pair.map->furthest(pair.q, std::span(status.joints).first(joints)).much < kMatches;
}

void Teleoperation::change(Pair& pair, TeleopPhase to) const {
  const TeleopPhase from = std::exchange(pair.phase, to);
  if (teleop::moves(from) && !teleop::moves(to)) cell_.jogging.end(pair.follower, pair.session);
  if (!teleop::moves(to)) pair.session = 0;
  const std::string name = "teleop " + pair.settings.name + ": ";
  const std::string& follower = pair.settings.follower;
  if (to == TeleopPhase::approaching)
    cell_.observer.on_note(name + "'" + follower + "' approaches the pose of '" + pair.settings.leader +
                           "' slowly; " + state_of(pair).furthest + " is furthest from it");
  if (to == TeleopPhase::following)
    cell_.observer.on_note(name + "'" + follower + "' follows '" + pair.settings.leader + "'");
  if (to == TeleopPhase::blocked)
    cell_.observer.on_note(name + "'" + follower + "' stops: " + pair.reason +
                           ". Release the clutch and hold it again");
  if (to == TeleopPhase::waiting && teleop::moves(from))
    cell_.observer.on_note(name + "the clutch is released");
}

/// The next target: as soon as the leader has moved, and now and then while it rests.
void Teleoperation::send(Pair& pair) const {
  const Nanoseconds now = cell_.machine.now();
  if (!pair.changed && now - pair.sent < kAgain) return;
  pair.sent = now;
  jog::JogCommand command;
  command.hold = kHold;
  command.wish = pair.map->target(pair.q);
  command.wish.speed =
      pair.settings.speed * (pair.phase == TeleopPhase::approaching ? pair.settings.approach : 1);
  cell_.jogging.estimate(pair.follower, pair.session, command.wish);
  cell_.jogging.send(pair.follower, pair.session, command);
}

void Teleoperation::grip(Pair& pair) const {
  const auto& link = pair.settings.grip;
  if (!link) return;
  const double opening = link->hand.opening(pair.q[pair.grip_joint]);
  pair.gripped = teleop::closed_with_play(pair.gripped, opening, kGripOn, kGripOff);
  const data::Value* const tag = cell_.data.store.find(link->tag);
  if (!tag) return;
  const std::string who = "teleop " + pair.settings.name;
  if (tag->as_boolean())
    cell_.data.store.set(link->tag, pair.gripped, who);
  else if (tag->as_number())
    cell_.data.store.set(link->tag, std::clamp(opening, 0.0, 1.0), who);
}

void Teleoperation::tick(Pair& pair) const {
  see_leader(pair);
  TeleopSeen seen;
  seen.leader = pair.good;
  seen.held = clutch_held(pair, seen);
  if (seen.held && seen.allowed && pair.good && pair.phase == TeleopPhase::engaging) take_over(pair, seen);
  judge_follower(pair, seen);
  const TeleopPhase now = next(pair.phase, seen);
  if (now != pair.phase) change(pair, now);
  if (!teleop::moves(pair.phase)) return;
  send(pair);
  grip(pair);
}

void Teleoperation::tick() {
  for (const auto& pair : pairs_) tick(*pair);
}

}  // namespace polyarm::cell
