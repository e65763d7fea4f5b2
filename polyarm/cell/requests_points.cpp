/// Requests about points: the list, teaching and changing them. What is changed goes into the user's file,
/// whose history keeps what was there, and into the running cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/point_edits.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;
using data::ImportFile;

/// Where the robot stands, with all that a point remembers.
data::Value standing_value(Cell& cell, std::size_t i, bool as_joints, const std::string& frame) {
  const CellRobot& robot = *cell.robots()[i];
  if (!cell.snapshot().standing && !cell.idle(i))
    throw Error("moving", "'" + robot.entry.name + "' moves", "teach where it stands");
  data::JointState joints;
  joints.positions = joints_now(cell, robot);
  for (const controllers::JointFacts& joint : robot.joints)
    joints.names.push_back(joint.name.substr(joint.name.find('/') + 1));
  if (as_joints) return joints;
  data::Point point{inverse(frame_in_world(cell, frame)) * cell.tcp(i), true};
  point.taught = std::make_shared<data::Taught>(
      data::Taught{frame == "world" ? "" : frame, robot.entry.tool, robot.entry.model, joints});
  return point;
}

/// The set that all of these are in. Throws Error("bad-points") where they are in several.
std::string one_set(Cell& cell, const std::vector<std::string>& names) {
  const std::string set = cell.store().set_of(names.front());
  for (const std::string& each : names)
    if (cell.store().set_of(each) != set)
      throw Error("bad-points", "'" + each + "' is in another file than '" + names.front() + "'",
                  "change them apart");
  return set;
}

Json values_json(Cell& cell, const std::vector<std::string>& names) {
  Json out = Json::array();
  for (const std::string& each : names) out.push_back(value_json(cell, each));
  return {{"values", out}};
}

Vec3 vector_argument(const Json& map, const std::array<const char*, 3>& keys, Dimension dimension) {
  std::array<double, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Json value = map.value(keys[k], Json(0));
    std::optional<double> number;
    if (value.is_number()) number = value.get<double>();
    if (value.is_string()) number = parse_quantity(value.get<std::string>(), dimension);
    if (!number || !std::isfinite(*number))
      throw Error("bad-argument",
                  std::string("'") + keys[k] + "' is " + value.dump() + ", not " + name(dimension));
    out[k] = *number;
  }
  return {out[0], out[1], out[2]};
}

/// Lines of the folder's programs that say the name, outside of texts and comments as far as one line shows.
Json uses_of(const fs::path& folder, const std::string& name) {
  const auto part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
  };
  Json out = Json::array();
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
        out.push_back({{"file", entry.path().filename().string()}, {"line", number}});
        break;
      }
    }
  }
  return out;
}

Poll points(Cell& cell, const Json&) {
  Json values = Json::array(), files = Json::array();
  std::vector<std::string> names = cell.store().names();
  std::sort(names.begin(), names.end());
  for (const std::string& each : names)
    if (!cell.store().set_of(each).empty()) values.push_back(value_json(cell, each));
  for (const std::string& set : cell.files().sets()) files.push_back(file_name(cell, set));
  const std::string newest = files.empty() ? "" : file_name(cell, set_for(cell, Json::object(), ""));
  return at_once({{"file", newest}, {"files", files}, {"values", values}});
}

Poll points_here(Cell& cell, const Json& arguments) {
  const std::size_t i = robot_argument(cell, arguments);
  const CellRobot& robot = *cell.robots()[i];
  const Pose tcp = cell.tcp(i);
  const std::vector<double> q = joints_now(cell, robot);
  Json joints = Json::object();
  for (std::size_t j = 0; j < q.size(); ++j)
    joints[robot.joints[j].name.substr(robot.joints[j].name.find('/') + 1)] = q[j];
  return at_once({{"robot", robot.entry.name},
                  {"tcp", place_json(tcp)},
                  {"flange", place_json(tcp * inverse(robot.tool.tcp))},
                  {"joints", joints},
                  {"tool", robot.entry.tool}});
}

/// The group that the arguments name; nothing where they name none.
std::optional<std::string> group_argument(const Json& arguments) {
  if (!arguments.contains("group")) return std::nullopt;
  return std::string(trim(text_argument(arguments, "group")));
}

Poll points_teach(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_point_name(name);
  const data::Value* old = cell.store().find(name);
  if (old && !old->is_place())
    throw Error("exists", "'" + name + "' is " + data::name(old->kind()), "give the point another name");
  if (old && !flag_argument(arguments, "replace"))
    throw Error("exists", "there is a point '" + name + "' already", "say 'replace' to touch it up");
  const std::string kind = text_argument(arguments, "kind", old && old->as_joints() ? "joints" : "pose");
  if (kind != "pose" && kind != "joints")
    throw Error("bad-argument", "there is no kind '" + kind + "' of points", "pose or joints");
  const std::string frame =
      text_argument(arguments, "frame", old && old->as_point() ? old->as_point()->frame() : "");
  const data::Value value = standing_value(cell, robot_argument(cell, arguments), kind == "joints", frame);
  return edit_value(cell, set_for(cell, arguments, name), (old ? "touch up " : "teach ") + name, name, value,
                    group_argument(arguments));
}

