#include "polyarm/description/scene_file.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/shape_yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::description {

namespace {

constexpr double kDensity = 500;  // kg/m³, for a part without a mass
/// Larger values are probably mistakes, for example a missing unit. m, m/s, m/s², kg.
constexpr double kFarthest = bounds::kSceneMetres, kFastest = bounds::kSceneSpeed,
                 kHardest = bounds::kSceneAcceleration, kHeaviest = bounds::kSceneMass;
constexpr double kLongestWay = bounds::kMoverSeconds;  // s; a dry run waits for it

double bounded(double value, const Yaml& y, double most, const char* unit) {
  if (std::abs(value) <= most) return value;
  throw Error(Problem{"bad-value", y.where(),
                      "'" + shortened(y.text()) + "' is more than any scene has: " + format_number(most) +
                          " " + unit + " at most",
                      "write the unit, as in 40mm; numbers without one are m, m/s, m/s2 and kg"});
}
double amount(const Yaml& y, Dimension of, double fallback, double most, const char* unit) {
  return y.defined() ? bounded(y.number(of), y, most, unit) : fallback;
}
double length(const Yaml& y, double fallback) {
  return amount(y, Dimension::length, fallback, kFarthest, "m");
}
/// Checks a list or a single number.
void require_near(const Yaml& y) {
  if (y.is_map()) return;
  for (const Yaml& each : y.items())
    if (each.is_scalar()) bounded(each.number(Dimension::length), each, kFarthest, "m");
}
/// Checks the keys that give position and size.
void require_near(const Yaml& y, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) require_near(y[key]);
}

std::vector<std::string> with_shapes(std::vector<std::string> keys) {
  keys.insert(keys.end(), shape_keys().begin(), shape_keys().end());
  return keys;
}

template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& list) {
  std::vector<std::string> out;
  for (const Named& item : list) out.push_back(item.name);
  return out;
}

/// Reads one scene; every method adds faults to the problems and continues.
class SceneReader {
 public:
  explicit SceneReader(const Yaml& yaml) : yaml_(yaml) {}

  Scene read() {
    header();
    check_repeats(yaml_, problems_);
    each("movers", [&](const std::string& name, const Yaml& y) { mover(name, y); });
    each("belts", [&](const std::string& name, const Yaml& y) { belt(name, y); });
    each("bins", [&](const std::string& name, const Yaml& y) { bin(name, y); });
    each("fixtures", [&](const std::string& name, const Yaml& y) { fixture(name, y); });
    each("feeders", [&](const std::string& name, const Yaml& y) {
      y.check_keys({"at", "xyz", "rpy", "quaternion", "spread", "turn"}, problems_);
      const Vec3 spread = y.has("spread") ? y["spread"].vec3() : Vec3{};
      scene_.feeders.push_back({name, y.pose(), spread, y["turn"].number(Dimension::angle, 0)});
    });
    each("outfeeds", [&](const std::string& name, const Yaml& y) {
      const auto [lower, upper] = region(y, {});
      scene_.outfeeds.push_back({name, lower, upper});
    });
    each("sensors", [&](const std::string& name, const Yaml& y) {
      const auto [lower, upper] = region(y, {});
      scene_.sensors.push_back({name, lower, upper});
    });
    each("cameras", [&](const std::string& name, const Yaml& y) {
      const auto [lower, upper] = region(y, {"eye"});
      const Vec3 above = 0.5 * (lower + upper) + Vec3{0, 0, 0.8};
      scene_.cameras.push_back({name, lower, upper, y.has("eye") ? y["eye"].vec3() : above});
    });
    each("parts", [&](const std::string& name, const Yaml& y) { parts(name, y); });
    problems_.throw_if_errors();
    return std::move(scene_);
  }

 private:
  template <typename Read>
  void each(const char* section, Read read) {
    const Yaml all = yaml_[section];
    if (all.defined() && !all.is_map()) {
      problems_.error("bad-value", all.where(), std::string("'") + section + "' must be a map of names",
                      "write 'NAME: {…}' below it");
      return;
    }
    if (all.keys().size() > bounds::kSceneThings) {
      problems_.error(
          "too-many", all.where(),
          std::string("'") + section + "' has more than " + std::to_string(bounds::kSceneThings) + " entries",
          "join those that belong together");
      return;
    }
    std::set<std::string> seen;
    for (const std::string& name : all.keys()) {
      if (!seen.insert(name).second) continue;
      try {
        require_near(all[name], {"at", "xyz", "inner", "wall", "lower", "upper", "size", "eye", "box"});
        read(name, all[name]);
      } catch (const Error& e) {
        problems_.add(e);
      }
    }
  }

