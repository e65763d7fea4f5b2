#include "polyarm/calibration/samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::calibration {

namespace {
const std::vector<std::string> kPoses{"flange", "marker", "measured", "along_z", "along_x"},
    kVectors{"point", "known", "force", "torque", "angular_velocity", "angular_acceleration", "acceleration"},
    kJoints{"q", "v", "a", "tau"};

bool among(const std::vector<std::string>& all, std::string_view name) {
  return std::find(all.begin(), all.end(), name) != all.end();
}

std::vector<std::string> all_names() {
  std::vector<std::string> out = kPoses;
  out.insert(out.end(), kVectors.begin(), kVectors.end());
  out.insert(out.end(), kJoints.begin(), kJoints.end());
  return out;
}

[[noreturn]] void missing(const Sample& sample, const std::string& name) {
  throw Error(Problem{"missing-key", sample.where, "the sample has no '" + name + "'",
                      "each sample of this kind of calibration needs it; docs/calibration.md lists them"});
}

double finite(double value, const Location& where) {
  constexpr double kMost = 1e6;
  if (!(std::abs(value) <= kMost))
    throw Error(Problem{"bad-value", where, fmt::format("{:g} is not a possible measurement", value),
                        "SI units: m, rad, N, N m"});
  return value;
}

/// A place 100 m away was measured in millimetres. Without this, the result would be wrong by a factor of
/// 1000.
void must_be_metres(const std::string& name, const Vec3& place, const Location& where) {
  constexpr double kFar = 100;
  for (const double each : {place.x, place.y, place.z})
    if (std::abs(finite(each, where)) > kFar)
      throw Error(Problem{"bad-value", where, fmt::format("'{}' lies {:g} m away", name, std::abs(each)),
                          "this looks like millimetres; lengths are in metres"});
}

bool is_place(const std::string& vector) {
  return vector == "point" || vector == "known";
}

Sample from_yaml(const Yaml& yaml, Problems& problems) {
  Sample out;
  out.where = yaml.where();
  yaml.check_keys(all_names(), problems);
  for (const Yaml::Entry& entry : yaml.entries())
    collect(problems, [&] {
      if (among(kPoses, entry.key)) {
        const Pose pose = entry.value.pose();
        must_be_metres(entry.key, pose.position, entry.where);
        out.poses[entry.key] = pose;
      } else if (among(kVectors, entry.key)) {
        const Vec3 v = entry.value.vec3(Dimension::none);
        for (const double each : {v.x, v.y, v.z}) finite(each, entry.where);
        if (is_place(entry.key)) must_be_metres(entry.key, v, entry.where);
        out.vectors[entry.key] = v;
      } else if (among(kJoints, entry.key)) {
        const auto values = entry.value.entries();
        if (values.size() > kMostJoints)
          throw Error(Problem{"too-many", entry.where, "a sample has too many joints", {}});
        for (const Yaml::Entry& each : values)
          out.joints[entry.key][each.key] = finite(each.value.number(), each.where);
      }
    });
  return out;
}

std::vector<Sample> read_yaml(std::string_view text, const std::string& file) {
  const Yaml yaml = Yaml::parse(text, file);
  Problems problems;
  check_repeats(yaml, problems);
  if (yaml["polyarm"].text("") != "samples/1")
    problems.error("bad-value", yaml.where(), "this is not a file of samples",
                   "its first line is `polyarm: samples/1`");
  yaml.check_keys({"polyarm", "samples"}, problems);
  const std::vector<Yaml> items = yaml["samples"].items();
  if (items.size() > kMostSamples)
    problems.error("too-many", yaml.where(),
                   fmt::format("{} samples; at most {}", items.size(), kMostSamples));
  problems.throw_if_errors();
  std::vector<Sample> out;
  for (const Yaml& each : items) out.push_back(from_yaml(each, problems));
  problems.throw_if_errors();
  return out;
}

/// What a column of a CSV file fills.
using Fill = std::function<void(Sample&, double)>;

std::optional<Fill> fill_of(const std::string& column,
                            std::map<std::string, std::array<double, 7>>& numbers) {
  const auto dot = column.find('.');
  if (dot == std::string::npos || dot + 1 == column.size()) return std::nullopt;
  const std::string name = column.substr(0, dot), part = column.substr(dot + 1);
  if (among(kJoints, name))
    return [name, part](Sample& sample, double value) { sample.joints[name][part] = value; };
  const bool pose = among(kPoses, name);
  if (!pose && !among(kVectors, name)) return std::nullopt;
  static const std::vector<std::string> kParts{"x", "y", "z", "qx", "qy", "qz", "qw"},
      kTurns{"roll", "pitch", "yaw"};
  for (std::size_t k = 0; k < (pose ? 7u : 3u); ++k)
    if (kParts[k] == part) return [&numbers, name, k](Sample&, double value) { numbers[name][k] = value; };
  for (std::size_t k = 0; k < 3; ++k)
    if (pose && kTurns[k] == part)
      return [&numbers, name, k](Sample&, double value) { numbers[name + " angles"][k] = value; };
  return std::nullopt;
}

/// A pose needs x y z, and either all angles or all of a quaternion, with no part of the other.
bool complete(const std::vector<std::string>& columns, const std::string& name) {
  const auto has = [&](const char* part) { return among(columns, name + "." + part); };
  const bool place = has("x") && has("y") && has("z");
  if (!among(kPoses, name)) return place;
  const bool angles = has("roll") && has("pitch") && has("yaw");
  const bool quaternion = has("qx") && has("qy") && has("qz") && has("qw");
  const bool some_angle = has("roll") || has("pitch") || has("yaw");
  const bool some_part = has("qx") || has("qy") || has("qz") || has("qw");
  return place && ((angles && !some_part) || (quaternion && !some_angle));
}

void put_poses(Sample& sample, const std::map<std::string, std::array<double, 7>>& numbers) {
  for (const auto& [name, n] : numbers) {
    if (name.ends_with(" angles")) continue;
    if (among(kVectors, name)) {
      sample.vectors[name] = {n[0], n[1], n[2]};
      if (is_place(name)) must_be_metres(name, sample.vectors[name], sample.where);
      continue;
    }
    Pose pose{{n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}};
    must_be_metres(name, pose.position, sample.where);
    if (const auto angles = numbers.find(name + " angles"); angles != numbers.end()) {
      constexpr double kTwoTurns = 4 * std::numbers::pi;
      for (const double each : angles->second)
        if (std::abs(each) > kTwoTurns)
          throw Error(Problem{"bad-value", sample.where,
                              fmt::format("an angle of '{}' is {:g} rad", name, each),
                              "this looks like degrees; angles are in radians"});
      pose.rotation = from_rpy(angles->second[0], angles->second[1], angles->second[2]);
    } else {
      const Quaternion& q = pose.rotation;
      const double size = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
      if (!(std::abs(size - 1) < 0.01))
        throw Error(
            Problem{"bad-value", sample.where, "the quaternion of '" + name + "' has not length 1", {}});
      pose.rotation = normalized(q);
    }
    sample.poses[name] = pose;
  }
}

class CsvReader {
 public:
  explicit CsvReader(std::string file) : file_(std::move(file)) {}