Poll points_set(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_point_name(name);
  std::string why;
  auto value = data::parse_literal(text_argument(arguments, "value"), why);
  if (!value)
    throw Error(
        "bad-argument", "'value' is no value" + (why.empty() ? "" : ": " + why),
        "for example true, 40mm, pose(x, y, z, roll, pitch, yaw), quat(…), joints(elbow_joint = 0.5, …)");
  const std::string frame = text_argument(arguments, "frame", "");
  if (const data::Point* point = value->as_point(); point && !frame.empty()) {
    data::Point out = *point;
    data::Taught taught = out.taught ? *out.taught : data::Taught{};
    taught.frame = frame == "world" ? "" : frame;
    frame_in_world(cell, taught.frame);
    out.taught = std::make_shared<data::Taught>(std::move(taught));
    value = out;
  }
  return edit_value(cell, set_for(cell, arguments, name), "set " + name, name, *value);
}

Poll points_shift(Cell& cell, const Json& arguments) {
  const Json by = arguments.value("by", Json::object());
  const Vec3 way = vector_argument(by, {"x", "y", "z"}, Dimension::length);
  const Vec3 turn = vector_argument(by, {"rx", "ry", "rz"}, Dimension::angle);
  const Pose change = pose_xyz_rpy(way, turn);
  const std::string along = text_argument(arguments, "along", "frame");
  if (along != "frame" && along != "own")
    throw Error("bad-argument", "there is no way 'along " + along + "'", "frame or own");
  const std::vector<std::string> names = list_argument(arguments, "names");
  if (names.empty()) throw Error("bad-argument", "no point is named", "'names': [\"Pick\", \"Place\"]");
  std::vector<std::pair<std::string, data::Value>> shifted;
  for (const std::string& each : names) place_of(cell, each);
  const std::string set = one_set(cell, names);
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell, each).as_point();
    if (!point) throw Error("bad-points", "'" + each + "' is a joint state, which has no place to shift");
    data::Point out = *point;
    out.pose = along == "own" ? out.pose * change
                              : Pose{out.pose.position + way, change.rotation * out.pose.rotation};
    if (out.taught) {  // the joints are those of another place
      auto taught = std::make_shared<data::Taught>(*out.taught);
      taught->joints = {};
      out.taught = std::move(taught);
    }
    shifted.emplace_back(each, std::move(out));
  }
  return edit_set(
      cell, set, "shift " + join(names, ", "),
      [shifted](ImportFile& file) {
        for (const auto& [name, value] : shifted) file.set(name, value);
      },
      [names](Cell& c) { return values_json(c, names); });
}

Poll points_group(Cell& cell, const Json& arguments) {
  const std::string group = *group_argument(arguments);
  data::check_group(group);
  const std::vector<std::string> names = list_argument(arguments, "names");
  if (names.empty()) throw Error("bad-argument", "no point is named", "'names': [\"Pick\", \"Place\"]");
  for (const std::string& each : names) kept_value(cell, each);
  const std::string set = one_set(cell, names);
  return edit_set(
      cell, set, (group.empty() ? "no group for " : "group " + group + ": ") + join(names, ", "),
      [names, group](ImportFile& file) {
        for (const std::string& each : names) file.set_group(each, group);
      },
      [names](Cell& c) { return values_json(c, names); });
}

Poll points_rename(Cell& cell, const Json& arguments) {
  const std::string from = text_argument(arguments, "name"), to = text_argument(arguments, "to");
  require_short_name(to);
  check_point_name(to);
  const data::Value value = kept_value(cell, from);
  if (cell.store().find(to)) throw Error("in-use", "there is a '" + to + "' already", "give another name");
  auto uses = std::make_shared<Json>();
  return edit_set(
      cell, set_for(cell, Json::object(), from), "rename " + from + " to " + to,
      [from, to, value, uses, folder = cell.file().folder](ImportFile& file) {
        const data::Entry* entry = file.values().find(from);
        const std::string group = entry ? entry->group : "";
        file = data::without(file, from);
        file.set(to, value);
        file.set_group(to, group);
        *uses = uses_of(folder, from);
      },
      [to, uses](Cell& c) {
        Json out = value_json(c, to);
        out["uses"] = *uses;
        return out;
      });
}

Poll points_delete(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  kept_value(cell, name);
  return edit_set(
      cell, set_for(cell, Json::object(), name), "delete " + name,
      [name](ImportFile& file) { file = data::without(file, name); },
      [name](Cell&) {
        return Json{{"name", name}};
      });
}

Poll points_history(Cell& cell, const Json& arguments) {
  return later<Json>(
      cell,
      [file = own_file(cell, set_for(cell, arguments, ""))] {
        Json out = Json::array();
        for (const data::SetVersion& each : data::history(file))
          out.push_back({{"number", each.number}, {"when", each.when}, {"what", each.what}});
        std::reverse(out.begin(), out.end());
        return out;
      },
      [](Cell&, Json& out) { return out; });
}