  void header() {
    const std::string kind = yaml_["polyarm"].text("");
    if (kind != "scene/1")
      problems_.error("wrong-kind", yaml_.where(),
                      kind.empty() ? "this is not a scene file: the line 'polyarm: scene/1' is missing"
                                   : "this is a '" + kind + "' file, a scene/1 was expected");
    yaml_.check_keys({"polyarm", "floor", "gravity", "fixtures", "bins", "movers", "belts", "feeders",
                      "outfeeds", "sensors", "cameras", "parts"},
                     problems_);
    const Yaml floor = yaml_["floor"];
    if (floor.is_map()) {
      scene_.floor_height = length(floor["height"], 0);
    } else if (floor.defined()) {
      scene_.floor = floor.boolean();
    }
    if (yaml_.has("gravity")) {
      scene_.gravity = yaml_["gravity"].vec3(Dimension::acceleration);
      for (const Yaml& each : yaml_["gravity"].items())
        bounded(each.number(Dimension::acceleration), each, kHardest, "m/s2");
    }
  }

  void mover(const std::string& name, const Yaml& y) {
    y.check_keys({"axis", "lower", "upper", "speed", "acceleration"}, problems_);
    Mover out;
    out.name = name;
    const Vec3 axis = y.required("axis").vec3(Dimension::none);
    if (!(norm(axis) > 0))
      throw Error(Problem{"bad-value", y["axis"].where(), "the axis has no direction", {}});
    out.axis = normalized(axis);
    out.lower = length(y["lower"], out.lower);
    out.upper = length(y["upper"], out.upper);
    out.speed = amount(y["speed"], Dimension::speed, out.speed, kFastest, "m/s");
    out.acceleration = amount(y["acceleration"], Dimension::acceleration, out.acceleration, kHardest, "m/s2");
    if (!(out.lower < out.upper && out.speed > 0 && out.acceleration > 0))
      throw Error(Problem{
          "bad-value", y.where(), "a mover needs lower < upper, and speed and acceleration above zero", {}});
    if (std::max((out.upper - out.lower) / out.speed, out.speed / out.acceleration) > kLongestWay)
      throw Error(Problem{"bad-value", y.where(),
                          "the mover '" + shortened(name) + "' needs more than " +
                              format_number(kLongestWay) + " s from one end to the other",
                          "give it a higher speed or acceleration, or a shorter way"});
    scene_.movers.push_back(out);
  }

  /// Its frame is in the middle of its surface, on top.
  void belt(const std::string& name, const Yaml& y) {
    y.check_keys({"size", "radius", "at", "xyz", "rpy", "quaternion", "speed", "acceleration", "sensor_at",
                  "friction"},
                 problems_);
    Belt out;
    out.name = name;
    out.pose = y.pose();
    out.turns = y.has("radius");
    const Dimension way = out.turns ? Dimension::angular_speed : Dimension::speed;
    out.speed = amount(y["speed"], way, out.speed, kFastest, out.turns ? "rad/s" : "m/s");
    out.acceleration =
        amount(y["acceleration"], out.turns ? Dimension::angular_acceleration : Dimension::acceleration,
               out.acceleration, kHardest, out.turns ? "rad/s2" : "m/s2");
    out.sensor_at = y["sensor_at"].number(out.turns ? Dimension::angle : Dimension::length, 0);
    Shape shape;
    if (out.turns) {
      constexpr double kThickness = 0.02;
      shape.kind = ShapeKind::cylinder;
      shape.radius = out.half_width = length(y["radius"], 0);
      shape.length = kThickness;
      shape.pose.position.z = -kThickness / 2;
    } else {
      shape.size = y.required("size").vec3();
      shape.pose.position.z = -shape.size.z / 2;
      out.half_width = shape.size.y / 2;
    }
    const bool solid =
        out.turns ? shape.radius > 0 : shape.size.x > 0 && shape.size.y > 0 && shape.size.z > 0;
    if (!(solid && out.speed > 0 && out.acceleration > 0))
      throw Error(Problem{"bad-value", y.where(), "a belt needs sizes, speed and acceleration above zero",
                          "write size: [LENGTH, WIDTH, THICKNESS], or radius: R for a turntable"});
    Fixture body;
    body.name = body.belt = name;
    body.pose = out.pose;
    body.shapes = {shape};
    body.friction = friction(y["friction"], body.friction);
    scene_.belts.push_back(std::move(out));
    scene_.fixtures.push_back(std::move(body));
  }

