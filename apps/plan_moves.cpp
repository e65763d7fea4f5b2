#include "apps/plan_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/tasks/program_host.hpp"

namespace polyarm::apps {

using moves::Move;
using moves::MoveKind;
using moves::MoveTarget;

namespace {

struct KindWord {
  const char* text;
  MoveKind kind;
};
constexpr KindWord kKinds[] = {{"movej", MoveKind::joint},  {"joint", MoveKind::joint},
                               {"movel", MoveKind::line},   {"line", MoveKind::line},
                               {"movec", MoveKind::arc},    {"arc", MoveKind::arc},
                               {"spline", MoveKind::spline}};

std::optional<MoveKind> kind_of(const std::string& word) {
  for (const KindWord& k : kKinds)
    if (word == k.text) return k.kind;
  return std::nullopt;
}

[[noreturn]] void refuse(const std::string& word, const std::string& why, const std::string& advice) {
  throw Error("bad-move", fmt::format("'{}' {}", word, why), advice);
}

/// Refuses a number without a unit that is far too large for a robot, and suggests a unit.
void refuse_without_unit(const std::string& text, Dimension dimension, const std::string& whole) {
  constexpr double kMostMetres = 10, kMostRadians = 15;
  const bool length = dimension == Dimension::length;
  const auto bare = parse_number(text);
  if (!bare || (!length && dimension != Dimension::angle)) return;
  if (std::abs(*bare) <= (length ? kMostMetres : kMostRadians)) return;
  std::string mended = whole;
  for (auto at = mended.find(text); at != std::string::npos; at = mended.find(text, at + text.size())) {
    const auto separates = [&](std::size_t i) {
      return i >= mended.size() || std::string_view("(), =").find(mended[i]) != std::string_view::npos;
    };
    if (at > 0 && separates(at - 1) && separates(at + text.size()))
      mended.insert(at + text.size(), length ? "mm" : "deg");
  }
  throw Error("bad-value",
              fmt::format("'{}' in {} has no unit, and would be {} {}", text, whole, text,
                          length ? "metres" : "radians"),
              fmt::format("{} needs a unit: write {}", name(dimension), mended));
}

double quantity(const std::string& text, Dimension dimension, const std::string& whole) {
  refuse_without_unit(text, dimension, whole);
  if (const auto value = parse_quantity(text, dimension)) return *value;
  throw Error("bad-value", fmt::format("'{}' in {} is not {}", text, whole, name(dimension)),
              dimension == Dimension::length ? "write metres, or a unit: 0.3 or 300mm"
                                             : "write radians, or a unit: 1.57 or 90deg");
}

PaceValue pace(const std::string& text, const std::string& option, Dimension tcp, Dimension angular,
               const char* advice) {
  PaceValue out;
  if (text.empty()) return out;
  const auto positive = [&](double v) {
    if (v > 0 && std::isfinite(v)) return v;
    throw Error("bad-value", fmt::format("{} is '{}'", option, text), "it must be above zero");
  };
  if (const auto share = parse_quantity(text, Dimension::none)) {
    out.share = positive(*share);
    if (out.share > 1)
      throw Error("bad-value", fmt::format("{} is '{}', more than the limits", option, text), advice);
  } else if (const auto metres = parse_quantity(text, tcp)) {
    out.tcp = positive(*metres);
  } else if (const auto turn = parse_quantity(text, angular)) {
    out.angular = positive(*turn);
  } else {
    throw Error("bad-value", fmt::format("{} cannot be '{}'", option, text), advice);
  }
  return out;
}

/// "pose(0.3, 0, 90deg)", split into its name and arguments.
struct Call {
  std::string word;
  std::vector<std::string> arguments;
};
std::optional<Call> call_of(const std::string& text) {
  const auto open = text.find('(');
  if (open == std::string::npos) return std::nullopt;
  if (text.back() != ')') refuse(text, "has no closing bracket", "put it in quotes if it has spaces");
  std::string inside = text.substr(open + 1, text.size() - open - 2);
  std::replace(inside.begin(), inside.end(), ' ', ',');
  return Call{text.substr(0, open), split_words(inside, ",")};
}

constexpr const char* kJointsAdvice = "joint values are one word: movej 'joints(0, -90deg, …)'";

class Reader {
 public:
  Reader(const NamedPlaces& places, const std::vector<double>& from, const PaceWords& all)
      : places_(places), all_(all), here_(places.robot.chain.forward(from)) {}

