#include "polyarm/base/yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm {

struct Yaml::Data {
  YAML::Node node;
  std::shared_ptr<const std::string> file;
};

Yaml::Yaml() = default;
Yaml::Yaml(const Yaml&) = default;
Yaml::Yaml(Yaml&&) noexcept = default;
Yaml& Yaml::operator=(const Yaml&) = default;
Yaml& Yaml::operator=(Yaml&&) noexcept = default;
Yaml::~Yaml() = default;

namespace {
constexpr int kDeepest = 64;

Location place(const YAML::Mark& mark, const std::string& file) {
  return mark.is_null() ? Location{file} : Location{file, mark.line + 1, mark.column + 1};
}

/// Refuses nesting beyond any file that people write, before recursion over it can exhaust the stack.
void check_depth(const std::string& text, const std::string& file) {
  int depth = 0, line = 1;
  for (const char c : text) {
    if (c == '\n') ++line;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepest)
      throw Error(Problem{"yaml-syntax", {file, line, 0}, "brackets are nested more than 64 deep", {}});
  }
}
}  // namespace

Yaml Yaml::parse(std::string_view text, std::string name) {
  auto file = std::make_shared<const std::string>(std::move(name));
  check_depth(std::string(text), *file);
  try {
    Yaml out;
    out.data_ = std::make_shared<const Data>(Data{YAML::Load(std::string(text)), file});
    return out;
  } catch (const YAML::Exception& e) {
    throw Error(Problem{"yaml-syntax", place(e.mark, *file), "not valid YAML: " + e.msg,
                        "check indentation, colons and quotes on this line and the one before"});
  }
}

Yaml Yaml::load(const std::string& path) {
  return parse(read_file(path), path);
}

bool Yaml::defined() const {
  return data_ && data_->node.IsDefined() && !data_->node.IsNull();
}
bool Yaml::is_map() const {
  return defined() && data_->node.IsMap();
}
bool Yaml::is_list() const {
  return defined() && data_->node.IsSequence();
}
bool Yaml::is_scalar() const {
  return defined() && data_->node.IsScalar();
}
Location Yaml::where() const {
  return data_ ? place(data_->node.Mark(), *data_->file) : Location{};
}

Yaml Yaml::operator[](std::string_view key) const {
  Yaml out;
  if (!is_map()) return out;
  for (const auto& entry : data_->node)
    if (entry.first.IsScalar() && entry.first.Scalar() == key)
      out.data_ = std::make_shared<const Data>(Data{entry.second, data_->file});
  return out;
}

Yaml Yaml::required(std::string_view key) const {
  Yaml out = (*this)[key];
  if (!out.defined())
    throw Error(Problem{"missing-key", where(), "'" + std::string(key) + "' is missing here",
                        "add '" + std::string(key) + ": …'"});
  return out;
}

std::vector<std::string> Yaml::keys() const {
  std::vector<std::string> out;
  if (is_map())
    for (const auto& entry : data_->node)
      if (entry.first.IsScalar()) out.push_back(entry.first.Scalar());
  return out;
}

Location Yaml::key_location(std::string_view key) const {
  if (is_map())
    for (const auto& entry : data_->node)
      if (entry.first.IsScalar() && entry.first.Scalar() == key)
        return place(entry.first.Mark(), *data_->file);
  return where();
}

std::vector<Yaml::Entry> Yaml::entries() const {
  std::vector<Entry> out;
  if (!is_map()) return out;
  for (const auto& entry : data_->node) {
    if (!entry.first.IsScalar()) continue;
    out.push_back({entry.first.Scalar(), place(entry.first.Mark(), *data_->file), {}});
    out.back().value.data_ = std::make_shared<const Data>(Data{entry.second, data_->file});
  }
  return out;
}

std::vector<Yaml> Yaml::items() const {
  std::vector<Yaml> out;
  if (!defined()) return out;
  if (!is_list()) return {*this};
  for (const auto& item : data_->node) {
    Yaml child;
    child.data_ = std::make_shared<const Data>(Data{item, data_->file});
    out.push_back(child);
  }
  return out;
}

