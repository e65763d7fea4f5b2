#include "apps/calibrate_record.hpp"

#include <fmt/format.h>

#include <iostream>
#include <map>

#include "apps/client.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

Pose pose_of(const Json& facts) {
  const Json &p = part(facts, {"p"}), &q = part(facts, {"q"});
  if (!p.is_array() || p.size() != 3 || !q.is_array() || q.size() != 4)
    throw Error("bad-answer", "the cell gave no pose", "use a cell of the same version");
  return {{number_of(p[0]), number_of(p[1]), number_of(p[2])},
          {number_of(q[0]), number_of(q[1]), number_of(q[2]), number_of(q[3])}};
}

Vec3 vector_of(const Json& list) {
  if (!list.is_array() || list.size() != 3)
    throw Error("bad-answer", "the cell gave no vector", "use a cell of the same version");
  return {number_of(list[0]), number_of(list[1]), number_of(list[2])};
}

std::map<std::string, double> by_joint(const Json& map) {
  std::map<std::string, double> out;
  for (const auto& [joint, value] : map.items()) out[joint] = number_of(value);
  return out;
}

std::optional<Vec3> typed_place() {
  fmt::print(stderr, "its known coordinates x y z in m: ");
  std::string line;
  if (!std::getline(std::cin, line)) return std::nullopt;
  const std::vector<std::string> words = split_words(line, " ,\t\r");
  if (words.size() != 3)
    throw Error("bad-value", "'" + line + "' is not three numbers", "for example 0.1 0 0.05");
  Vec3 out;
  double* const at[] = {&out.x, &out.y, &out.z};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto number = parse_number(words[k]);
    if (!number) throw Error("bad-value", "'" + words[k] + "' is not a number", "for example 0.1 0 0.05");
    *at[k] = *number;
  }
  return out;
}

Json asking(const RecordOptions& options, const char* request) {
  Json out{{"request", request}};
  if (!options.robot.empty()) out["robot"] = options.robot;
  return out;
}

/// The pair of one moment: the robot and the marker.
Json sighting(Client& cell, const RecordOptions& options) {
  if (options.marker.empty())
    throw Error("bad-usage", "a camera or a measuring device needs the pose that it writes",
                "--marker NAME: a pose of the cell's data");
  Json request = asking(options, "points.sighting");
  request["marker"] = options.marker;
  const Json out = cell.ask(request);
  if (const double age = number_of(part(out, {"age"})); age > 5)
    fmt::print(stderr, "warning: '{}' has not changed for {:.0f} s; does the camera see the marker?\n",
               options.marker, age);
  return out;
}

/// What the hand carries, felt by the sensor at the wrist, or else by the joints.
void weigh(Client& cell, const RecordOptions& options, calibration::Sample& out) {
  Json request = asking(options, "calibrate.sample");
  request["forces"] = true;
  const Json felt = cell.ask(request);
  if (felt.contains("force")) {
    out.poses["flange"] = pose_of(part(felt, {"flange"}));
    out.vectors["force"] = vector_of(part(felt, {"force"}));
    out.vectors["torque"] = vector_of(part(felt, {"torque"}));
  } else {
    out.joints["q"] = by_joint(part(felt, {"joints"}));
    out.joints["tau"] = by_joint(part(felt, {"torques"}));
  }
}

std::optional<calibration::Sample> sample_now(Client& cell, RecordOptions& options) {
  calibration::Sample out;
  const Json state = cell.ask(asking(options, "jog.state"));
  if (flag_of(part(state, {"moving"}))) throw Error("moving", "the robot moves", "wait until it is at rest");
  const Json here = cell.ask(asking(options, "points.here"));
  options.robot = text_of(part(here, {"robot"}));
  if (options.kind == "tool") {
    out.poses["flange"] = pose_of(part(here, {"flange"}));
  } else if (options.kind == "frame" || options.kind == "robots") {
    out.vectors["point"] = pose_of(part(here, {"tcp"})).position;
    const auto known = typed_place();
    if (!known) return std::nullopt;
    out.vectors["known"] = *known;
  } else if (options.kind == "joints") {
    out.joints["q"] = by_joint(part(here, {"joints"}));
    out.poses["measured"] = pose_of(part(sighting(cell, options), {"marker"}));
  } else if (options.kind == "hand-eye" || options.kind == "eye-to-hand") {
    const Json pair = sighting(cell, options);
    out.poses["flange"] = pose_of(part(pair, {"flange"}));
    out.poses["marker"] = pose_of(part(pair, {"marker"}));
  } else if (options.kind == "payload") {
    weigh(cell, options, out);
  } else {
    throw Error("bad-usage", "samples of a " + options.kind + " cannot be taken from a cell",
                "give a file of samples");
  }
  return out;
}

}  // namespace

std::vector<calibration::Sample> record_samples(RecordOptions& options) {
  Client cell(options.cell);
  std::vector<calibration::Sample> out;
  fmt::print(stderr, "Move the robot, wait until it is at rest, and press Enter; Ctrl-D ends.\n");
  for (std::string line; std::getline(std::cin, line);) {
    try {
      auto one = sample_now(cell, options);
      if (!one) break;
      out.push_back(std::move(*one));
      fmt::print(stderr, "sample {}\n", out.size());
    } catch (const Error& e) {
      if (e.problems().front().code == "cell-gone" || e.problems().front().code == "bad-usage") throw;
      fmt::print(stderr, "{}\n", e.what());
    }
  }
  return out;
}

}  // namespace polyarm::apps