  std::vector<Sample> read(std::string_view text) {
    for (int line = 1; !text.empty(); ++line) {
      const auto end = text.find('\n');
      const std::string_view row = trim(text.substr(0, end));
      text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
      if (row.empty() || row.front() == '#') continue;
      if (columns_.empty())
        read_head(row, line);
      else
        collect(problems_, [&] { read_row(row, line); });
      if (samples_.size() > kMostSamples) {
        problems_.error("too-many", {file_, line}, fmt::format("more than {} samples", kMostSamples));
        break;
      }
      if (problems_.list().size() > 100) break;
    }
    problems_.throw_if_errors();
    return std::move(samples_);
  }

 private:
  static std::vector<std::string> cells(std::string_view row) {
    std::vector<std::string> out;
    for (;;) {
      const auto comma = row.find(',');
      out.emplace_back(trim(row.substr(0, comma)));
      if (comma == std::string_view::npos || out.size() > 10 * kMostJoints) return out;
      row.remove_prefix(comma + 1);
    }
  }

  void read_head(std::string_view row, int line) {
    columns_ = cells(row);
    for (const std::string& column : columns_) {
      const auto fill = fill_of(column, numbers_);
      if (!fill || std::count(columns_.begin(), columns_.end(), column) > 1)
        throw Error(Problem{"unknown-name",
                            {file_, line},
                            fill ? "the column '" + shortened(column) + "' occurs twice"
                                 : "'" + printable_line(shortened(column)) + "' is not a column",
                            "columns are flange.x … flange.qw, marker.x …, point.x …, q.JOINT …"});
      fills_.push_back(*fill);
      const std::string name = column.substr(0, column.find('.'));
      if (!among(kJoints, name) && !complete(columns_, name))
        throw Error(
            Problem{"missing-key",
                    {file_, line},
                    "the columns of '" + name + "' are not complete",
                    "a pose needs x, y, z and either roll, pitch, yaw or qx, qy, qz, qw; a vector x, y, z"});
    }
  }

