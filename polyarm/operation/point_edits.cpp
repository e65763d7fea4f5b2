#include "polyarm/operation/point_edits.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::cell {

using Json = nlohmann::json;
using namespace protocol;

PoseFacts pose_facts(const Pose& pose) {
  return {pose.position, pose.rotation, to_rpy(pose.rotation)};
}

namespace {

std::map<std::string, double> joint_map(const data::JointState& joints) {
  std::map<std::string, double> out;
  for (std::size_t i = 0; i < joints.positions.size(); ++i)
    out[i < joints.names.size() ? joints.names[i] : std::to_string(i + 1)] = joints.positions[i];
  return out;
}

}  // namespace

const data::Value& place_of(const data::DataStore& store, const std::string& name) {
  const data::Value* value = store.find(name);
  if (value && value->is_place()) return *value;
  std::vector<std::string> known;
  for (const std::string& each : store.names())
    if (store.find(each)->is_place()) known.push_back(each);
  throw Error("unknown-name",
              value ? "'" + name + "' is " + data::name(value->kind()) + ", no point"
                    : "there is no point '" + name + "'" + did_you_mean(name, known),
              known.empty() ? "teach one: points.teach" : "there are: " + join(known, ", "));
}

const data::Value& kept_value(const data::DataStore& store, const std::string& name) {
  const data::Value* value = store.find(name);
  return value && !store.set_of(name).empty() ? *value : place_of(store, name);
}

void check_point_name(const std::string& name) {
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.' || c >= 0x80; };
  if (name.empty() || name.size() > 64 || std::isdigit(static_cast<unsigned char>(name[0])) ||
      !std::all_of(name.begin(), name.end(), good))
    throw Error("bad-name", "'" + name + "' is not a name for a point",
                "letters, digits and _, a letter first");
}

std::string set_for(const CellData& data, const std::optional<std::string>& file, const std::string& name) {
  const std::vector<std::string> sets = data.files().sets();
  const std::string wanted = file.value_or("");
  if (!wanted.empty()) {
    for (const std::string& set : sets)
      if (wanted == set || wanted == data.files().file_of(set).filename()) return set;
    throw Error("unknown-file", "the cell has no data file '" + wanted + "'" + did_you_mean(wanted, sets),
                "there are: " + join(sets, ", "));
  }
  if (const std::string has = data.store.set_of(name); !has.empty()) return has;
  std::string best;
  std::size_t most = 0;
  for (const std::string& set : sets) {
    std::size_t count = 0;
    for (const std::string& each : data.store.names())
      count += data.store.find(each)->is_place() && data.store.set_of(each) == set ? 1 : 0;
    if (best.empty() || count > most) best = set, most = count;
  }
  if (best.empty())
    throw Error("no-points-file", "the cell has no data file for points",
                "write 'load points' into the program, and create the file points.points beside it");
  return best;
}

std::filesystem::path own_file(const CellSetup& setup, const CellData& data, const std::string& set) {
  return setup.file.folder / data.files().file_of(set).filename();
}

namespace {
bool same_entry(const data::Entry* a, const data::Entry* b) {
  return a && b ? a->value == b->value && a->group == b->group : a == b;
}

/// True if the running cell has the same value as `entry` for this name in this set.
bool run_has(const CellData& data, const std::string& set, const data::Entry& entry) {
  const data::Value* value = data.store.find(entry.name);
  return value && data.store.set_of(entry.name) == set && *value == entry.value &&
         data.store.group_of(entry.name) == entry.group;
}
}  // namespace

Outside outside_changes(CellData& data, const std::string& set, const data::DataSet& now) {
  Outside out;
  const data::DataSet& origin = data.files().origin(set);
  for (const data::Entry& entry : now.entries()) {
    const data::Entry* before = origin.find(entry.name);
    if (!same_entry(before, &entry) && !run_has(data, set, entry))
      (before ? out.changed : out.added).push_back(entry.name);
  }
  for (const data::Entry& entry : origin.entries())
    if (!now.find(entry.name) && data.store.set_of(entry.name) == set) out.removed.push_back(entry.name);
  return out;
}

void take_outside_changes(CellData& data, const std::string& set, const data::DataSet& now) {
  const Outside found = outside_changes(data, set, now);
  for (const std::string& name : found.removed) data.files().remove(set, name);
  for (const auto* names : {&found.changed, &found.added})
    for (const std::string& name : *names) {
      const data::Entry& entry = *now.find(name);
      data.files().put(set, name, entry.value, "outside");
      data.files().set_group(set, name, entry.group);
    }
  data.files().origin(set) = now;
}