  void fixture(const std::string& name, const Yaml& y) {
    y.check_keys(with_shapes({"mesh", "cloud", "at", "xyz", "rpy", "quaternion", "mover", "friction"}),
                 problems_);
    Fixture out;
    out.name = name;
    if (y.has("cloud"))
      out.shapes = read_cloud(y);
    else
      out.shapes = {read_shape_or_mesh(y)};
    out.pose = y.pose();
    out.mover = y["mover"].text("");
    out.friction = friction(y["friction"], out.friction);
    known(out.mover, names_of(scene_.movers), y["mover"], "mover");
    scene_.fixtures.push_back(std::move(out));
  }

  /// A floor area with walls (or only the region in which parts are counted).
  void bin(const std::string& name, const Yaml& y) {
    y.check_keys({"at", "inner", "wall", "walls", "lower", "upper", "size"}, problems_);
    if (y.has("lower") || y.has("size")) {
      const auto [lower, upper] = region(y, {"walls"});
      scene_.bins.push_back({name, lower, upper});
      return;
    }
    const Vec3 at = y.required("at").vec3(), inner = y.required("inner").vec3();
    const double wall = y["wall"].number(Dimension::length, 0.005);
    if (!(inner.x > 0 && inner.y > 0 && inner.z > 0 && wall > 0))
      throw Error(Problem{
          "bad-value", y["inner"].where(), "a bin's inner sizes and its wall must be above zero", {}});
    scene_.bins.push_back({name,
                           {at.x - inner.x / 2, at.y - inner.y / 2, at.z - 0.005},
                           {at.x + inner.x / 2, at.y + inner.y / 2, at.z + std::max(inner.z, 0.06)}});
    if (!y["walls"].boolean(true)) return;
    Fixture out;
    out.name = name;
    out.pose.position = at;
    const auto side = [&](double x, double y_, double lx, double ly) {
      Shape s;
      s.size = {lx, ly, inner.z};
      s.pose.position = {x, y_, inner.z / 2};
      out.shapes.push_back(s);
    };
    const double ox = inner.x / 2 + wall / 2, oy = inner.y / 2 + wall / 2;
    side(ox, 0, wall, inner.y + 2 * wall);
    side(-ox, 0, wall, inner.y + 2 * wall);
    side(0, oy, inner.x, wall);
    side(0, -oy, inner.x, wall);
    scene_.fixtures.push_back(std::move(out));
  }

  std::pair<Vec3, Vec3> region(const Yaml& y, std::vector<std::string> more) {
    more.insert(more.end(), {"at", "size", "lower", "upper"});
    y.check_keys(more, problems_);
    Vec3 lower, upper;
    if (y.has("lower")) {
      lower = y["lower"].vec3();
      upper = y.required("upper").vec3();
    } else {
      const Vec3 at = y.required("at").vec3(), size = y.required("size").vec3();
      lower = at - 0.5 * size;
      upper = at + 0.5 * size;
    }
    if (!(lower.x < upper.x && lower.y < upper.y && lower.z < upper.z))
      throw Error(Problem{
          "bad-value", y.where(), "the region is empty: lower must be below upper in x, y and z", {}});
    return {lower, upper};
  }

