#include "polyarm/tasks/wait_hints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "polyarm/description/shape_bounds.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

namespace {
std::optional<double> state_of(const WaitOwners& cell, const std::string& interface) {
  const auto at = cell.machine.table().find_state(interface);
  const auto& states = cell.machine.snapshot().states;
  if (!at || *at >= states.size()) return std::nullopt;
  return states[*at];
}

const signals::Tag* command_tag(const WaitOwners& cell, const std::string& interface) {
  for (const signals::Tag& tag : cell.data.signals().tags)
    if (tag.role == data::TagRole::command && tag.interface == interface) return &tag;
  return nullptr;
}

std::string parts(double count) {
  return fmt::format("{:.0f} part{}", count, count == 1 ? "" : "s");
}

/// `at_feeder`: the wait reads the feeder itself, not a gripper that takes from it.
std::string hint_of(const WaitOwners& cell, const std::string& feeder, bool at_feeder) {
  const auto presented = state_of(cell, "scene/" + feeder + "/presented");
  const auto remaining = state_of(cell, "scene/" + feeder + "/remaining");
  if (!presented || !remaining) return {};
  const signals::Tag* tag = command_tag(cell, "scene/" + feeder + "/feed");
  const double asked = tag ? cell.data.tags().sent(tag->name).value_or(0) : 0;
  if (*remaining <= 0 && (at_feeder || asked > *presented))
    return *presented <= 0
               ? "the feeder '" + feeder + "' is empty: no part of the scene has 'feeder: " + feeder + "'"
               : "the feeder '" + feeder + "' is empty: it has brought all of its " + parts(*presented);
  if (!at_feeder) return {};
  if (asked > *presented) return "the feeder '" + feeder + "' brings its next part when its place is free";
  const std::string asks = tag ? "set '" + tag->name + "' to one more"
                               : "no tag of signals.yaml has 'command: scene/" + feeder + "/feed'";
  return fmt::format("the feeder '{}' was to bring {} and has brought {}: {}", feeder, parts(asked),
                     *presented <= 0 ? "none" : "as many", asks);
}

/// Distance from a point to the surface of a shape at the origin; 0 inside. Of a mesh, to the box around it.
double distance(const Vec3& p, const description::Shape& shape) {
  using description::ShapeKind;
  const double radial = std::hypot(p.x, p.y), up = std::abs(p.z);
  const auto beyond = [](double value, double bound) { return std::max(0.0, value - bound); };
  switch (shape.kind) {
    case ShapeKind::box:
      return std::hypot(beyond(std::abs(p.x), shape.size.x / 2), beyond(std::abs(p.y), shape.size.y / 2),
                        beyond(up, shape.size.z / 2));
    case ShapeKind::cylinder:
      return std::hypot(beyond(radial, shape.radius), beyond(up, shape.length / 2));
    case ShapeKind::mesh: {
      const description::Bounds around = description::bounds_of(shape, {});
      const auto away = [](double x, double low, double high) { return std::max({0.0, low - x, x - high}); };
      return std::hypot(away(p.x, around.lower.x, around.upper.x), away(p.y, around.lower.y, around.upper.y),
                        away(p.z, around.lower.z, around.upper.z));
    }
    default:
      return beyond(std::hypot(radial, beyond(up, shape.length / 2)), shape.radius);
  }
}

struct NearPart {
  const description::Part* part = nullptr;
  double away = 0;  ///< distance of the TCP from its surface, m
};

/// The nearest part that nothing holds; empty if there is none in the cell.
NearPart nearest_part(const WaitOwners& cell, const Vec3& tcp) {
  NearPart out;
  const auto& states = cell.machine.snapshot().world.parts;
  for (std::size_t i = 0; i < std::min(states.size(), cell.setup.scene.parts.size()); ++i) {
    if (!states[i].in_world || states[i].held_by >= 0) continue;
    const description::Part& part = cell.setup.scene.parts[i];
    const Vec3 there = inverse(states[i].pose.rotation) * (tcp - states[i].pose.position);
    const double away = distance(there, part.shape);
    if (!out.part || away < out.away) out = {&part, away};
  }
  return out;
}

/// The part that this robot's gripper holds; empty if it holds none.
std::string held_by(const WaitOwners& cell, std::size_t robot) {
  const auto& states = cell.machine.snapshot().world.parts;
  for (std::size_t i = 0; i < std::min(states.size(), cell.setup.scene.parts.size()); ++i)
    if (states[i].in_world && states[i].held_by == static_cast<int>(robot))
      return cell.setup.scene.parts[i].name;
  return {};
}

/// Hint: the tag reads an interface that `--fault` forces to a value.
std::string hint_of_fault(const WaitOwners& cell, const signals::Tag& tag) {
  const auto at = cell.setup.options.faults.find(tag.interface);
  if (at == cell.setup.options.faults.end()) return {};
  return fmt::format("'{}' is {} because --fault forces {} to {:g}", tag.name,
                     cell.data.store.find(tag.name)->text(), tag.interface, at->second);
}

/// Hint: a wait for an outfeed needs a part that comes to rest there.
std::string hint_of_outfeed(const WaitOwners& cell, const description::Outfeed& outfeed) {
  const auto& states = cell.machine.snapshot().world.parts;
  const auto is_in = [&](const Vec3& p) {
    return p.x >= outfeed.lower.x && p.x <= outfeed.upper.x && p.y >= outfeed.lower.y &&
           p.y <= outfeed.upper.y && p.z >= outfeed.lower.z && p.z <= outfeed.upper.z;
  };
  for (std::size_t i = 0; i < std::min(states.size(), cell.setup.scene.parts.size()); ++i) {
    if (!states[i].in_world || !is_in(states[i].pose.position)) continue;
    const std::string part = cell.setup.scene.parts[i].name + " is in the outfeed '" + outfeed.name + "'";
    if (states[i].held_by >= 0)
      return part + " and still held by '" +
             cell.setup.robots[static_cast<std::size_t>(states[i].held_by)]->entry.name + "'";
    if (!states[i].asleep)
      return fmt::format("{} and still moves, at {:.3g} mm/s: it is taken once it has been at rest for 0.5 s",
                         part, states[i].speed * 1e3);
    const signals::Tag* take = command_tag(cell, "scene/" + outfeed.name + "/take");
    return part + " at rest: " +
           (take ? "set '" + take->name + "' to one more"
                 : "no tag of signals.yaml has 'command: scene/" + outfeed.name + "/take'");
  }
  return {};
}

/// Why this robot's gripper holds nothing.
std::string hint_of_gripper(const WaitOwners& cell, std::size_t robot) {
  constexpr double kGravity = 9.81;
  const CellRobot& arm = *cell.setup.robots[robot];
  const bool suction = arm.tool.gripper == description::GripperKind::suction;
  const std::string interface = arm.entry.name + (suction ? "/tool/vacuum" : "/tool/grip");
  const signals::Tag* tag = command_tag(cell, interface);
  if (!tag) return "no tag of signals.yaml has 'command: " + interface + "'";
  const std::string what = suction ? "the vacuum of '" : "the gripper of '";
  if (cell.data.tags().sent(tag->name).value_or(0) < 0.5)
    return what + arm.entry.name + (suction ? "' is off" : "' is open") + ": '" + tag->name + "' is " +
           cell.data.store.find(tag->name)->text();
  if (const std::string held = held_by(cell, robot); !held.empty())
    return what + arm.entry.name + "' holds " + held + ", and its sensor does not report it";
  const NearPart near = nearest_part(cell, cell.motions.tcp(robot).position);
  if (!near.part) {
    for (std::size_t other = 0; other < cell.setup.robots.size(); ++other)
      if (const std::string held = held_by(cell, other); !held.empty())
        return "no part lies in the cell; '" + cell.setup.robots[other]->entry.name + "' holds " + held;
    return "no part lies in the cell";
  }
  const double reach = suction ? arm.tool.reach : arm.tool.finger_length;
  if (near.away > reach)
    return fmt::format("the TCP of '{}' is {:.1f} mm away from {}, the nearest part{}", arm.entry.name,
                       near.away * 1e3, near.part->name,
                       suction ? fmt::format("; the cup grips within {:g} mm", reach * 1e3) : "");
  if (suction && near.part->mass * kGravity > arm.tool.holding_force)
    return fmt::format("{} weighs {:g} kg, and the cup holds {:g} N, which is {:.3g} kg", near.part->name,
                       near.part->mass, arm.tool.holding_force, arm.tool.holding_force / kGravity);
  return {};
}

/// Hint for a tag that is False or 0 because a gripper holds nothing.
std::string hint_of_gripper(const WaitOwners& cell, const signals::Tag& tag) {
  constexpr std::string_view kEnd = "/tool/part_present";
  const data::Value* value = cell.data.store.find(tag.name);
  if (!tag.interface.ends_with(kEnd) || !value || tag.to_interface(*value).value_or(1) != 0) return {};
  const std::string name = tag.interface.substr(0, tag.interface.size() - kEnd.size());
  for (std::size_t i = 0; i < cell.setup.robots.size(); ++i)
    if (cell.setup.robots[i]->entry.name == name) return hint_of_gripper(cell, i);
  return {};
}

void add_waits(const Task* task, std::vector<std::string>& names) {
  if (!task || task->ended() || task->status().waiting.kind != program::WaitKind::condition) return;
  const std::vector<std::string>& more = task->status().waiting.names;
  names.insert(names.end(), more.begin(), more.end());
}
}  // namespace

