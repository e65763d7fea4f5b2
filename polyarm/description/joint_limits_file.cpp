#include <algorithm>
#include <numbers>

#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"
#include "polyarm/description/joint_limits.hpp"

namespace polyarm::description {

namespace {

/// Reads the entry of one joint; what is wrong goes to the problems.
class EntryReader {
 public:
  EntryReader(const Yaml& yaml, std::string joint, Problems& problems)
      : yaml_(yaml), joint_(std::move(joint)), problems_(problems) {}

  JointLimitSet read() {
    yaml_.check_keys(
        {"has_position_limits", "min_position", "max_position", "has_velocity_limits", "max_velocity",
         "has_acceleration_limits", "max_acceleration", "has_deceleration_limits", "max_deceleration",
         "has_jerk_limits", "max_jerk", "has_effort_limits", "max_effort", "has_soft_limits", "k_position",
         "k_velocity", "soft_lower_limit", "soft_upper_limit", "angle_wraparound"},
        problems_);
    position();
    bound("velocity", out_.velocity, out_.disabled.velocity);
    bound("acceleration", out_.acceleration, out_.disabled.acceleration);
    bound("deceleration", out_.deceleration, out_.disabled.deceleration);
    bound("jerk", out_.jerk, out_.disabled.jerk);
    bound("effort", out_.effort, out_.disabled.effort);
    soft();
    out_.angle_wraparound = flag("angle_wraparound");
    return out_;
  }

 private:
  std::optional<bool> flag(const std::string& key) {
    if (!yaml_.has(key)) return std::nullopt;
    try {
      return yaml_[key].boolean();
    } catch (const Error& e) {
      add(key, e);
      return std::nullopt;
    }
  }

  std::optional<double> number(const std::string& key) {
    const Yaml value = yaml_[key];
    if (!value.defined()) return std::nullopt;
    try {
      const double out = value.number();
      return value.tag() == "!degrees" ? out * std::numbers::pi / 180 : out;
    } catch (const Error& e) {
      add(key, e);
      return std::nullopt;
    }
  }

  /// The complaint of the value, with the name of its key.
  void add(const std::string& key, const Error& e) {
    for (Problem p : e.problems()) {
      p.what = key + " of '" + joint_ + "': " + p.what;
      problems_.add(std::move(p));
    }
  }

  /// Whether `has_…` is true and all of the keys are there; what has no effect is said.
  bool wanted(const std::string& has, const std::optional<bool>& on, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
      if (!on && !yaml_.has(has) && yaml_.has(key)) {
        problems_.warning("no-effect", yaml_.key_location(key),
                          key + " of '" + joint_ + "' has no effect without " + has,
                          "write " + has + ": true beside it");
        return false;
      }
      if (on.value_or(false) && !yaml_.has(key)) {
        problems_.warning("no-effect", yaml_.key_location(has),
                          has + " of '" + joint_ + "' has no effect without " + key,
                          "write " + key + ": … beside it");
        return false;
      }
    }
    return on.value_or(false);
  }

  void bound(const std::string& quantity, std::optional<double>& limit, bool& disabled) {
    const std::string has = "has_" + quantity + "_limits", key = "max_" + quantity;
    const std::optional<bool> on = flag(has);
    disabled = on == false;
    if (!wanted(has, on, {key})) return;
    limit = number(key);
    if (!limit || *limit > 0) return;
    problems_.error(
        "bad-limit", yaml_[key].where(),
        key + " of '" + joint_ + "' is " + format_number(*limit) + ", which would never let it move",
        "write a number above zero, or " + has + ": false");
    limit.reset();
  }

  void position() {
    const std::optional<bool> on = flag("has_position_limits");
    out_.disabled.position = on == false;
    if (!wanted("has_position_limits", on, {"min_position", "max_position"})) return;
    const auto lower = number("min_position"), upper = number("max_position");
    if (!lower || !upper) return;
    if (!(*lower < *upper))
      return problems_.error("bad-limit", yaml_["min_position"].where(),
                             "min_position of '" + joint_ + "' is " + format_number(*lower) +
                                 ", not below its max_position " + format_number(*upper),
                             "exchange them, or write has_position_limits: false");
    out_.lower = lower;
    out_.upper = upper;
  }

