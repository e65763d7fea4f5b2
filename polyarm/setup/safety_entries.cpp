#include "polyarm/setup/safety_entries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {

void read_profile(const Yaml& yaml, ProfileEntry& out, Problems& problems) {
  if (!yaml.defined()) return;
  yaml.check_keys({"tcp_speed", "tcp_turning", "joint_speed", "while"}, problems);
  if (yaml.has("while")) {
    collect(problems, [&] { out.tag = yaml["while"].text(); });
    out.tag_place = yaml["while"].where();
  }
  const auto read = [&](const char* key, Dimension dimension, double& value, double most, const char* what) {
    if (!yaml.has(key)) return;
    collect(problems, [&] {
      const double given = yaml[key].number(dimension);
      if (!(given > 0 && given <= most))
        throw Error(
            Problem{"bad-value", yaml[key].where(), std::string(key) + " is " + format_number(given), what});
      value = given;
    });
  };
  read("tcp_speed", Dimension::speed, out.tcp_speed, 1e6, "a speed above zero, such as 250mm/s");
  read("tcp_turning", Dimension::angular_speed, out.tcp_turning, 1e3,
       "an angular speed above zero, such as 30deg/s");
  read("joint_speed", Dimension::none, out.joint_speed, 1,
       "a share of the joints' limits, above 0 and at most 1 (100%)");
}

RangeEntry read_range(const std::string& joint, const Yaml& yaml) {
  const std::vector<Yaml> ends = yaml.items();
  if (ends.size() != 2)
    throw Error(Problem{"bad-value", yaml.where(), "the range of '" + joint + "' has no two ends",
                        "[-90deg, 90deg]; of a joint that slides [0mm, 100mm]"});
  const auto end = [](const Yaml& value) {
    if (const auto angle = parse_quantity(value.text(), Dimension::angle)) return *angle;
    return value.number(Dimension::length);
  };
  const RangeEntry out{joint, end(ends[0]), end(ends[1]), yaml.where()};
  if (!(out.lower < out.upper))
    throw Error(
        Problem{"bad-value", yaml.where(),
                fmt::format("the range of '{}' is empty: {:.6g} to {:.6g}", joint, out.lower, out.upper),
                "the lower end comes first"});
  return out;
}

/// An axis of the tool: x, y, z, or -x, -y, -z.
Vec3 axis_of(const Yaml& yaml) {
  const std::string text = yaml.text();
  const double sign = text.starts_with("-") ? -1 : 1;
  const std::string name = sign < 0 ? text.substr(1) : text;
  if (name == "x") return {sign, 0, 0};
  if (name == "y") return {0, sign, 0};
  if (name == "z") return {0, 0, sign};
  throw Error(
      Problem{"bad-value", yaml.where(), "the tool has no axis '" + text + "'", "x, y, z, -x, -y or -z"});
}