Poll points_undo(Cell& cell, const Json& arguments) {
  const std::string set = set_for(cell, arguments, "");
  const auto steps = static_cast<std::size_t>(std::clamp(number_argument(arguments, "steps", 1), 1.0, 200.0));
  return later<Edited>(
      cell,
      [file = own_file(cell, set), steps] {
        Edited out;
        const auto versions = data::history(file);
        out.what = versions.empty() ? "" : versions.back().what;
        out.before = ImportFile::load(file.string()).values();
        data::undo(file, steps);
        out.after = ImportFile::load(file.string()).values();
        return out;
      },
      [set](Cell& c, Edited& edited) {
        adopt(c, set, edited);
        return Json{{"what", edited.what}};
      });
}

/// The user's own files that the run has copies of, as they are now; what cannot be read is left out.
std::map<std::string, data::DataSet> own_files(const std::map<std::string, fs::path>& paths) {
  std::map<std::string, data::DataSet> out;
  for (const auto& [set, path] : paths) {
    Problems problems;
    collect(problems, [&, &set = set, &path = path] { out[set] = ImportFile::load(path.string()).values(); });
  }
  return out;
}

std::map<std::string, fs::path> copied_sets(Cell& cell) {
  std::map<std::string, fs::path> out;
  for (const std::string& set : cell.files().sets())
    if (!cell.files().is_live(set)) out[set] = own_file(cell, set);
  return out;
}

Poll outside(Cell& cell, bool take) {
  return later<std::map<std::string, data::DataSet>>(
      cell, [paths = copied_sets(cell)] { return own_files(paths); },
      [take](Cell& c, std::map<std::string, data::DataSet>& found) {
        Json out = Json::array();
        for (const auto& [set, now] : found) {
          const Outside outside = outside_changes(c, set, now);
          if (!outside.any()) continue;
          out.push_back({{"file", file_name(c, set)},
                         {"changed", outside.changed},
                         {"added", outside.added},
                         {"removed", outside.removed}});
          if (take) take_outside_changes(c, set, now);
        }
        return Json{{"files", out}};
      });
}

Poll points_outside(Cell& cell, const Json&) {
  return outside(cell, false);
}
Poll points_take(Cell& cell, const Json&) {
  return outside(cell, true);
}

}  // namespace

const std::vector<RequestRow>& point_rows() {
  constexpr const char* kOutside = "{files: [{file, changed, added, removed}]}";
  static const std::vector<RequestRow> table = {
      {{"points",
        {},
        "{file, files, values: [{name, kind, file, text, literal, value, unit, pose: {p, q, rpy}, world, "
        "joints, taught: {frame, tool, robot}, group}]}",
        "points and variables of the cell's data, and the file that new ones go into",
        false},
       points},
      {{"points.here",
        {{"robot", kText}},
        "{robot, tcp: {p, q, rpy}, flange, joints, tool}",
        "where a robot stands, in the world",
        false},
       points_here},
      {{"points.teach",
        {{"name", kText, true},
         {"robot", kText},
         {"kind", kText},
         {"frame", kText},
         {"file", kText},
         {"group", kText},
         {"replace", kFlag}},
        "{name, …, undo}, as in points",
        "where the robot stands becomes a point (`kind` pose or joints; in `frame`), in the user's file and "
        "in the running cell; with `replace` one that is there is touched up",
        true},
       points_teach},
      {{"points.set",
        {{"name", kText, true}, {"value", kText, true}, {"frame", kText}, {"file", kText}},
        "{name, …, undo}, as in points",
        "a point or variable gets a value: `pose(0.3, 0, 0.1, 180deg, 0, 0)`, `joints(…)`, `40mm`",
        true},
       points_set},
      {{"points.shift",
        {{"names", kNames, true}, {"by", kMap, true}, {"along", kText}},
        "{values: [{name, …}], undo}",
        "poses are moved `by` {x, y, z, rx, ry, rz} along the axes of their `frame` (otherwise) or their "
        "`own`",
        true},
       points_shift},
      {{"points.group",
        {{"names", kNames, true}, {"group", kText, true}},
        "{values: [{name, …}], undo}",
        "points and variables are put into a group (an empty text: into none) by a line of their file; "
        "programs do not see it",
        true},
       points_group},
      {{"points.rename",
        {{"name", kText, true}, {"to", kText, true}},
        "{name, …, uses: [{file, line}], undo}",
        "a point gets another name; `uses` are lines of programs that still say the old one",
        true},
       points_rename},
      {{"points.delete", kName, "{name, undo}", "a point goes; points.undo brings it back", true},
       points_delete},
      {{"points.outside",
        {},
        kOutside,
        "what somebody has written into the user's data files since the run took its copies of them, by name",
        false},
       points_outside},
      {{"points.take", {}, kOutside, "the run takes that over", true}, points_take},
      {{"points.history",
        {{"file", kText}},
        "[{number, when, what}]",
        "the changes of a data file that can be taken back, newest first",
        false},
       points_history},
      {{"points.undo",
        {{"file", kText}, {"steps", kNumber}},
        "{what}",
        "take the last changes of a data file back, in the running cell, too",
        true},
       points_undo},
  };
  return table;
}

}  // namespace polyarm::cell