  std::vector<Move> read(const std::vector<std::string>& words) {
    std::size_t i = 0;
    while (i < words.size()) {
      const auto kind = kind_of(words[i]);
      if (!kind)
        refuse(words[i], "begins no move",
               parse_number(words[i]) ? kJointsAdvice
                                      : "moves are movej, movel, movec VIA END and spline P1 P2 …");
      out_.emplace_back();
      out_.back().kind = *kind;
      set("speed", all_.speed), set("acceleration", all_.acceleration), set("blend", all_.blend);
      const std::string& word = words[i++];
      while (i < words.size() && !kind_of(words[i])) take(words[i++]);
      check_targets(word);
    }
    return std::move(out_);
  }

 private:
  void take(const std::string& word) {
    const auto equals = word.find('=');
    if (equals != std::string::npos && word.find('(') == std::string::npos)
      set(word.substr(0, equals), word.substr(equals + 1));
    else
      out_.back().targets.push_back(target(word));
  }
  void check_targets(const std::string& word) const {
    const Move& m = out_.back();
    const std::size_t n = m.targets.size();
    const bool right = m.kind == MoveKind::arc ? n == 2 : m.kind == MoveKind::spline ? n >= 1 : n == 1;
    if (right) return;
    refuse(word, fmt::format("has {} target{}", n, n == 1 ? "" : "s"),
           m.kind == MoveKind::arc ? "an arc takes a point on the way and its end: movec Via End"
           : n == 0                ? "add a target: " + word + " Pick"
                                   : "one each: " + word + " A " + word + " B");
  }

  void set(const std::string& key, const std::string& text) {
    if (text.empty()) return;
    Move& m = out_.back();
    const bool joint = m.kind == MoveKind::joint;
    if (key == "speed") {
      const PaceValue v = parse_speed(text, key);
      m.speed = v.share, m.tcp_speed = v.tcp;
      (joint ? m.joint_speed : m.turn_speed) = v.angular;
    } else if (key == "acceleration") {
      const PaceValue v = parse_acceleration(text, key);
      m.acceleration = v.share, m.tcp_acceleration = v.tcp;
      (joint ? m.joint_acceleration : m.turn_acceleration) = v.angular;
    } else if (key == "blend") {
      m.blend = quantity(text, Dimension::length, "blend=" + text);
    } else if (key == "duration") {
      m.duration = quantity(text, Dimension::time, "duration=" + text);
    } else if (key == "orientation") {
      m.orientation = orientation(text);
    } else {
      const std::vector<std::string> known{"speed", "acceleration", "blend", "duration", "orientation"};
      refuse(key + "=", "is not an option of a move" + did_you_mean(key, known), join(known, "=, ") + "=");
    }
  }
  static paths::ArcOrientation orientation(const std::string& text) {
    if (text == "fixed") return paths::ArcOrientation::fixed;
    if (text == "tangent") return paths::ArcOrientation::tangent;
    if (text == "interpolated") return paths::ArcOrientation::interpolated;
    refuse("orientation=" + text, "is not possible for an arc", "fixed, tangent or interpolated");
  }

  MoveTarget target(const std::string& word) {
    const auto call = call_of(word);
    MoveTarget out = call ? inline_target(*call, word) : named(word);
    if (const Pose* pose = std::get_if<Pose>(&out.at))
      here_ = *pose;
    else if (const auto& q = std::get<std::vector<double>>(out.at); q.size() == places_.robot.chain.joints())
      here_ = places_.robot.chain.forward(q);
    return out;
  }
  MoveTarget inline_target(const Call& call, const std::string& word) const {
    if (call.word == "joints") return {joints(call, word), word};
    const auto at = [&](std::size_t i) { return quantity(call.arguments[i], Dimension::length, word); };
    const std::size_t n = call.arguments.size();
    if (call.word == "pose" && (n == 3 || n == 6 || n == 7)) {
      Pose pose{{at(0), at(1), at(2)}, here_.rotation};
      const auto rest = [&](std::size_t i, Dimension d) { return quantity(call.arguments[i], d, word); };
      if (n == 6)
        pose.rotation =
            from_rpy(rest(3, Dimension::angle), rest(4, Dimension::angle), rest(5, Dimension::angle));
      if (n == 7)
        pose.rotation = quaternion({rest(3, Dimension::none), rest(4, Dimension::none),
                                    rest(5, Dimension::none), rest(6, Dimension::none)},
                                   word);
      return {pose, word};
    }
    if ((call.word == "by" || call.word == "tool") && n == 3) {
      const Vec3 step{at(0), at(1), at(2)};
      const Vec3 moved = call.word == "by" ? step : here_.rotation * step;
      return {Pose{here_.position + moved, here_.rotation}, word};
    }
    refuse(word, "is not a target",
           "write joints(…), pose(x,y,z), pose(x,y,z,roll,pitch,yaw), pose(x,y,z,qx,qy,qz,qw), by(x,y,z), "
           "tool(x,y,z), or a name");
  }
  static Quaternion quaternion(const Quaternion& q, const std::string& word) {
    if (std::abs(q.x) + std::abs(q.y) + std::abs(q.z) + std::abs(q.w) > 1e-9) return normalized(q);
    refuse(word, "has a quaternion of zeros", "write x y z w of a rotation, 0,0,0,1 for none");
  }
  std::vector<double> joints(const Call& call, const std::string& word) const {
    const kinematics::Chain& chain = places_.robot.chain;
    if (call.arguments.size() != chain.joints())
      refuse(word, fmt::format("has {} values for {} joints", call.arguments.size(), chain.joints()),
             "the joints are " + join(chain.names(), ", "));
    std::vector<double> out;
    for (std::size_t j = 0; j < call.arguments.size(); ++j)
      out.push_back(
          quantity(call.arguments[j], chain.slides(j) ? Dimension::length : Dimension::angle, word));
    return out;
  }