moves::WorkspaceZone read_zone(const std::string& name, const Yaml& yaml, Problems& problems) {
  moves::WorkspaceZone out;
  out.name = name;
  out.where = yaml.where();
  yaml.check_keys({"plane", "normal", "inside", "outside", "of", "cone", "within", "axis", "joint", "range",
                   "profile", "beyond"},
                  problems);
  if (yaml.has("beyond")) {
    out.slows = yaml["beyond"].text() == "reduced";
    if (!out.slows || yaml.has("of") || yaml.has("profile") || yaml.has("joint"))
      throw Error(Problem{
          "bad-value", yaml["beyond"].where(), "the zone '" + name + "' has beyond: " + yaml["beyond"].text(),
          "`beyond: reduced` of a plane, a box or a cone, without 'of' and 'profile': beyond the "
          "boundary the cell has the reduced profile"});
  }
  if (yaml.has("profile")) {
    const std::string profile = yaml["profile"].text();
    out.profile = profile == "reduced" ? moves::ZoneProfile::reduced : moves::ZoneProfile::full;
    if (profile != "reduced" && profile != "full")
      throw Error(Problem{"bad-value", yaml["profile"].where(),
                          "the zone '" + name + "' is of the profile '" + profile + "'",
                          "reduced or full; without it the zone counts in both"});
  }
  if (yaml.has("of")) {
    const std::string of = yaml["of"].text();
    out.bodies = of == "bodies";
    if (!out.bodies && of != "tcp")
      throw Error(Problem{"bad-value", yaml["of"].where(), "the zone '" + name + "' is of '" + of + "'",
                          "tcp: of the TCP alone; bodies: also of the links, the tool and what it holds"});
  }
  const int kinds =
      yaml.has("plane") + yaml.has("inside") + yaml.has("outside") + yaml.has("cone") + yaml.has("joint");
  if (kinds != 1)
    throw Error(Problem{"bad-value", out.where,
                        "the zone '" + name + "' has " + (kinds == 0 ? "none" : "more than one") +
                            " of plane, inside, outside, cone and joint",
                        "{plane: [x, y, z], normal: [0, 0, 1]}, {inside: [[x, y, z], [x, y, z]]}, "
                        "{cone: [0, 0, -1], within: 15deg} or {joint: NAME, range: [-90deg, 90deg]}"});
  if (out.bodies && (yaml.has("cone") || yaml.has("joint")))
    throw Error(Problem{"bad-value", yaml["of"].where(), "the zone '" + name + "' is of bodies",
                        "a cone and a range have no 'of'"});
  if (yaml.has("cone")) {
    out.kind = moves::ZoneKind::cone;
    out.normal = yaml["cone"].vec3(Dimension::none);
    out.within = yaml.required("within").number(Dimension::angle);
    if (yaml.has("axis")) out.axis = axis_of(yaml["axis"]);
    return out;
  }
  if (yaml.has("joint")) {
    out.kind = moves::ZoneKind::range;
    out.joint = yaml["joint"].text();
    const RangeEntry range = read_range(out.joint, yaml.required("range"));
    out.lower = range.lower;
    out.upper = range.upper;
    return out;
  }
  if (yaml.has("plane")) {
    out.point = yaml["plane"].vec3();
    out.normal = yaml.required("normal").vec3(Dimension::none);
    return out;
  }
  const char* key = yaml.has("inside") ? "inside" : "outside";
  out.kind = yaml.has("inside") ? moves::ZoneKind::inside : moves::ZoneKind::outside;
  const std::vector<Yaml> corners = yaml[key].items();
  if (corners.size() != 2)
    throw Error(Problem{"bad-value", yaml[key].where(), "a box has two corners",
                        "[[low x, y, z], [high x, y, z]], m in the world"});
  out.low = corners[0].vec3();
  out.high = corners[1].vec3();
  return out;
}

}  // namespace

control::ContactStop read_contact_stop(const Yaml& yaml, Problems& problems) {
  using control::ContactStop;
  if (!yaml.defined()) return ContactStop::path;
  yaml.check_keys({"stop", "clearance"}, problems);
  std::string stop = "1";
  collect(problems, [&] { stop = yaml["stop"].text("1"); });
  if (stop != "0" && stop != "1")
    problems.error("bad-value", yaml["stop"].where(), "contacts: stop is '" + stop + "'",
                   "1: on the path, as hard as the joints can; 0: each joint at once, the path is left");
  return stop == "0" ? ContactStop::cut : ContactStop::path;
}

double read_clearance(const Yaml& yaml, Problems& problems) {
  double out = kClearance;
  if (!yaml.has("clearance")) return out;
  collect(problems, [&] { out = yaml["clearance"].number(Dimension::length); });
  if (!(out >= 0) || out > kMostClearance)
    problems.error("bad-value", yaml["clearance"].where(), "clearance is " + yaml["clearance"].text(),
                   "a distance from 0 to 1 m, such as 5mm");
  return out;
}