std::string hint_of_wait(const WaitOwners& cell, std::span<const std::string> names) {
  for (const signals::Tag& tag : cell.data.signals().tags) {
    if (tag.role != data::TagRole::state || std::find(names.begin(), names.end(), tag.name) == names.end())
      continue;
    if (std::string hint = hint_of_fault(cell, tag); !hint.empty()) return hint;
    for (const description::Outfeed& outfeed : cell.setup.scene.outfeeds)
      if (tag.interface.starts_with("scene/" + outfeed.name + "/"))
        if (std::string hint = hint_of_outfeed(cell, outfeed); !hint.empty()) return hint;
    for (const description::Feeder& feeder : cell.setup.scene.feeders) {
      const bool at_feeder = tag.interface.starts_with("scene/" + feeder.name + "/");
      if (!at_feeder && !tag.interface.ends_with("/tool/part_present")) continue;
      if (std::string hint = hint_of(cell, feeder.name, at_feeder); !hint.empty()) return hint;
    }
    if (std::string hint = hint_of_gripper(cell, tag); !hint.empty()) return hint;
  }
  return {};
}

std::string hint_of_wait(const WaitOwners& cell) {
  std::vector<std::string> names;
  add_waits(cell.programs.program(), names);
  add_waits(cell.programs.plc(), names);
  return hint_of_wait(cell, names);
}

void explain_timeout(const WaitOwners& cell, const Task& task, Problem& problem) {
  if (problem.code != "timeout" && problem.code != "expect") return;
  const program::Program& program = task.interpreter().program();
  const program::Statement* s = program::statement_at(program, problem.where);
  if (!s || !s->expression) return;
  std::vector<std::string> names = program::names_read(*s->expression);
  add_waits(cell.programs.plc(), names);
  if (const std::string hint = hint_of_wait(cell, names); !hint.empty()) problem.what += "; " + hint;
}

}  // namespace polyarm::cell
