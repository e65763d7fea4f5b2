/// Requests that list, teach and change points. A change is written to the user's file, whose history keeps
/// the earlier values, and to the running cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/literal.hpp"
#include "polyarm/operation/point_edits.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;
using namespace protocol;
using data::ImportFile;

/// The robot's present position as a value, with everything that a taught point stores.
data::Value standing_value(const PointOwners& cell, std::size_t i, bool as_joints, const std::string& frame) {
  const CellRobot& robot = *cell.setup.robots[i];
  if (!cell.machine.snapshot().standing && !cell.motions.idle(i))
    throw Error("moving", "'" + robot.entry.name + "' moves", "wait until it is at rest");
  data::JointState joints;
  joints.positions = joints_now(cell.machine, robot);
  for (const controllers::JointFacts& joint : robot.joints)
    joints.names.push_back(joint.name.substr(joint.name.find('/') + 1));
  if (as_joints) return joints;
  data::Point point{inverse(frame_in_world(cell.setup, cell.data.store, frame, &robot, &cell.motions)) *
                        cell.motions.tcp(i),
                    true};
  point.taught = std::make_shared<data::Taught>(
      data::Taught{frame == "world" ? "" : frame, robot.entry.tool, robot.entry.model, joints});
  return point;
}

/// The set that contains all of these points. Throws Error("bad-points") if they are in several sets.
std::string one_set(const PointOwners& cell, const std::vector<std::string>& names) {
  const std::string set = cell.data.store.set_of(names.front());
  for (const std::string& each : names)
    if (cell.data.store.set_of(each) != set)
      throw Error("bad-points", "'" + each + "' is in another file than '" + names.front() + "'",
                  "change them apart");
  return set;
}

std::vector<PointFacts> all_facts(const PointOwners& cell, const std::vector<std::string>& names) {
  std::vector<PointFacts> out;
  for (const std::string& each : names) out.push_back(point_facts(cell, each));
  return out;
}

Vec3 vector_of(const Map& map, const std::array<const char*, 3>& keys, Dimension dimension) {
  std::array<double, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto found = map.find(keys[k]);
    if (found == map.end()) continue;
    std::optional<double> number = found->second.number();
    if (const auto text = found->second.text()) number = parse_quantity(*text, dimension);
    if (!number || !std::isfinite(*number))
      throw Error("bad-argument",
                  std::string("'") + keys[k] + "' is " + found->second.dump() + ", not " + name(dimension));
    out[k] = *number;
  }
  return {out[0], out[1], out[2]};
}

/// Lines of the programs in the folder that use the name, outside strings and comments as far as a single
/// line shows this.
std::vector<FileLine> uses_of(const fs::path& folder, const std::string& name) {
  const auto part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
  };
  std::vector<FileLine> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() != ".script") continue;
    std::istringstream text(read_file(entry.path()));
    int number = 0;
    for (std::string line; std::getline(text, line);) {
      ++number;
      line = line.substr(0, line.find('#'));
      for (std::size_t at = line.find(name); at != std::string::npos; at = line.find(name, at + 1)) {
        const std::size_t end = at + name.size();
        if ((at > 0 && part(line[at - 1])) || (end < line.size() && part(line[end]))) continue;
        out.push_back({entry.path().filename().string(), number});
        break;
      }
    }
  }
  return out;
}

PointsList::Answer points(const PointOwners& cell, const PointsList&) {
  PointsList::Answer out;
  std::vector<std::string> names = cell.data.store.names();
  std::sort(names.begin(), names.end());
  for (const std::string& each : names)
    if (!cell.data.store.set_of(each).empty()) out.values.push_back(point_facts(cell, each));
  for (const std::string& set : cell.data.files().sets()) out.files.push_back(file_name(cell.data, set));
  if (!out.files.empty()) out.file = file_name(cell.data, set_for(cell.data, {}, ""));
  return out;
}

PointsHere::Answer points_here(const PointOwners& cell, const PointsHere& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  const CellRobot& robot = *cell.setup.robots[i];
  const Pose tcp = cell.motions.tcp(i);
  const std::vector<double> q = joints_now(cell.machine, robot);
  PointsHere::Answer out{robot.entry.name, pose_facts(tcp), pose_facts(tcp * inverse(robot.tool.tcp)), {},
                         robot.entry.tool};
  for (std::size_t j = 0; j < q.size(); ++j)
    out.joints[robot.joints[j].name.substr(robot.joints[j].name.find('/') + 1)] = q[j];
  return out;
}

std::optional<std::string> trimmed(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  return std::string(trim(*text));
}