GuardsEntry read_guards(const Yaml& yaml, double clearance_of_contacts, Problems& problems) {
  GuardsEntry out;
  out.clearance = std::min(out.clearance, clearance_of_contacts);
  if (!yaml.defined()) return out;
  if (!yaml.is_map()) {
    const std::string text = yaml.text();
    out.on = text == "on" || text == "true";
    if (!out.on && text != "off" && text != "false")
      problems.error("bad-value", yaml.where(), "guards is '" + text + "'",
                     "off, on, or {clearance: 5mm, moves: true, slow_from: 60mm, others: false}");
    return out;
  }
  yaml.check_keys({"clearance", "moves", "slow_from", "others", "bases"}, problems);
  const auto length = [&](const char* key, double& value) {
    if (!yaml.has(key)) return;
    collect(problems, [&] { value = yaml[key].number(Dimension::length); });
    if (!(value >= 0) || value > kMostClearance)
      problems.error("bad-value", yaml[key].where(), std::string(key) + " is " + yaml[key].text(),
                     "a distance from 0 to 1 m, such as 5mm");
  };
  length("clearance", out.clearance);
  length("slow_from", out.slow_from);
  collect(problems, [&] { out.moves = yaml["moves"].boolean(true); });
  collect(problems, [&] { out.others = yaml["others"].boolean(false); });
  collect(problems, [&] { out.bases = yaml["bases"].boolean(true); });
  return out;
}

ProfileEntries read_profiles(const Yaml& cell, Problems& problems) {
  ProfileEntries out;
  const std::vector<std::string> known = {"reduced", "full"};
  collect(problems, [&] { out.name = cell["profile"].text("full"); });
  if (std::find(known.begin(), known.end(), out.name) == known.end())
    problems.error("bad-value", cell["profile"].where(),
                   "the profile is '" + out.name + "'" + did_you_mean(out.name, known), "reduced or full");
  if (!cell.has("profiles")) return out;
  cell["profiles"].check_keys(known, problems);
  read_profile(cell["profiles"]["reduced"], out.reduced, problems);
  read_profile(cell["profiles"]["full"], out.full, problems);
  if (!out.full.tag.empty())
    problems.error("bad-value", out.full.tag_place, "'while' is for the reduced profile",
                   "reduced: {while: TAG}; without it the profile is the one that is asked for");
  return out;
}

std::vector<moves::WorkspaceZone> read_workspace(const Yaml& yaml, Problems& problems) {
  std::vector<moves::WorkspaceZone> out;
  for (const std::string& name : yaml.keys())
    collect(problems, [&] {
      const moves::WorkspaceZone zone = read_zone(name, yaml[name], problems);
      const moves::Workspace checked({zone});
      out.push_back(zone);
    });
  return out;
}

std::vector<moves::WorkspaceZone> take_slow_zones(std::vector<moves::WorkspaceZone>& zones) {
  std::vector<moves::WorkspaceZone> out;
  for (const moves::WorkspaceZone& zone : zones)
    if (zone.slows) out.push_back(zone);
  std::erase_if(zones, [](const moves::WorkspaceZone& zone) { return zone.slows; });
  return out;
}

PayloadEntry read_payload(const Yaml& yaml, Problems& problems) {
  PayloadEntry out;
  if (!yaml.defined()) return out;
  collect(problems, [&] {
    if (yaml.is_map()) yaml.check_keys({"mass", "center"}, problems);
    out.mass = (yaml.is_map() ? yaml.required("mass") : yaml).number(Dimension::mass);
    if (!(out.mass >= 0 && std::isfinite(out.mass)))
      throw Error(Problem{"bad-value", yaml.where(), fmt::format("the payload is {:.6g} kg", out.mass),
                          "2kg, or {mass: 2kg, center: [0, 0, 80mm]} with its centre of gravity in tool0"});
    if (yaml.is_map() && yaml.has("center")) out.center = yaml["center"].vec3();
  });
  return out;
}