  void read_row(std::string_view row, int line) {
    const std::vector<std::string> values = cells(row);
    if (values.size() != columns_.size())
      throw Error(Problem{"bad-value",
                          {file_, line},
                          fmt::format("{} values under {} columns", values.size(), columns_.size()),
                          {}});
    Sample sample;
    sample.where = {file_, line};
    for (std::size_t k = 0; k < values.size(); ++k) {
      double value = 0;
      const char* const end = values[k].data() + values[k].size();
      const auto [at, error] = std::from_chars(values[k].data(), end, value);
      if (error != std::errc{} || at != end)
        throw Error(Problem{"bad-value",
                            {file_, line},
                            "'" + printable_line(shortened(values[k])) + "' in the column '" + columns_[k] +
                                "' is not a number",
                            {}});
      fills_[k](sample, finite(value, sample.where));
    }
    put_poses(sample, numbers_);
    samples_.push_back(std::move(sample));
  }

  std::string file_;
  std::vector<std::string> columns_;
  std::vector<Fill> fills_;
  std::map<std::string, std::array<double, 7>> numbers_;
  std::vector<Sample> samples_;
  Problems problems_;
};
}  // namespace

const Pose& Sample::pose(const std::string& name) const {
  const auto found = poses.find(name);
  if (found == poses.end()) missing(*this, name);
  return found->second;
}

const Vec3& Sample::vector(const std::string& name) const {
  const auto found = vectors.find(name);
  if (found == vectors.end()) missing(*this, name);
  return found->second;
}

Vec3 Sample::vector_or_zero(const std::string& name) const {
  const auto found = vectors.find(name);
  return found == vectors.end() ? Vec3{} : found->second;
}

std::vector<double> Sample::values(const std::string& name, const std::vector<std::string>& wanted) const {
  const auto found = joints.find(name);
  if (found == joints.end()) missing(*this, name);
  std::vector<double> out;
  for (const std::string& joint : wanted) {
    const auto value = found->second.find(joint);
    if (value == found->second.end()) missing(*this, name + "." + joint);
    out.push_back(value->second);
  }
  for (const auto& [joint, value] : found->second)
    if (!among(wanted, joint))
      throw Error(Problem{
          "unknown-joint",
          where,
          "the robot has no joint '" + printable_line(shortened(joint)) + "'" + did_you_mean(joint, wanted),
          {}});
  return out;
}

std::vector<Sample> read_samples(std::string_view text, const std::string& file) {
  return lower(file).ends_with(".csv") ? CsvReader(file).read(text) : read_yaml(text, file);
}

std::string samples_text(const std::vector<Sample>& samples) {
  std::string out = "polyarm: samples/1\nsamples:\n";
  for (const Sample& each : samples) {
    const char* lead = "  - ";
    const auto line = [&](const std::string& text) {
      out += lead + text + "\n";
      lead = "    ";
    };
    for (const auto& [name, pose] : each.poses)
      line(fmt::format("{}: [{}, {}, {}, {}, {}, {}, {}]", name, pose.position.x, pose.position.y,
                       pose.position.z, pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w));
    for (const auto& [name, v] : each.vectors) line(fmt::format("{}: [{}, {}, {}]", name, v.x, v.y, v.z));
    for (const auto& [name, values] : each.joints) {
      std::vector<std::string> parts;
      for (const auto& [joint, value] : values) parts.push_back(fmt::format("{}: {}", joint, value));
      line(fmt::format("{}: {{{}}}", name, join(parts, ", ")));
    }
  }
  return out;
}

}  // namespace polyarm::calibration