Poll<ChangedPoint> points_teach(const PointOwners& cell, const PointsTeach& request) {
  const std::string& name = request.name;
  check_point_name(name);
  const data::Value* old = cell.data.store.find(name);
  if (old && !old->is_place())
    throw Error("exists", "'" + name + "' is " + data::name(old->kind()), "give the point another name");
  if (old && !request.replace)
    throw Error("exists", "there is a point '" + name + "' already", "set 'replace' to overwrite it");
  const PointKind kind = request.kind.value_or(old && old->as_joints() ? PointKind::joints : PointKind::pose);
  const std::string frame = request.frame.value_or(old && old->as_point() ? old->as_point()->frame() : "");
  const data::Value value =
      standing_value(cell, robot_named(cell.setup, request.robot), kind == PointKind::joints, frame);
  return edit_value(cell, set_for(cell.data, request.file, name), (old ? "touch up " : "teach ") + name, name,
                    value, trimmed(request.group));
}

/// Throws Error("unknown-frame"). `base` is a frame of each robot, so any of them stands for it here.
void require_frame(const PointOwners& cell, const std::string& frame) {
  const CellRobot* any = cell.setup.robots.empty() ? nullptr : cell.setup.robots.front().get();
  frame_in_world(cell.setup, cell.data.store, frame, any, &cell.motions);
}

Poll<ChangedPoint> points_set(const PointOwners& cell, const PointsSet& request) {
  const std::string& name = request.name;
  check_point_name(name);
  std::string why;
  auto value = data::parse_literal(request.value, why);
  if (!value)
    throw Error(
        "bad-argument", "'value' is not a value" + (why.empty() ? "" : ": " + why),
        "for example true, 40mm, pose(x, y, z, roll, pitch, yaw), quat(…), joints(elbow_joint = 0.5, …)");
  const std::string frame = request.frame.value_or("");
  if (const data::Point* point = value->as_point(); point && !frame.empty()) {
    data::Point out = *point;
    data::Taught taught = out.taught ? *out.taught : data::Taught{};
    taught.frame = frame == "world" ? "" : frame;
    require_frame(cell, taught.frame);
    out.taught = std::make_shared<data::Taught>(std::move(taught));
    value = out;
  }
  return edit_value(cell, set_for(cell.data, request.file, name), "set " + name, name, *value);
}

/// Changes points, and answers with all of them after the change.
Poll<ChangedPoints> edit_points(const PointOwners& cell, const std::string& set, const std::string& what,
                                const std::vector<std::string>& names,
                                std::function<void(ImportFile&)> change) {
  return then(edit_set(cell, set, what, std::move(change)), [cell, names, what](Done) {
    return at_once(ChangedPoints{all_facts(cell, names), what});
  });
}

Poll<ChangedPoints> points_shift(const PointOwners& cell, const PointsShift& request) {
  const Vec3 way = vector_of(request.by, {"x", "y", "z"}, Dimension::length);
  const Vec3 turn = vector_of(request.by, {"rx", "ry", "rz"}, Dimension::angle);
  const Pose change = pose_xyz_rpy(way, turn);
  const bool own = request.along == ShiftAlong::own;
  const std::vector<std::string>& names = request.names;
  if (names.empty()) throw Error("bad-argument", "no point is named", "'names': [\"Pick\", \"Place\"]");
  std::vector<std::pair<std::string, data::Value>> shifted;
  for (const std::string& each : names) place_of(cell.data.store, each);
  const std::string set = one_set(cell, names);
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell.data.store, each).as_point();
    if (!point) throw Error("bad-points", "'" + each + "' is a joint state, which has no place to shift");
    data::Point out = *point;
    out.pose = own ? out.pose * change
                              : Pose{out.pose.position + way, change.rotation * out.pose.rotation};
    if (out.taught) {  // the taught joints no longer match the shifted pose
      auto taught = std::make_shared<data::Taught>(*out.taught);
      taught->joints = {};
      out.taught = std::move(taught);
    }
    shifted.emplace_back(each, std::move(out));
  }
  return edit_points(cell, set, "shift " + join(names, ", "), names, [shifted](ImportFile& file) {
    for (const auto& [name, value] : shifted) file.set(name, value);
  });
}

Poll<ChangedPoints> points_group(const PointOwners& cell, const PointsGroup& request) {
  const std::string group(trim(request.group));
  data::check_group(group);
  const std::vector<std::string>& names = request.names;
  if (names.empty()) throw Error("bad-argument", "no point is named", "'names': [\"Pick\", \"Place\"]");
  for (const std::string& each : names) kept_value(cell.data.store, each);
  const std::string what = (group.empty() ? "no group for " : "group " + group + ": ") + join(names, ", ");
  return edit_points(cell, one_set(cell, names), what, names, [names, group](ImportFile& file) {
    for (const std::string& each : names) file.set_group(each, group);
  });
}

