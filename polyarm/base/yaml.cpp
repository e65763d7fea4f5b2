#include "polyarm/base/yaml.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm {

struct Yaml::Data {
  YAML::Node node;
  std::shared_ptr<const std::string> file;
  std::string key{};  ///< that it stands behind; of an item of a list the list's

  /// For messages: "'hardware'", or "this" where nobody knows the key.
  static std::string named(const std::shared_ptr<const Data>& data) {
    return data && !data->key.empty() ? "'" + data->key + "'" : "this";
  }
  /// "a list of 2 values"
  static std::string kind(const std::shared_ptr<const Data>& data) {
    if (!data || !data->node.IsDefined() || data->node.IsNull()) return "empty";
    if (data->node.IsMap()) return "a map of keys";
    if (!data->node.IsSequence()) return "'" + data->node.Scalar() + "'";
    const std::size_t size = data->node.size();
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
constexpr int kDeepest = bounds::kYamlNesting;
/// Unknown keys of one map that are named; of the others the number is told.
using bounds::kUnknownKeys;
/// Values of a file, where one that is named by aliases counts as often as it stands.
constexpr std::size_t kMostValues = bounds::kYamlValues;

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
/// How many values a document has when every alias is written out, without writing it out.
class Extent : public YAML::EventHandler {
 public:
  bool too_large() const { return total_ > kMostValues; }
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t anchor) override { leaf(anchor); }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t anchor, const std::string&) override {
    leaf(anchor);
  }
  void OnAlias(const YAML::Mark&, YAML::anchor_t anchor) override {
    const auto known = sizes_.find(anchor);
    add(known == sizes_.end() ? 1 : known->second);
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.emplace_back(anchor, 1);
  }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.emplace_back(anchor, 1);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  void add(std::size_t values) {
    std::size_t& sum = open_.empty() ? total_ : open_.back().second;
    sum = std::min(sum + values, kMostValues + 1);
  }
  void leaf(YAML::anchor_t anchor) {
    if (anchor != 0) sizes_[anchor] = 1;
    add(1);
  }
  void close() {
    const auto [anchor, values] = open_.back();
    open_.pop_back();
    if (anchor != 0) sizes_[anchor] = values;
    add(values);
  }
  std::vector<std::pair<YAML::anchor_t, std::size_t>> open_;
  std::map<YAML::anchor_t, std::size_t> sizes_;
  std::size_t total_ = 0;
};

/// A few lines of aliases of aliases stand for more values than any machine holds.
void check_extent(const std::string& text, const std::string& file) {
  if (text.find('*') == std::string::npos || text.find('&') == std::string::npos) return;
  std::istringstream in(text);
  YAML::Parser parser(in);
  Extent extent;
  while (parser.HandleNextDocument(extent)) {
  }
  if (extent.too_large())
    throw Error(Problem{"too-large",
                        {file},
                        "with its aliases written out the file has more than " + std::to_string(kMostValues) +
                            " values",
                        "name fewer aliases within what other aliases name"});
}
}  // namespace

Yaml Yaml::parse(std::string_view text, std::string name) {
  auto file = std::make_shared<const std::string>(std::move(name));
  check_depth(std::string(text), *file);
  try {
    check_extent(std::string(text), *file);
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
      out.data_ = std::make_shared<const Data>(Data{entry.second, data_->file, std::string(key)});
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
    out.back().value.data_ =
        std::make_shared<const Data>(Data{entry.second, data_->file, entry.first.Scalar()});
  }
  return out;
}

std::vector<Yaml> Yaml::items() const {
  std::vector<Yaml> out;
  if (!defined()) return out;
  if (!is_list()) return {*this};
  for (const auto& item : data_->node) {
    Yaml child;
    child.data_ = std::make_shared<const Data>(Data{item, data_->file, data_->key});
    out.push_back(child);
  }
  return out;
}

std::string Yaml::tag() const {
  const std::string out = defined() ? data_->node.Tag() : std::string();
  return out == "?" || out == "!" ? std::string() : out;
}

std::string Yaml::text() const {
  if (is_scalar()) return data_->node.Scalar();
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
      Data::named(data_) + " is '" + shortened(value) + "', " + polyarm::name(dimension) + " was expected", advice});
}

double Yaml::number(Dimension dimension, double fallback) const {
  return defined() ? number(dimension) : fallback;
}

bool Yaml::boolean() const {
  const std::string value = lower(text());
  if (value == "true" || value == "yes" || value == "on") return true;
  if (value == "false" || value == "no" || value == "off") return false;
  throw Error(Problem{
      "bad-value", where(), Data::named(data_) + " is '" + shortened(value) + "', true or false was expected", {}});
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
                        Data::named(data_) + " takes three numbers, here are " + std::to_string(v.size()),
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
    throw Error(
        Problem{"bad-value", where(),
                Data::named(data_) + " is a pose of 3, 6 or 7 numbers, here are " + std::to_string(v.size()),
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
  if (!is_map()) return;
  std::size_t unknown = 0;
  Location next;
  for (const auto& entry : data_->node) {
    if (!entry.first.IsScalar()) continue;
    const std::string& key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const Location where = place(entry.first.Mark(), *data_->file);
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
