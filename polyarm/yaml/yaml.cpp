#include "polyarm/yaml/yaml.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml_document.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm {

struct Yaml::Data {
  std::shared_ptr<const YamlDocument> document;
  const YamlNode* node;
  std::string key{};  ///< the key of this node; for an item of a list the key of the list

  Yaml child(const YamlNode* of, const std::string& behind) const {
    Yaml out;
    out.data_ = std::make_shared<const Data>(Data{document, of, behind});
    return out;
  }
  /// The name of the node in messages: "'hardware'", or "this" for a node without a key.
  static std::string named(const std::shared_ptr<const Data>& data) {
    return data && !data->key.empty() ? "'" + data->key + "'" : "this";
  }
  /// "a list of 2 values"
  static std::string kind(const std::shared_ptr<const Data>& data) {
    if (!data || data->node->kind == YamlNode::Kind::null) return "empty";
    if (data->node->kind == YamlNode::Kind::map) return "a map of keys";
    if (data->node->kind == YamlNode::Kind::scalar) return "'" + shortened(data->node->scalar) + "'";
    const std::size_t size = data->node->entries.size();
    return size == 0   ? "an empty list"
           : size == 1 ? "a list of one value"
                       : "a list of " + std::to_string(size) + " values";
  }
};

Yaml::Yaml() = default;
Yaml::Yaml(const Yaml&) = default;
Yaml::Yaml(Yaml&&) noexcept = default;
Yaml& Yaml::operator=(const Yaml&) = default;
Yaml& Yaml::operator=(Yaml&&) noexcept = default;
Yaml::~Yaml() = default;

namespace {
/// The unknown keys of one map that are listed by name; the others are only counted.
using bounds::kUnknownKeys;
using Kind = YamlNode::Kind;

std::string such_as(Dimension dimension) {
  switch (dimension) {
    case Dimension::length:
      return "40mm";
    case Dimension::angle:
      return "30deg";
    case Dimension::time:
      return "500ms";
    case Dimension::mass:
      return "80g";
    case Dimension::speed:
      return "250mm/s";
    case Dimension::angular_speed:
      return "30deg/s";
    case Dimension::acceleration:
      return "2m/s2";
    default:
      return "40mm or 30deg";
  }
}
}  // namespace

Yaml Yaml::parse(std::string_view text, std::string name) {
  auto document = YamlDocument::parse(text, std::move(name));
  Yaml out;
  out.data_ = std::make_shared<const Data>(Data{document, document->root});
  return out;
}

Yaml load_with_repeats(const std::string& path) {
  return Yaml::parse(read_file(path, bounds::kYamlBytes), path);
}

Yaml Yaml::load(const std::string& path) {
  Yaml out = load_with_repeats(path);
  Problems problems;
  check_repeats(out, problems);
  problems.throw_if_errors();
  return out;
}

bool Yaml::defined() const {
  return data_ && data_->node->kind != Kind::null;
}
bool Yaml::is_map() const {
  return data_ && data_->node->kind == Kind::map;
}
bool Yaml::is_list() const {
  return data_ && data_->node->kind == Kind::list;
}
bool Yaml::is_scalar() const {
  return data_ && data_->node->kind == Kind::scalar;
}
Location Yaml::where() const {
  return data_ ? data_->document->where(*data_->node) : Location{};
}

Yaml Yaml::operator[](std::string_view key) const {
  const YamlNode* const value = is_map() ? data_->node->value_of(key) : nullptr;
  return value ? data_->child(value, std::string(key)) : Yaml();
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
    for (const auto& [key, value] : data_->node->entries)
      if (key->kind == Kind::scalar) out.push_back(key->scalar);
  return out;
}

Location Yaml::key_location(std::string_view key) const {
  const YamlNode* const found = is_map() ? data_->node->key_of(key) : nullptr;
  return found ? data_->document->where(*found) : where();
}

std::vector<Yaml::Entry> Yaml::entries() const {
  std::vector<Entry> out;
  if (!is_map()) return out;
  for (const auto& [key, value] : data_->node->entries)
    if (key->kind == Kind::scalar)
      out.push_back({key->scalar, data_->document->where(*key), data_->child(value, key->scalar)});
  return out;
}

std::vector<Yaml> Yaml::items() const {
  std::vector<Yaml> out;
  if (!defined()) return out;
  if (!is_list()) return {*this};
  for (const auto& [none, item] : data_->node->entries) out.push_back(data_->child(item, data_->key));
  return out;
}

std::string Yaml::tag() const {
  const std::string out = defined() ? data_->node->tag : std::string();
  return out == "?" || out == "!" ? std::string() : out;
}

std::string Yaml::text() const {
  if (is_scalar()) return data_->node->scalar;
  throw Error(Problem{"bad-value", where(),
                      Data::named(data_) + " is " + Data::kind(data_) + ", a single value was expected",
                      is_list()  ? "write the value without brackets and dashes"
                      : is_map() ? "write the value alone, without keys below it"
                                 : "write a value behind the colon"});
}