std::string Yaml::tag() const {
  const std::string out = defined() ? data_->node.Tag() : std::string();
  return out == "?" || out == "!" ? std::string() : out;
}

std::string Yaml::text() const {
  if (!is_scalar()) throw Error(Problem{"bad-value", where(), "a single value is expected here", {}});
  return data_->node.Scalar();
}

std::string Yaml::text(std::string fallback) const {
  return defined() ? text() : std::move(fallback);
}

double Yaml::number(Dimension dimension) const {
  const std::string value = text();
  if (const auto number = parse_quantity(value, dimension)) return *number;
  throw Error(Problem{"bad-value", where(), "'" + value + "' is not " + polyarm::name(dimension),
                      "write a number in SI units, or one with its unit such as 40mm or 30deg"});
}

double Yaml::number(Dimension dimension, double fallback) const {
  return defined() ? number(dimension) : fallback;
}

bool Yaml::boolean() const {
  const std::string value = lower(text());
  if (value == "true" || value == "yes" || value == "on") return true;
  if (value == "false" || value == "no" || value == "off") return false;
  throw Error(Problem{"bad-value", where(), "'" + value + "' is neither true nor false", {}});
}

bool Yaml::boolean(bool fallback) const {
  return defined() ? boolean() : fallback;
}

std::vector<double> Yaml::numbers(Dimension dimension) const {
  std::vector<double> out;
  for (const Yaml& item : items()) out.push_back(item.number(dimension));
  return out;
}

std::vector<std::string> Yaml::texts() const {
  std::vector<std::string> out;
  for (const Yaml& item : items()) out.push_back(item.text());
  return out;
}

Vec3 Yaml::vec3(Dimension dimension) const {
  const std::vector<double> v = numbers(dimension);
  if (v.size() != 3)
    throw Error(Problem{"bad-value", where(),
                        "three numbers are expected, here are " + std::to_string(v.size()),
                        "write [x, y, z]"});
  return {v[0], v[1], v[2]};
}

Pose Yaml::pose() const {
  if (is_map()) {
    Pose out;
    if (const Yaml at = has("xyz") ? (*this)["xyz"] : (*this)["at"]; at.defined()) out.position = at.vec3();
    if (has("rpy")) {
      const Vec3 rpy = (*this)["rpy"].vec3(Dimension::angle);
      out.rotation = from_rpy(rpy.x, rpy.y, rpy.z);
    }
    if (has("quaternion")) {
      const std::vector<double> q = (*this)["quaternion"].numbers();
      if (q.size() != 4 || !(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 1e-12))
        throw Error(
            Problem{"bad-value", (*this)["quaternion"].where(), "no unit quaternion", "write [x, y, z, w]"});
      out.rotation = normalized(Quaternion{q[0], q[1], q[2], q[3]});
    }
    return out;
  }
  const std::vector<Yaml> v = items();
  if (v.size() != 3 && v.size() != 6 && v.size() != 7)
    throw Error(Problem{"bad-value", where(),
                        "a pose has 3, 6 or 7 numbers, here are " + std::to_string(v.size()),
                        "write [x, y, z], [x, y, z, roll, pitch, yaw] or [x, y, z, qx, qy, qz, qw]"});
  Pose out;
  const auto metres = [&](std::size_t i) { return v[i].number(Dimension::length); };
  const auto radians = [&](std::size_t i) { return v[i].number(Dimension::angle); };
  out.position = {metres(0), metres(1), metres(2)};
  if (v.size() == 6) out.rotation = from_rpy(radians(3), radians(4), radians(5));
  if (v.size() == 7)
    out.rotation = normalized(Quaternion{v[3].number(), v[4].number(), v[5].number(), v[6].number()});
  return out;
}

void Yaml::check_keys(const std::vector<std::string>& known, Problems& problems) const {
  for (const std::string& key : keys())
    if (std::find(known.begin(), known.end(), key) == known.end())
      problems.error("unknown-key", key_location(key),
                     "'" + key + "' is not known here" + did_you_mean(key, known),
                     "known are: " + join(known, ", "));
}

}  // namespace polyarm