Poll<PointsRename::Answer> points_rename(const PointOwners& cell, const PointsRename& request) {
  const std::string from = request.name, to = request.to, what = "rename " + from + " to " + to;
  require_short_name(to);
  check_point_name(to);
  const data::Value value = kept_value(cell.data.store, from);
  if (cell.data.store.find(to)) throw Error("in-use", "there is a '" + to + "' already", "give another name");
  auto uses = std::make_shared<std::vector<FileLine>>();
  const auto change = [from, to, value, uses, folder = cell.setup.file.folder](ImportFile& file) {
    const data::Entry* entry = file.values().find(from);
    const std::string group = entry ? entry->group : "";
    file = data::without(file, from);
    file.set(to, value);
    file.set_group(to, group);
    *uses = uses_of(folder, from);
  };
  return then(edit_set(cell, set_for(cell.data, {}, from), what, change), [cell, to, uses, what](Done) {
    return at_once(PointsRename::Answer{{point_facts(cell, to), what}, *uses});
  });
}

Poll<PointsDelete::Answer> points_delete(const PointOwners& cell, const PointsDelete& request) {
  const std::string name = request.name, what = "delete " + name;
  kept_value(cell.data.store, name);
  return then(edit_set(cell, set_for(cell.data, {}, name), what,
                       [name](ImportFile& file) { file = data::without(file, name); }),
              [name, what](Done) {
                return at_once(PointsDelete::Answer{name, what});
              });
}

Poll<PointsHistory::Answer> points_history(const PointOwners& cell, const PointsHistory& request) {
  return later(cell.worker, [file = own_file(cell.setup, cell.data, set_for(cell.data, request.file, ""))] {
    PointsHistory::Answer out;
    for (const data::SetVersion& each : data::history(file))
      out.push_back({each.number, each.when, each.what});
    std::reverse(out.begin(), out.end());
    return out;
  });
}

Poll<PointsUndo::Answer> points_undo(const PointOwners& cell, const PointsUndo& request) {
  const std::string set = set_for(cell.data, request.file, "");
  const auto steps = static_cast<std::size_t>(std::clamp(request.steps.value_or(1), 1.0, 200.0));
  const auto undo = [file = own_file(cell.setup, cell.data, set), steps] {
    Edited out;
    const auto versions = data::history(file);
    out.what = versions.empty() ? "" : versions.back().what;
    out.before = ImportFile::load(file.string()).values();
    data::undo(file, steps);
    out.after = ImportFile::load(file.string()).values();
    return out;
  };
  return later(cell.worker, undo, [cell, set](const Edited& edited) {
    adopt(cell.data, set, edited);
    return PointsUndo::Answer{edited.what};
  });
}

/// Present contents of the user's own files that the run has copies of; unreadable files are left out.
std::map<std::string, data::DataSet> own_files(const std::map<std::string, fs::path>& paths) {
  std::map<std::string, data::DataSet> out;
  for (const auto& [set, path] : paths) {
    Problems problems;
    collect(problems, [&, &set = set, &path = path] { out[set] = ImportFile::load(path.string()).values(); });
  }
  return out;
}

std::map<std::string, fs::path> copied_sets(const PointOwners& cell) {
  std::map<std::string, fs::path> out;
  for (const std::string& set : cell.data.files().sets())
    if (!cell.data.files().is_live(set)) out[set] = own_file(cell.setup, cell.data, set);
  return out;
}

Poll<OutsideChanges> outside(const PointOwners& cell, bool take) {
  const auto read = [paths = copied_sets(cell)] { return own_files(paths); };
  return later(cell.worker, read, [cell, take](const std::map<std::string, data::DataSet>& found) {
    OutsideChanges out;
    for (const auto& [set, now] : found) {
      const Outside outside = outside_changes(cell.data, set, now);
      if (!outside.any()) continue;
      out.files.push_back({file_name(cell.data, set), outside.changed, outside.added, outside.removed});
      if (take) take_outside_changes(cell.data, set, now);
    }
    return out;
  });
}

Poll<OutsideChanges> points_outside(const PointOwners& cell, const PointsOutside&) {
  return outside(cell, false);
}
Poll<OutsideChanges> points_take(const PointOwners& cell, const PointsTake&) {
  return outside(cell, true);
}

}  // namespace

std::vector<Handler> point_handlers() {
  return handlers<points, points_here, points_teach, points_set, points_shift, points_group, points_rename,
                  points_delete, points_outside, points_take, points_history, points_undo>();
}

}  // namespace polyarm::cell