  void soft() {
    const std::optional<bool> on = flag("has_soft_limits");
    out_.disabled.soft = on == false;
    if (!wanted("has_soft_limits", on, {"k_position", "k_velocity", "soft_lower_limit", "soft_upper_limit"}))
      return;
    const auto kp = number("k_position"), kv = number("k_velocity"), lower = number("soft_lower_limit"),
               upper = number("soft_upper_limit");
    if (!kp || !kv || !lower || !upper) return;
    if (!(*lower < *upper) || *kp < 0 || *kv < 0)
      return problems_.error("bad-limit", yaml_["soft_lower_limit"].where(),
                             "the soft limits of '" + joint_ + "' run from " + format_number(*lower) +
                                 " to " + format_number(*upper) + " with k_position " + format_number(*kp) +
                                 " and k_velocity " + format_number(*kv),
                             "the lower has to be below the upper, and no k below zero");
    out_.soft = SoftLimits{lower, upper, *kp, *kv};
  }

  const Yaml& yaml_;
  std::string joint_;
  Problems& problems_;
  JointLimitSet out_;
};

/// The maps called joint_limits, wherever they are; other maps (controllers, name spaces) are walked through.
class Search {
 public:
  Search(JointLimitsFile& out, Problems& problems) : out_(out), problems_(problems) {}

  void walk(const Yaml& map, int depth) {
    if (depth > 8 || --nodes_left_ < 0 || !map.is_map()) return;
    for (const std::string& key : map.keys()) {
      keys_.push_back({key, map.key_location(key)});
      if (key == "joint_limits")
        joints(map[key]);
      else if (key == "default_velocity_scaling_factor")
        scaling(map[key], out_.velocity_scaling);
      else if (key == "default_acceleration_scaling_factor")
        scaling(map[key], out_.acceleration_scaling);
      else
        walk(map[key], depth + 1);
    }
  }

  void complain_if_nothing(const std::string& file) const {
    if (found_) return;
    Problem problem{"missing-key",
                    {file, 1},
                    "there is no joint_limits in this file",
                    "write joint_limits: and below it the names of the joints"};
    const std::vector<std::string> wanted{"joint_limits"};
    for (const auto& [key, where] : keys_)
      if (const std::string hint = did_you_mean(key, wanted); !hint.empty())
        problem.where = where, problem.what += ", but '" + key + "'" + hint;
    throw Error(problem);
  }

 private:
  void joints(const Yaml& map) {
    found_ = true;
    if (map.defined() && !map.is_map())
      return problems_.error("bad-value", map.where(), "joint_limits is a map of joints",
                             "write the name of a joint, a colon, and its limits below it");
    for (const std::string& joint : map.keys()) {
      const Yaml entry = map[joint];
      if (!entry.defined()) continue;
      if (!entry.is_map())
        problems_.error("bad-value", entry.where(), "'" + joint + "' needs a map of limits",
                        "write has_velocity_limits: true and max_velocity: … below it");
      else
        out_.joints[joint] = {EntryReader(entry, joint, problems_).read(), map.key_location(joint)};
    }
  }

  void scaling(const Yaml& value, std::optional<double>& out) {
    try {
      const double share = value.number();
      if (share > 0 && share <= 1)
        out = share;
      else
        problems_.error("bad-value", value.where(),
                        "a scaling factor is above 0 and at most 1, this is " + format_number(share));
    } catch (const Error& e) {
      problems_.add(e);
    }
  }

  JointLimitsFile& out_;
  Problems& problems_;
  std::vector<std::pair<std::string, Location>> keys_;
  int nodes_left_ = 10000;
  bool found_ = false;
};

}  // namespace

JointLimitsFile read_joint_limits(std::string_view text, const std::string& file, Problems& problems) {
  JointLimitsFile out;
  Search search(out, problems);
  search.walk(Yaml::parse(text, file), 0);
  search.complain_if_nothing(file);
  return out;
}

}  // namespace polyarm::description