  const data::Value* value_of(const std::string& name) const {
    for (auto set = places_.sets.rbegin(); set != places_.sets.rend(); ++set)
      if (const data::Value* value = set->value(name)) return value;
    return nullptr;
  }

  Pose in_world(const data::Point& point, const std::string& word) const {
    const data::FrameChain chain =
        data::frame_chain(point.frame(), [this](const std::string& name) -> const data::Point* {
          const data::Value* value = value_of(name);
          return value ? value->as_point() : nullptr;
        });
    if (chain.root.empty()) return chain.pose * point.pose;
    if (chain.root == "base") return places_.robot.chain.base() * chain.pose * point.pose;
    throw Error("unknown-frame",
                "'" + word + "' is in the frame '" + chain.root + "', whose place is not known here",
                "use a point in the world, or in a frame of the same files");
  }

  MoveTarget named(const std::string& word) const {
    if (const data::Value* value = value_of(word)) {
      if (const data::Point* point = value->as_point()) return {in_world(*point, word), word};
      if (const data::JointState* state = value->as_joints())
        return {cell::joints_by_name(*places_.robot.model, *state, word), word};
      refuse(word, std::string("is ") + data::name(value->kind()), "a target is a pose or a joint state");
    }
    if (word == "home") return {places_.robot.home, word};
    if (const auto state = places_.robot.model->named_states.find(word);
        state != places_.robot.model->named_states.end())
      return {state->second, word};
    if (parse_number(word))
      throw Error("unknown-name", "'" + word + "' is a number, but the target of a move is a place",
                  kJointsAdvice);
    const std::vector<std::string> known = places_.names();
    throw Error("unknown-name", "there is no place called '" + word + "'" + did_you_mean(word, known),
                "known are " + join(known, ", ") + "; or write joints(…), pose(…), by(…)");
  }
  const NamedPlaces& places_;
  const PaceWords& all_;
  Pose here_;  // TCP after the targets so far
  std::vector<Move> out_;
};

}  // namespace

PaceValue parse_speed(const std::string& text, const std::string& option) {
  return pace(text, option, Dimension::speed, Dimension::angular_speed,
              "write a share (50%), a speed of the TCP (250mm/s) or an angular one (90deg/s)");
}
PaceValue parse_acceleration(const std::string& text, const std::string& option) {
  return pace(text, option, Dimension::acceleration, Dimension::angular_acceleration,
              "write a share (50%) or an acceleration of the TCP (1m/s2)");
}

std::vector<std::string> NamedPlaces::names() const {
  std::vector<std::string> out{"home"};
  for (const auto& [name, state] : robot.model->named_states)
    if (name != "home") out.push_back(name);
  for (const data::DataSet& set : sets)
    for (const data::Entry& entry : set.entries())
      if (entry.value.is_place() && std::find(out.begin(), out.end(), entry.name) == out.end())
        out.push_back(entry.name);
  return out;
}

std::vector<Move> parse_moves(const std::vector<std::string>& words, const NamedPlaces& places,
                              const std::vector<double>& from, const PaceWords& all) {
  return Reader(places, from, all).read(words);
}

bool is_move_word(const std::string& word) {
  return kind_of(word).has_value();
}

std::string text_of(const Move& move) {
  constexpr const char* kWords[] = {"movej", "movel", "movec", "spline"};
  std::string out = kWords[std::size_t(move.kind)];
  for (const MoveTarget& target : move.targets) out += " " + target.name;
  return out;
}

}  // namespace polyarm::apps