void adopt(CellData& data, const std::string& set, const Edited& edited) {
  // Only this edit counts as known; changes that others made to the file before it do not.
  data::DataSet origin;
  const data::DataSet& known = data.files().origin(set);
  const auto keep = [&origin](const data::Entry& entry) {
    origin.set(entry.name, entry.value, entry.where);
    origin.set_group(entry.name, entry.group);
  };
  for (const data::Entry& entry : known.entries())
    if (!edited.before.find(entry.name) || edited.after.find(entry.name)) keep(entry);
  for (const data::Entry& entry : edited.after.entries())
    if (!same_entry(edited.before.find(entry.name), &entry)) keep(entry);
  data.files().origin(set) = std::move(origin);
  for (const data::Entry& entry : edited.before.entries())
    if (!edited.after.find(entry.name)) data.files().remove(set, entry.name);
  for (const data::Entry& entry : edited.after.entries()) {
    const data::Entry* old = edited.before.find(entry.name);
    if (!old || !(old->value == entry.value)) data.files().put(set, entry.name, entry.value, "a person");
    if (entry.group != (old ? old->group : "")) data.files().set_group(set, entry.name, entry.group);
  }
}

Poll<Done> edit_set(const PointOwners& cell, const std::string& set, const std::string& what,
                    std::function<void(data::ImportFile&)> change) {
  const auto edit = [file = own_file(cell.setup, cell.data, set), what, change = std::move(change)] {
    Edited out;
    const data::ImportFile after = data::edit_set(file, what, [&](data::ImportFile& content) {
      out.before = content.values();
      change(content);
    });
    out.after = after.values();
    return out;
  };
  return later(cell.worker, edit, [cell, set](const Edited& edited) {
    adopt(cell.data, set, edited);
    return Done{};
  });
}

void require_short_name(const std::string& name) {
  if (name.size() > bounds::kAddedNameBytes)
    throw Error("too-long", "the name '" + name.substr(0, 40) + "…' has " + std::to_string(name.size()) + " bytes",
                "a name may have " + std::to_string(bounds::kAddedNameBytes));
}

void require_room_for(const data::DataStore& store, const std::string& name) {
  require_short_name(name);
  if (store.find(name) || store.names().size() < bounds::kDataValues) return;
  throw Error("too-many",
              "the cell's data have " + std::to_string(bounds::kDataValues) + " points and variables already",
              "delete some of them");
}

namespace {
/// Throws Error("frame-cycle") if a point with this value would be in a frame that is in the point itself.
void require_no_circle(const data::DataStore& store, const std::string& name, const data::Value& value) {
  const data::Point* const point = value.as_point();
  if (!point) return;
  data::frame_chain(name, [&](const std::string& each) {
    const data::Value* const kept = each == name ? &value : store.find(each);
    return kept ? kept->as_point() : nullptr;
  });
}
}  // namespace

Poll<ChangedPoint> edit_value(const PointOwners& cell, const std::string& set, const std::string& what,
                              const std::string& name, const data::Value& value,
                              const std::optional<std::string>& group) {
  require_room_for(cell.data.store, name);
  data::check_can_keep(name, value, set);
  require_no_circle(cell.data.store, name, value);
  if (group) data::check_group(*group);
  const auto change = [name, value, group](data::ImportFile& file) {
    file.set(name, value);
    if (group) file.set_group(name, *group);
  };
  return then(edit_set(cell, set, what, change), [cell, name, what](Done) {
    return at_once(ChangedPoint{point_facts(cell, name), what});
  });
}

std::vector<double> joints_now(const Machine& machine, const CellRobot& robot) {
  std::vector<double> out;
  for (const controllers::JointFacts& joint : robot.joints) {
    const auto index = machine.table().find_state(joint.name + "/position");
    out.push_back(index ? machine.snapshot().states[*index] : 0.0);
  }
  return out;
}