std::string Yaml::text(std::string fallback) const {
  return defined() ? text() : std::move(fallback);
}

double Yaml::number(Dimension dimension) const {
  const std::string value = text();
  if (const auto number = parse_quantity(value, dimension)) return *number;
  const std::string advice =
      dimension == Dimension::none
          ? "write a number without a unit, such as 0.5 or 2"
          : "write a number in SI units, or one with its unit such as " + such_as(dimension);
  throw Error(Problem{
      "bad-value", where(),
      Data::named(data_) + " is '" + shortened(value) + "', " + polyarm::name(dimension) + " was expected",
      advice});
}

double Yaml::number(Dimension dimension, double fallback) const {
  return defined() ? number(dimension) : fallback;
}

bool Yaml::boolean() const {
  const std::string value = lower(text());
  if (value == "true" || value == "yes" || value == "on") return true;
  if (value == "false" || value == "no" || value == "off") return false;
  throw Error(Problem{"bad-value",
                      where(),
                      Data::named(data_) + " is '" + shortened(value) + "', true or false was expected",
                      {}});
}

bool Yaml::boolean(bool fallback) const {
  return defined() ? boolean() : fallback;
}

std::vector<double> Yaml::numbers(Dimension dimension) const {
  std::vector<double> out;
  for (const Yaml& item : items()) out.push_back(item.number(dimension));
  return out;
}

std::string Yaml::named() const {
  return Data::named(data_);
}

std::string Yaml::kind() const {
  return Data::kind(data_);
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
                        Data::named(data_) + " takes three numbers, here are " + std::to_string(v.size()),
                        "write [x, y, z]"});
  return {v[0], v[1], v[2]};
}

namespace {
bool has_unit(const Yaml& value) {
  const std::string text = value.text();
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.back()));
}

/// An angle, rad. Throws if it is more than two turns and has no unit: it was probably meant in degrees.
double turn_of(const Yaml& value) {
  const double out = value.number(Dimension::angle);
  if (std::abs(out) > 4 * std::numbers::pi && !has_unit(value))
    throw Error(
        Problem{"bad-value", value.where(), "an angle of " + value.text() + " rad is more than two whole turns",
                "this looks like degrees, write " + value.text() + "deg: angles without a unit are radians"});
  return out;
}

/// A position, m. Throws if it is 100 m or more and has no unit: it was probably meant in millimetres.
double place_of(const Yaml& value) {
  constexpr double kFar = 100;
  const double out = value.number(Dimension::length);
  if (std::abs(out) >= kFar && !has_unit(value))
    throw Error(Problem{
        "bad-value", value.where(), value.text() + " m is far outside of any cell",
        "this looks like millimetres, write " + value.text() + "mm: lengths without a unit are metres"});
  return out;
}

Vec3 three(const Yaml& list, double (*read)(const Yaml&)) {
  const std::vector<Yaml> v = list.items();
  if (v.size() != 3) return list.vec3();  // throws an error with the size
  return {read(v[0]), read(v[1]), read(v[2])};
}
}  // namespace

Pose Yaml::pose() const {
  if (is_map()) {
    Pose out;
    if (const Yaml at = has("xyz") ? (*this)["xyz"] : (*this)["at"]; at.defined())
      out.position = three(at, place_of);
    if (has("rpy")) {
      const Vec3 rpy = three((*this)["rpy"], turn_of);
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
    throw Error(
        Problem{"bad-value", where(),
                Data::named(data_) + " is a pose of 3, 6 or 7 numbers, here are " + std::to_string(v.size()),
                "write [x, y, z], [x, y, z, roll, pitch, yaw] or [x, y, z, qx, qy, qz, qw]"});
  Pose out;
  const auto metres = [&](std::size_t i) { return place_of(v[i]); };
  const auto radians = [&](std::size_t i) { return turn_of(v[i]); };
  out.position = {metres(0), metres(1), metres(2)};
  if (v.size() == 6) out.rotation = from_rpy(radians(3), radians(4), radians(5));
  if (v.size() == 7)
    out.rotation = normalized(Quaternion{v[3].number(), v[4].number(), v[5].number(), v[6].number()});
  return out;
}

void Yaml::check_keys(const std::vector<std::string>& known, Problems& problems) const {
  if (!is_map()) return;
  std::size_t unknown = 0;
  Location next;
  for (const auto& [node, value] : data_->node->entries) {
    if (node->kind != Kind::scalar) continue;
    const std::string& key = node->scalar;
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const Location where = data_->document->where(*node);
    if (++unknown <= kUnknownKeys)
      problems.error("unknown-key", where,
                     "'" + shortened(key) + "' is not known here" + did_you_mean(key, known),
                     "known are: " + join(known, ", "));
    else if (unknown == kUnknownKeys + 1)
      next = where;
  }
  if (unknown > kUnknownKeys)
    problems.error("unknown-key", next,
                   "and " + std::to_string(unknown - kUnknownKeys) + " more keys are not known here");
}

}  // namespace polyarm