  void parts(const std::string& name, const Yaml& y) {
    y.check_keys(with_shapes({"mesh", "count", "kind", "mass", "friction", "at", "xyz", "rpy", "quaternion",
                              "goal", "feeder"}),
                 problems_);
    Part part;
    part.kind = y["kind"].text(name);
    part.shape = read_shape_or_mesh(y);
    if (part.shape.kind == ShapeKind::mesh && !y.has("mass"))
      throw Error(Problem{"missing-key", y.where(), "the part '" + name + "' is a mesh and has no 'mass'",
                          "write its mass, as in mass: 120g"});
    part.mass = amount(y["mass"], Dimension::mass, inertial_of({part.shape}, kDensity).mass, kHeaviest, "kg");
    part.friction = friction(y["friction"], part.friction);
    part.start = y.pose();
    part.feeder = y["feeder"].text("");
    if (!(part.mass > 0))
      throw Error(Problem{"bad-value", y["mass"].where(), "a part's mass must be above zero", {}});
    known(part.feeder, names_of(scene_.feeders), y["feeder"], "feeder");
    if (part.feeder.empty() && !y.has("at") && !y.has("xyz"))
      problems_.error("missing-key", y.where(), "the part '" + name + "' has neither 'at' nor a 'feeder'");
    if (const Yaml goal = y["goal"]; goal.defined()) part.goal = read_goal(goal);
    const double count = y["count"].number(Dimension::none, 1);
    if (!(count >= 1 && count <= 1000 && count == std::floor(count)))
      throw Error(
          Problem{"bad-value", y["count"].where(), "count must be a whole number from 1 to 1000", {}});
    if (count > 1 && part.feeder.empty())
      throw Error(Problem{"bad-value", y["count"].where(), "several parts cannot be at the same place",
                          "give them a feeder, or a place each"});
    if (std::find(scene_.kinds.begin(), scene_.kinds.end(), part.kind) == scene_.kinds.end())
      scene_.kinds.push_back(part.kind);
    for (int i = 1; i <= static_cast<int>(count); ++i) {
      part.name = count > 1 ? name + "_" + std::to_string(i) : name;
      const auto [first, is_new] = part_lines_.try_emplace(part.name, y.where().line);
      if (!is_new)
        throw Error(Problem{
            "duplicate-name", y.where(),
            "two parts are called '" + part.name + "', here and in line " + std::to_string(first->second),
            "a count makes the names NAME_1, NAME_2, …; rename one of them"});
      scene_.parts.push_back(part);
    }
  }

  static double friction(const Yaml& y, double fallback) {
    const double value = y.number(Dimension::none, fallback);
    if (!(value >= 0)) throw Error(Problem{"bad-value", y.where(), "friction cannot be below zero", {}});
    return value;
  }

  Goal read_goal(const Yaml& y) {
    y.check_keys({"at", "bin", "tolerance"}, problems_);
    Goal out;
    out.at = y.required("at").vec3();
    require_near(y["at"]);
    out.bin = y["bin"].text("");
    out.tolerance = y["tolerance"].number(Dimension::length, out.tolerance);
    if (!(out.tolerance > 0))
      throw Error(Problem{"bad-value", y["tolerance"].where(), "a tolerance must be above zero", {}});
    known(out.bin, names_of(scene_.bins), y["bin"], "bin");
    return out;
  }

  void known(const std::string& name, const std::vector<std::string>& names, const Yaml& where,
             const char* what) {
    if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) return;
    problems_.error(
        "unknown-name", where.where(),
        std::string("there is no ") + what + " '" + name + "'" + did_you_mean(name, names),
        names.empty() ? std::string("the scene has no ") + what + "s" : "known are: " + join(names, ", "));
  }

  const Yaml& yaml_;
  Scene scene_;
  std::map<std::string, int> part_lines_;  ///< by name
  Problems problems_;
};

}  // namespace

/// SplitMix64 of the part's number and the axis.
Pose Feeder::place(std::size_t part) const {
  const auto chance = [&](std::uint64_t axis) {
    std::uint64_t z = (4 * part + axis + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return 2 * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53 - 1;
  };
  if (spread == Vec3{} && turn == 0) return pose;
  return pose * Pose{{chance(0) * spread.x, chance(1) * spread.y, chance(2) * spread.z},
                     from_axis_angle({0, 0, 1}, chance(3) * turn)};
}

Scene read_scene(const Yaml& yaml) {
  return SceneReader(yaml).read();
}

Scene read_scene(const std::string& path) {
  return read_scene(Yaml::load(path));
}

Scene read_scene(const std::string& path, Problems& warnings) {
  return read_scene(Yaml::load(path), warnings);
}

Scene read_scene(const Yaml& yaml, Problems& warnings) {
  Scene out = read_scene(yaml);
  const Yaml parts = yaml["parts"];
  for (const std::string& name : parts.keys()) {
    const Yaml part = parts[name];
    if (part.has("mass")) continue;
    const auto named = [&](const Part& each) { return each.name == name || each.name == name + "_1"; };
    const auto made = std::find_if(out.parts.begin(), out.parts.end(), named);
    if (made == out.parts.end()) continue;
    warnings.warning(
        "no-mass", parts.key_location(name),
        "the part '" + name + "' states no mass: " + format_number(std::round(1e4 * made->mass) / 1e4) +
            " kg is taken, from its shape and 500 kg/m3",
        "add mass: 80g, as you weigh it; what a gripper holds and a joint carries depends on it");
  }
  return out;
}

}  // namespace polyarm::description