namespace {
/// T_world_frame of a frame on a robot; empty: unknown here.
std::optional<Pose> on_robot(const CellSetup& setup, const data::RobotFrame& frame, const CellRobot* own,
                             const Motions* motions) {
  using Part = data::RobotFrame::Part;
  if (frame.robot.empty()) {
    if (!own && setup.robots.size() == 1) own = setup.robots.front().get();
    return own ? std::optional(own->entry.base) : std::nullopt;
  }
  for (std::size_t i = 0; i < setup.robots.size(); ++i) {
    const CellRobot& robot = *setup.robots[i];
    if (robot.entry.name != frame.robot) continue;
    if (frame.part == Part::base) return robot.entry.base;
    if (!motions) return std::nullopt;
    return frame.part == Part::tcp ? motions->tcp(i) : motions->tcp(i) * inverse(robot.tool.tcp);
  }
  return std::nullopt;
}

std::vector<std::string> frames_of(const CellSetup& setup, const data::DataStore& store) {
  std::vector<std::string> robots;
  for (const auto& robot : setup.robots) robots.push_back(robot->entry.name);
  std::vector<std::string> out = data::named_frames(robots);
  for (const std::string& name : store.names())
    if (store.find(name)->as_point()) out.push_back(name);
  return out;
}
}  // namespace

Pose frame_in_world(const CellSetup& setup, const data::DataStore& store, const std::string& frame,
                    const CellRobot* own, const Motions* motions) {
  const data::FrameChain chain = data::frame_chain(frame, [&](const std::string& name) {
    const data::Value* value = store.find(name);
    return value ? value->as_point() : nullptr;
  });
  if (chain.root.empty()) return chain.pose;
  const auto part = data::robot_frame(chain.root);
  if (const auto on = part ? on_robot(setup, *part, own, motions) : std::nullopt) return *on * chain.pose;
  const data::Value* value = store.find(chain.root);
  throw Error(
      "unknown-frame",
      part    ? "the place of the frame '" + chain.root + "' is not known here"
      : value ? "'" + chain.root + "' is " + data::name(value->kind()) + ", not a frame"
              : "there is no frame '" + chain.root + "'" + did_you_mean(chain.root, frames_of(setup, store)),
      data::kFramesAre);
}

Pose point_in_world(const CellSetup& setup, const data::DataStore& store, const data::Point& point,
                    const CellRobot* own, const Motions* motions) {
  return frame_in_world(setup, store, point.frame(), own, motions) * point.pose;
}

std::string file_name(const CellData& data, const std::string& set) {
  const std::vector<std::string> sets = data.files().sets();
  return std::find(sets.begin(), sets.end(), set) == sets.end()
             ? ""
             : data.files().file_of(set).filename().string();
}

PointFacts point_facts(const PointOwners& cell, const std::string& name) {
  const data::Value& value = *cell.data.store.find(name);
  PointFacts out;
  out.name = name;
  out.kind = static_cast<ValueKind>(value.kind());
  out.file = file_name(cell.data, cell.data.store.set_of(name));
  out.text = value.text();
  out.literal = data::literal(value);
  out.group = cell.data.store.group_of(name);
  if (const bool* flag = value.as_boolean()) out.value = *flag;
  if (const std::string* text = value.as_text()) out.value = *text;
  if (const data::Number* number = value.as_number()) {
    out.value = number->value;
    out.unit = data::unit_text(number->dimension);
  }
  if (const data::JointState* joints = value.as_joints()) out.joints.emplace(joint_map(*joints));
  const data::Point* point = value.as_point();
  if (!point) return out;
  out.pose.emplace(pose_facts(point->pose));
  try {
    out.world.emplace(pose_facts(point_in_world(cell.setup, cell.data.store, *point, nullptr)));
  } catch (const Error&) {  // this cell does not have its frame
  }
  if (!point->taught) return out;
  out.taught.emplace(TaughtFacts{point->taught->frame, point->taught->tool, point->taught->robot});
  if (!point->taught->joints.positions.empty()) out.joints.emplace(joint_map(point->taught->joints));
  return out;
}

Vec3 vector_value(const Json& list, const char* what) {
  const auto number = [](const Json& each) { return each.is_number() && std::isfinite(each.get<double>()); };
  if (!list.is_array() || list.size() != 3 || !std::all_of(list.begin(), list.end(), number))
    throw Error("bad-argument", std::string("'") + what + "' is " + list.dump() + ", not three numbers in m");
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

Pose pose_value(const Json& map) {
  const Json q = map.is_object() ? map.value("q", Json()) : Json();
  const auto number = [](const Json& each) { return each.is_number() && std::isfinite(each.get<double>()); };
  if (!q.is_array() || q.size() != 4 || !std::all_of(q.begin(), q.end(), number))
    throw Error("bad-argument", map.dump() + " is not a pose", "{p: [x, y, z], q: [x, y, z, w]}");
  const Quaternion turn{q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>()};
  if (std::abs(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w - 1) > 1e-3)
    throw Error("bad-argument", "'q' is not a unit quaternion x y z w");
  return {vector_value(map.value("p", Json()), "p"), normalized(turn)};
}

}  // namespace polyarm::cell