std::vector<RangeEntry> read_ranges(const Yaml& yaml, Problems& problems) {
  std::vector<RangeEntry> out;
  for (const std::string& joint : yaml.keys())
    collect(problems, [&] { out.push_back(read_range(joint, yaml[joint])); });
  return out;
}

void find_joints(std::vector<moves::WorkspaceZone>& zones, const description::RobotModel& model,
                 Problems& problems) {
  const std::vector<std::string> names = model.joint_names();
  for (moves::WorkspaceZone& zone : zones) {
    if (zone.kind != moves::ZoneKind::range) continue;
    const auto found = std::find(names.begin(), names.end(), zone.joint);
    if (found == names.end())
      problems.error("unknown-joint", zone.where,
                     "the zone '" + zone.name + "': " + model.name + " has no joint '" + zone.joint + "'" +
                         did_you_mean(zone.joint, names),
                     "it has: " + join(names, ", ") +
                         "; a zone of one robot belongs into the 'workspace' of that robot");
    else
      zone.index = static_cast<int>(found - names.begin());
  }
}

std::vector<CollisionTorqueEntry> read_collision_torques(const Yaml& yaml, Problems& problems) {
  std::vector<CollisionTorqueEntry> out;
  if (!yaml.defined()) return out;
  const auto read = [&](const std::string& joint, const Yaml& value) {
    collect(problems, [&] {
      const auto force = parse_quantity(value.text(), Dimension::force);
      const double limit = force ? *force : value.number(Dimension::torque);
      if (!(limit > 0) || !std::isfinite(limit))
        throw Error(Problem{"bad-value", value.where(), "collision_torque is not above 0",
                            "write such as 30Nm; for a joint that slides 100N"});
      out.push_back({joint, limit, value.where()});
    });
  };
  if (!yaml.is_map()) read({}, yaml);
  for (const std::string& joint : yaml.keys()) read(joint, yaml[joint]);
  return out;
}

void check_collision_torques(const std::vector<CollisionTorqueEntry>& torques,
                             const description::RobotModel& model, Problems& problems) {
  const std::vector<std::string> names = model.joint_names();
  for (const CollisionTorqueEntry& each : torques)
    if (!each.joint.empty() && std::find(names.begin(), names.end(), each.joint) == names.end())
      problems.error("unknown-joint", each.where,
                     "the robot has no joint '" + each.joint + "'" + did_you_mean(each.joint, names),
                     "its joints are " + join(names, ", "));
}

void narrow_ranges(const std::vector<RangeEntry>& ranges, description::RobotModel& model,
                   Problems& problems) {
  const std::vector<std::string> names = model.joint_names();
  for (const RangeEntry& range : ranges) {
    const auto found = std::find(names.begin(), names.end(), range.joint);
    if (found == names.end()) {
      problems.error("unknown-joint", range.where,
                     model.name + " has no joint '" + range.joint + "'" + did_you_mean(range.joint, names),
                     "it has: " + join(names, ", "));
      continue;
    }
    description::Joint& joint = model.joints[static_cast<std::size_t>(
        model.actuated[static_cast<std::size_t>(found - names.begin())])];
    const bool free = joint.type == description::JointType::continuous;
    const double lower = free ? -1e300 : joint.limits.lower.value_or(-1e300);
    const double upper = free ? 1e300 : joint.limits.upper.value_or(1e300);
    constexpr double kRounding = 1e-9;
    if (range.lower < lower - kRounding || range.upper > upper + kRounding) {
      problems.error("bad-range", range.where,
                     fmt::format("the range of '{}', {:.4f} to {:.4f}, is wider than the robot's own",
                                 range.joint, range.lower, range.upper),
                     fmt::format("stay within {:.4f} to {:.4f}", lower, upper));
      continue;
    }
    if (free) joint.type = description::JointType::revolute;
    joint.limits.lower = std::max(range.lower, lower);
    joint.limits.upper = std::min(range.upper, upper);
  }
}

}  // namespace polyarm::cell
