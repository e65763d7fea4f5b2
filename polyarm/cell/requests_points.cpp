/// Requests about points: the list, teaching and changing them, and looking along a move before it is made.
/// What is changed goes into the user's file, whose history keeps what was there, and into the running cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_later.hpp"
#include "polyarm/data/literal.hpp"
#include "polyarm/data/set_edit.hpp"
#include "polyarm/data/taught_frames.hpp"
#include "polyarm/motion/move_plan.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;
using data::ImportFile;

Json vec(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Json pose_json(const Pose& pose) {
  const Quaternion& r = pose.rotation;
  return {{"p", vec(pose.position)}, {"q", {r.x, r.y, r.z, r.w}}, {"rpy", vec(to_rpy(r))}};
}

Json joints_json(const data::JointState& joints) {
  Json out = Json::object();
  for (std::size_t i = 0; i < joints.positions.size(); ++i)
    out[i < joints.names.size() ? joints.names[i] : std::to_string(i + 1)] = joints.positions[i];
  return out;
}

const char* kind_of(const data::Value& value) {
  constexpr const char* kKinds[] = {"boolean", "number", "text", "list", "joints", "pose", "record"};
  return kKinds[static_cast<std::size_t>(value.kind())];
}

const data::Value& place_of(Cell& cell, const std::string& name) {
  const data::Value* value = cell.store().find(name);
  if (value && value->is_place()) return *value;
  std::vector<std::string> known;
  for (const std::string& each : cell.store().names())
    if (cell.store().find(each)->is_place()) known.push_back(each);
  throw Error("unknown-name",
              value ? "'" + name + "' is " + data::name(value->kind()) + ", no point"
                    : "there is no point '" + name + "'" + did_you_mean(name, known),
              known.empty() ? "teach one: points.teach" : "there are: " + join(known, ", "));
}

/// A point or variable that a data file keeps.
const data::Value& kept_value(Cell& cell, const std::string& name) {
  const data::Value* value = cell.store().find(name);
  return value && !cell.store().set_of(name).empty() ? *value : place_of(cell, name);
}

void check_name(const std::string& name) {
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.' || c >= 0x80; };
  if (name.empty() || name.size() > 64 || std::isdigit(static_cast<unsigned char>(name[0])) ||
      !std::all_of(name.begin(), name.end(), good))
    throw Error("bad-name", "'" + name + "' is no name for a point", "letters, digits and _, a letter first");
}

/// The set that a change goes into: the one named, the one that has the name, or the one with most points.
std::string set_for(Cell& cell, const Json& arguments, const std::string& name) {
  const std::vector<std::string> sets = cell.files().sets();
  const std::string wanted = text_argument(arguments, "file", "");
  if (!wanted.empty()) {
    for (const std::string& set : sets)
      if (wanted == set || wanted == cell.files().file_of(set).filename()) return set;
    throw Error("unknown-file", "the cell has no data file '" + wanted + "'" + did_you_mean(wanted, sets),
                "there are: " + join(sets, ", "));
  }
  if (const std::string has = cell.store().set_of(name); !has.empty()) return has;
  std::string best;
  std::size_t most = 0;
  for (const std::string& set : sets) {
    std::size_t count = 0;
    for (const std::string& each : cell.store().names())
      count += cell.store().find(each)->is_place() && cell.store().set_of(each) == set ? 1 : 0;
    if (best.empty() || count > most) best = set, most = count;
  }
  if (best.empty())
    throw Error("no-set", "the cell has no data file that could keep a point",
                "a program that says 'load points' and a file points.points beside it");
  return best;
}

/// The user's own file of a set, whose copy the run works on.
fs::path own_file(Cell& cell, const std::string& set) {
  return cell.file().folder / cell.files().file_of(set).filename();
}

Json value_json(Cell& cell, const std::string& name);

/// A set before and after a change of its file.
struct Edited {
  data::DataSet before, after;
  std::string what;  // was taken back
};

/// Takes over into the running cell what has changed in a set's file.
void adopt(Cell& cell, const std::string& set, const Edited& edited) {
  for (const data::Entry& entry : edited.before.entries())
    if (!edited.after.find(entry.name)) cell.files().remove(set, entry.name);
  for (const data::Entry& entry : edited.after.entries()) {
    const data::Value* old = edited.before.value(entry.name);
    if (old && *old == entry.value) continue;
    cell.files().put(set, entry.name, entry.value, "a person");
  }
}

Poll edit(Cell& cell, const std::string& set, const std::string& what,
          std::function<void(ImportFile&)> change, std::function<Json(Cell&)> answer) {
  return later<Edited>(
      cell,
      [file = own_file(cell, set), what, change = std::move(change)] {
        Edited out;
        const ImportFile after = data::edit_set(file, what, [&](ImportFile& content) {
          out.before = content.values();
          change(content);
        });
        out.after = after.values();
        return out;
      },
      [set, what, answer = std::move(answer)](Cell& c, Edited& edited) {
        adopt(c, set, edited);
        Json out = answer(c);
        out["undo"] = what;
        return out;
      });
}

Poll edit_value(Cell& cell, const std::string& set, const std::string& what, const std::string& name,
                const data::Value& value) {
  data::check_can_keep(name, value, set);
  return edit(
      cell, set, what, [name, value](ImportFile& file) { file.set(name, value); },
      [name](Cell& c) { return value_json(c, name); });
}

std::vector<double> joints_now(Cell& cell, const CellRobot& robot) {
  std::vector<double> out;
  for (const controllers::JointFacts& joint : robot.joints) {
    const auto index = cell.loop().table().find_state(joint.name + "/position");
    out.push_back(index ? cell.snapshot().states[*index] : 0.0);
  }
  return out;
}

/// The pose of a frame in the world: a point, which may be in another.
Pose frame_in_world(Cell& cell, const std::string& frame, int depth = 0) {
  if (frame.empty() || frame == "world") return {};
  for (const auto& robot : cell.robots())
    if (frame == robot->entry.name + "/base") return robot->entry.base;
  if (depth > 16) throw Error("unknown-frame", "the frame '" + frame + "' is in itself");
  const data::Point* point = place_of(cell, frame).as_point();
  if (!point) throw Error("unknown-frame", "'" + frame + "' is a joint state, no frame");
  return frame_in_world(cell, point->frame(), depth + 1) * point->pose;
}

std::string file_name(Cell& cell, const std::string& set) {
  const std::vector<std::string> sets = cell.files().sets();
  return std::find(sets.begin(), sets.end(), set) == sets.end()
             ? ""
             : cell.files().file_of(set).filename().string();
}

Json value_json(Cell& cell, const std::string& name) {
  const data::Value& value = *cell.store().find(name);
  Json out{{"name", name},
           {"kind", kind_of(value)},
           {"file", file_name(cell, cell.store().set_of(name))},
           {"text", value.text()},
           {"literal", data::literal(value)},
           {"value", Json()},
           {"unit", ""},
           {"pose", Json()},
           {"world", Json()},
           {"joints", Json()},
           {"taught", Json()},
           {"group", ""}};
  if (const bool* flag = value.as_boolean()) out["value"] = *flag;
  if (const std::string* text = value.as_text()) out["value"] = *text;
  if (const data::Number* number = value.as_number()) {
    out["value"] = number->value;
    out["unit"] = data::unit_text(number->dimension);
  }
  if (const data::JointState* joints = value.as_joints()) out["joints"] = joints_json(*joints);
  const data::Point* point = value.as_point();
  if (!point) return out;
  out["pose"] = pose_json(point->pose);
  try {
    out["world"] = pose_json(frame_in_world(cell, point->frame()) * point->pose);
  } catch (const Error&) {  // its frame is not known to this cell
  }
  if (!point->taught) return out;
  out["taught"] = {
      {"frame", point->taught->frame}, {"tool", point->taught->tool}, {"robot", point->taught->robot}};
  if (!point->taught->joints.positions.empty()) out["joints"] = joints_json(point->taught->joints);
  return out;
}

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

Vec3 vector_value(const Json& list, const char* what) {
  const auto number = [](const Json& each) { return each.is_number() && std::isfinite(each.get<double>()); };
  if (!list.is_array() || list.size() != 3 || !std::all_of(list.begin(), list.end(), number))
    throw Error("bad-argument", std::string("'") + what + "' is " + list.dump() + ", not three numbers in m");
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

Vec3 place_argument(const Json& arguments, const char* name) {
  return vector_value(arguments.value(name, Json()), name);
}

/// {p: [x, y, z], q: [x, y, z, w]}
Pose pose_value(const Json& map) {
  const Json q = map.is_object() ? map.value("q", Json()) : Json();
  const auto number = [](const Json& each) { return each.is_number() && std::isfinite(each.get<double>()); };
  if (!q.is_array() || q.size() != 4 || !std::all_of(q.begin(), q.end(), number))
    throw Error("bad-argument", map.dump() + " is no pose", "{p: [x, y, z], q: [x, y, z, w]}");
  const Quaternion turn{q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>()};
  if (std::abs(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w - 1) > 1e-3)
    throw Error("bad-argument", "'q' is no unit quaternion x y z w");
  return {vector_value(map.value("p", Json()), "p"), normalized(turn)};
}

/// Where tool0 was when the point was taught, by its joints.
Pose flange_at(Cell& cell, const CellRobot& robot, const std::string& name) {
  const data::Value& value = place_of(cell, name);
  const data::JointState* joints = value.as_joints();
  if (!joints && value.as_point()->taught) joints = &value.as_point()->taught->joints;
  if (!joints || joints->positions.size() != robot.joints.size())
    throw Error("bad-points", "'" + name + "' does not say in which joints it was taught", "teach it again");
  return robot.facts->chain.forward(joints_by_name(robot.model, *joints, name)) * inverse(robot.tool.tcp);
}

/// {elbow_joint: 0.5, …}; joints that it does not name stay where they are.
std::vector<double> joints_of(Cell& cell, const CellRobot& robot, const Json& map) {
  std::vector<double> out = joints_now(cell, robot);
  if (!map.is_object()) throw Error("bad-argument", "'joints' is no map of joints and angles");
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints)
    names.push_back(joint.name.substr(joint.name.find('/') + 1));
  for (const auto& [key, value] : map.items()) {
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + key + "'" + did_you_mean(key, names));
    if (!value.is_number()) throw Error("bad-argument", "'" + key + "' is no number");
    out[static_cast<std::size_t>(found - names.begin())] = value.get<double>();
  }
  return out;
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

std::vector<Pose> poses_of(Cell& cell, const std::vector<std::string>& names, std::string& frame) {
  std::vector<Pose> out;
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell, each).as_point();
    if (!point) throw Error("bad-points", "'" + each + "' is a joint state", "teach it as a pose");
    if (!out.empty() && point->frame() != frame)
      throw Error("bad-points",
                  "'" + each + "' is in the frame '" + point->frame() + "', '" + names.front() + "' in '" +
                      frame + "'",
                  "teach all of them in one frame");
    frame = point->frame();
    out.push_back(point->pose);
  }
  return out;
}

}  // namespace

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
                  {"tcp", pose_json(tcp)},
                  {"flange", pose_json(tcp * inverse(robot.tool.tcp))},
                  {"joints", joints},
                  {"tool", robot.entry.tool}});
}

