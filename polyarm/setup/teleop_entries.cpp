#include "polyarm/setup/teleop_entries.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "polyarm/base/printable.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {
using teleop::Clutch;
using teleop::HandRange;
using teleop::Mapping;
using teleop::PairSettings;

constexpr std::size_t kMostPairs = 16;
constexpr double kMostScale = 100;

std::string robot_of(const Yaml& pair, const char* key, const std::vector<std::string>& robots) {
  const Yaml value = pair.required(key);
  const std::string name = value.text();
  if (std::find(robots.begin(), robots.end(), name) == robots.end())
    throw Error(Problem{"unknown-robot", value.where(),
                        "the cell has no robot '" + name + "'" + did_you_mean(name, robots),
                        "it has: " + join(robots, ", ")});
  return name;
}

/// One of these words, as its place in the list.
std::size_t word_of(const Yaml& value, const std::string& key, const std::vector<std::string>& words) {
  const std::string given = value.text(words.front());
  const auto found = std::find(words.begin(), words.end(), given);
  if (found == words.end())
    throw Error(Problem{"bad-value", value.where(),
                        key + " is '" + shortened(given) + "'" + did_you_mean(given, words),
                        join(words, " or ")});
  return static_cast<std::size_t>(found - words.begin());
}

double factor(const Yaml& value, const char* key, double fallback, double lowest, double most) {
  const double out = value.number(Dimension::none, fallback);
  if (!(out >= lowest && out <= most) || out == 0)
    throw Error(Problem{"bad-value", value.where(), std::string(key) + " is " + format_number(out),
                        "a number from " + format_number(lowest) + " to " + format_number(most) +
                            (lowest < 0 ? ", not 0" : "")});
  return out;
}

/// rad, or m if written as a length.
double angle_or_length(const Yaml& value) {
  if (const auto length = parse_quantity(value.text(), Dimension::angle)) return *length;
  return value.number(Dimension::length);
}

HandRange read_hand(const Yaml& yaml) {
  HandRange out;
  out.joint = yaml.required("joint").text();
  out.closed = angle_or_length(yaml.required("closed"));
  out.open = angle_or_length(yaml.required("open"));
  constexpr double kLeast = 1e-3;
  if (!(std::abs(out.open - out.closed) >= kLeast))
    throw Error(Problem{"bad-value", yaml.where(), "'closed' and 'open' of '" + out.joint + "' are the same",
                        "two positions of the joint, such as closed: 0deg, open: 60deg"});
  return out;
}

void read_clutch(const Yaml& yaml, PairSettings& out, Problems& problems) {
  if (!yaml.is_map()) {
    word_of(yaml, "clutch", {"key"});
    return;
  }
  yaml.check_keys({"tag", "joint", "closed", "open"}, problems);
  if (yaml.has("tag") == yaml.has("joint"))
    throw Error(Problem{"bad-value", yaml.where(), "a clutch is one of: a tag, a joint of the leader",
                        "{tag: Pedal}, or {joint: gripper, closed: 0deg, open: 60deg}"});
  out.clutch = yaml.has("tag") ? Clutch::tag : Clutch::gripper;
  if (out.clutch == Clutch::tag)
    out.tag = yaml["tag"].text();
  else
    out.hand = read_hand(yaml);
}

void read_joints(const Yaml& yaml, PairSettings& out, Problems& problems) {
  for (const std::string& follower : yaml.keys())
    collect(problems, [&] {
      const Yaml entry = yaml[follower];
      teleop::JointPair pair;
      pair.follower = follower;
      if (entry.is_map()) {
        entry.check_keys({"joint", "scale", "offset"}, problems);
        pair.leader = entry.required("joint").text();
        pair.scale = factor(entry["scale"], "scale", 1, -kMostScale, kMostScale);
        if (entry.has("offset")) pair.offset = angle_or_length(entry["offset"]);
      } else {
        pair.leader = entry.text();
      }
      out.joints.push_back(std::move(pair));
    });
}

PairSettings read_pair(const std::string& name, const Yaml& yaml, const std::vector<std::string>& robots,
                       Problems& problems) {
  PairSettings out;
  out.name = name;
  out.where = yaml.where();
  yaml.check_keys({"leader", "follower", "mapping", "joints", "match", "approach", "scale", "orientation",
                   "turn", "speed", "clutch", "gripper"},
                  problems);
  collect(problems, [&] { out.leader = robot_of(yaml, "leader", robots); });
  collect(problems, [&] { out.follower = robot_of(yaml, "follower", robots); });
  if (!out.leader.empty() && out.leader == out.follower)
    problems.error("bad-value", yaml["follower"].where(), "'" + out.leader + "' leads itself",
                   "a follower is another robot");
  collect(problems, [&] {
    out.mapping = static_cast<Mapping>(word_of(yaml["mapping"], "mapping", {"joints", "tcp"}));
  });
  read_joints(yaml["joints"], out, problems);
  const bool tcp = out.mapping == Mapping::tcp;
  for (const char* key : {"joints", "match", "approach"})
    if (tcp && yaml.has(key))
      problems.error("bad-value", yaml[key].where(), std::string(key) + " has no meaning with mapping: tcp",
                     "remove it");
  for (const char* key : {"scale", "orientation", "turn"})
    if (!tcp && yaml.has(key))
      problems.error("bad-value", yaml[key].where(),
                     std::string(key) + " has no meaning with mapping: joints", "remove it");
  collect(problems, [&] { out.relative = word_of(yaml["match"], "match", {"approach", "relative"}) == 1; });
  collect(problems, [&] { out.approach = factor(yaml["approach"], "approach", 0.1, 0.01, 1); });
  collect(problems, [&] { out.scale = factor(yaml["scale"], "scale", 1, 0.01, kMostScale); });
  collect(problems, [&] { out.speed = factor(yaml["speed"], "speed", 1, 0.01, 1); });
  collect(problems, [&] { out.orientation = yaml["orientation"].boolean(true); });
  collect(problems, [&] {
    if (!yaml.has("turn")) return;
    const Vec3 rpy = yaml["turn"].vec3(Dimension::angle);
    out.turn = from_rpy(rpy.x, rpy.y, rpy.z);
  });
  collect(problems, [&] {
    if (yaml.has("clutch")) read_clutch(yaml["clutch"], out, problems);
  });
  collect(problems, [&] {
    const Yaml gripper = yaml["gripper"];
    if (!gripper.defined()) return;
    gripper.check_keys({"joint", "closed", "open", "tag"}, problems);
    out.grip = teleop::GripperLink{read_hand(gripper), gripper.required("tag").text()};
  });
  return out;
}
}  // namespace

std::vector<PairSettings> read_teleop(const Yaml& yaml, const std::vector<std::string>& robots,
                                      Problems& problems) {
  std::vector<PairSettings> out;
  if (!yaml.defined()) return out;
  if (yaml.keys().size() > kMostPairs)
    throw Error(Problem{"too-many", yaml.where(), "teleop has more than 16 pairs", "divide the cell"});
  for (const std::string& name : yaml.keys())
    collect(problems, [&] { out.push_back(read_pair(name, yaml[name], robots, problems)); });
  for (std::size_t a = 0; a < out.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (!out[a].follower.empty() && out[a].follower == out[b].follower)
        problems.error(
            "bad-value", out[a].where,
            "'" + out[a].follower + "' follows in '" + out[b].name + "' and in '" + out[a].name + "'",
            "a robot has one leader");
  return out;
}

}  // namespace polyarm::cell