Poll points_teach(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_name(name);
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
  return edit_value(cell, set_for(cell, arguments, name), (old ? "touch up " : "teach ") + name, name, value);
}

Poll points_set(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_name(name);
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
  const std::string set = set_for(cell, arguments, names.front());
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell, each).as_point();
    if (!point) throw Error("bad-points", "'" + each + "' is a joint state, which has no place to shift");
    if (cell.store().set_of(each) != set)
      throw Error("bad-points", "'" + each + "' is in another file than '" + names.front() + "'",
                  "shift them apart");
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
  return edit(
      cell, set, "shift " + join(names, ", "),
      [shifted](ImportFile& file) {
        for (const auto& [name, value] : shifted) file.set(name, value);
      },
      [names](Cell& c) {
        Json out = Json::array();
        for (const std::string& each : names) out.push_back(value_json(c, each));
        return Json{{"values", out}};
      });
}

Poll points_rename(Cell& cell, const Json& arguments) {
  const std::string from = text_argument(arguments, "name"), to = text_argument(arguments, "to");
  check_name(to);
  const data::Value value = kept_value(cell, from);
  if (cell.store().find(to)) throw Error("in-use", "there is a '" + to + "' already", "give another name");
  auto uses = std::make_shared<Json>();
  return edit(
      cell, set_for(cell, Json::object(), from), "rename " + from + " to " + to,
      [from, to, value, uses, folder = cell.file().folder](ImportFile& file) {
        file = data::without(file, from);
        file.set(to, value);
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
  return edit(
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

Poll points_frame(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_name(name);
  std::array<Vec3, 3> at;
  std::string frame;
  if (const std::vector<std::string> from = list_argument(arguments, "from"); !from.empty()) {
    const std::vector<Pose> poses = poses_of(cell, from, frame);
    if (poses.size() != 3)
      throw Error("bad-points", "a frame comes from three points",
                  "'from': [origin, one on x, one in the xy plane]");
    for (std::size_t k = 0; k < 3; ++k) at[k] = poses[k].position;
  } else {
    at = {place_argument(arguments, "origin"), place_argument(arguments, "on_x"),
          place_argument(arguments, "in_plane")};
  }
  data::Point out{data::frame_from_points(at[0], at[1], at[2]), false};
  const Vec3 x = at[1] - at[0], y = at[2] - at[0];
  const Json found{
      {"name", name},        {"pose", pose_json(out.pose)},
      {"frame", frame},      {"x_length", norm(x)},
      {"y_length", norm(y)}, {"angle", std::acos(std::clamp(dot(x, y) / (norm(x) * norm(y)), -1.0, 1.0))}};
  if (!frame.empty()) out.taught = std::make_shared<data::Taught>(data::Taught{frame, {}, {}, {}});
  if (flag_argument(arguments, "dry")) return at_once(found);
  return then_with(edit_value(cell, set_for(cell, arguments, name), "frame " + name, name, out),
                   [found](Cell&, Json answer) {
                     answer.update(found);
                     return at_once(std::move(answer));
                   });
}

Poll points_tool(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_name(name);
  std::vector<Pose> poses;
  const std::vector<std::string> from = list_argument(arguments, "from");
  if (from.empty()) {
    const Json given = arguments.value("poses", Json::array());
    if (!given.is_array() || given.size() > 100) throw Error("bad-argument", "'poses' is no list of poses");
    for (const Json& each : given) poses.push_back(pose_value(each));
  } else {
    const CellRobot& robot = *cell.robots()[robot_argument(cell, arguments)];
    for (const std::string& each : from) poses.push_back(flange_at(cell, robot, each));
  }
  const data::TaughtTool tool = data::tool_from_poses(poses);
  const Json found{{"name", name},         {"tcp", vec(tool.tcp)},
                   {"tip", vec(tool.tip)}, {"residuals", tool.residuals},
                   {"rms", tool.rms},      {"largest", tool.largest}};
  if (flag_argument(arguments, "dry")) return at_once(found);
  return then_with(edit_value(cell, set_for(cell, arguments, name), "tool " + name, name,
                              data::Point{{tool.tcp, {}}, false}),
                   [found](Cell&, Json answer) {
                     answer.update(found);
                     return at_once(std::move(answer));
                   });
}

Poll plan_preview(Cell& cell, const Json& arguments) {
  constexpr int kSamples = 100;
  const std::size_t i = robot_argument(cell, arguments);
  const CellRobot& robot = *cell.robots()[i];
  const std::string how = text_argument(arguments, "kind", "joint");
  if (how != "joint" && how != "line")
    throw Error("bad-argument", "there is no way '" + how + "'", "joint or line");
  motion::Move move;
  move.kind = how == "line" ? motion::MoveKind::line : motion::MoveKind::joint;
  motion::MoveTarget target;
  target.name = text_argument(arguments, "to", "the target");
  if (arguments.contains("to")) {
    const data::Value& value = place_of(cell, target.name);
    if (const data::JointState* joints = value.as_joints())
      target.at = joints_by_name(robot.model, *joints, target.name);
    else
      target.at = frame_in_world(cell, value.as_point()->frame()) * value.as_point()->pose;
  } else if (arguments.contains("joints")) {
    target.at = joints_of(cell, robot, arguments["joints"]);
  } else {
    target.at = pose_value(arguments.value("pose", Json()));
  }
  move.targets.push_back(std::move(target));
  move.speed = std::clamp(number_argument(arguments, "speed", 1), 0.01, 1.0);
  // Facts and chain are const and stay for as long as the cell.
  return later<Json>(
      cell,
      [facts = robot.facts.get(), from = joints_now(cell, robot), move, options = cell.plan_options()] {
        const motion::MovePlan plan =
            motion::plan_moves(*facts, from, std::vector<motion::Move>{move}, options);
        Json path = Json::array();
        std::vector<double> q(from.size());
        for (const motion::PlannedMotion& each : plan.motions) {
          std::size_t hint = 0;
          for (int k = 0; k <= kSamples; ++k) {
            each.path.sample(each.path.duration() * k / kSamples, q, {}, {}, {}, hint);
            path.push_back(vec(facts->chain.forward(q).position));
          }
        }
        Json problems = Json::array();
        for (const auto& warning : plan.warnings) problems.push_back(warning.problem.text());
        Json joints = Json::object();
        for (std::size_t j = 0; j < plan.end.size(); ++j) joints[facts->chain.names()[j]] = plan.end[j];
        return Json{{"ok", true},          {"reason", ""},
                    {"path", path},        {"seconds", plan.duration()},
                    {"joints", joints},    {"pose", pose_json(facts->chain.forward(plan.end))},
                    {"warnings", problems}};
      },
      [robot = robot.entry.name](Cell&, Json& out) {
        out["robot"] = robot;
        return out;
      });
}

}  // namespace polyarm::cell
