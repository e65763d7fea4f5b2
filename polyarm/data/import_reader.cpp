#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <unordered_map>

#include "polyarm/base/text.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/data/import_text.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::data {

namespace {
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
/// An angle above one and a half turns was probably meant in degrees.
constexpr double kImplausibleAngle = 2 * std::numbers::pi * 1.5;
constexpr std::size_t kMostProblems = 200;
using Form = PointFormat::Form;

const std::vector<std::string>& keys() {
  static const std::vector<std::string> list = {"Name", "Bool",  "Num",   "Text", "JS",
                                                "Pose", "Point", "Value", "Group"};
  return list;
}

/// The number of characters before byte `at`, plus one.
int column_of(std::string_view line, std::size_t at) {
  int column = 1;
  for (std::size_t i = 0; i < at && i < line.size(); ++i)
    if ((static_cast<unsigned char>(line[i]) & 0xC0) != 0x80) ++column;
  return column;
}

/// A number with any unit.
std::optional<Number> parse_any_quantity(std::string_view text) {
  if (const auto bare = parse_number(text)) return Number{*bare};
  for (int i = 0; i <= static_cast<int>(Dimension::angular_acceleration); ++i) {
    const auto dimension = static_cast<Dimension>(i);
    const auto number = parse_quantity(text, dimension);
    if (number && std::isfinite(*number)) return Number{*number, dimension};
  }
  return std::nullopt;
}
}  // namespace

std::string quote(std::string_view text) {
  constexpr std::size_t kMost = 60;
  std::string shown(text.substr(0, kMost));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  return "'" + shown + (text.size() > kMost ? "…'" : "'");
}

std::string header(const PointFormat& format) {
  switch (format.form) {
    case Form::none:
      return "";
    case Form::joints:
      return "JS: " + join(format.joints, " ");
    case Form::rpy:
      return "Pose: RPY";
    case Form::quaternion:
      return "Pose: Quaternion";
  }
  return "";
}

std::size_t comment_at(std::string_view line) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quoted && line[i] == '\\')
      ++i;
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == '#' && !quoted)
      return i;
  }
  return std::string_view::npos;
}

/// Reads line by line and tracks the name and point format in force.
class ImportReader {
 public:
  ImportReader(ImportFile& out, Problems& problems) : out_{out}, problems_{problems} {}

  void read(std::string_view text) {
    if (const auto why = why_not_text(text)) {
      problems_.error("not-text", {out_.file_}, *why);
      return;
    }
    split(text);
    for (line_ = 0; line_ < out_.lines_.size(); ++line_) read_line(out_.lines_[line_].text);
    finish_name();
    out_.last_format_ = format_;
  }

 private:
  void split(std::string_view text) {
    if (text.starts_with(kByteOrderMark)) {
      out_.mark_ = kByteOrderMark;
      text.remove_prefix(kByteOrderMark.size());
    }
    while (!text.empty()) {
      const auto end = text.find('\n');
      std::string_view line = text.substr(0, end);
      std::string ending = end == std::string_view::npos ? "" : "\n";
      if (!ending.empty() && line.ends_with('\r')) {
        line.remove_suffix(1);
        ending = "\r\n";
      }
      if (out_.lines_.empty() && !ending.empty()) out_.newline_ = ending;
      out_.lines_.push_back({std::string(line), ending});
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
  }

  void read_line(const std::string& line) {
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#') return;
    const auto colon = line.find(':');
    if (colon == std::string::npos) {
      const std::string word = split_words(content).front();
      return error(line, content, "bad-line",
                   quote(content) + " is not a line of data" + did_you_mean(word, keys()),
                   "write `Key: value`; keys are " + join(keys(), ", "));
    }
    const std::string_view key = trim(std::string_view(line).substr(0, colon));
    std::string_view value = std::string_view(line).substr(colon + 1);
    const std::string lowered = lower(key);
    if (lowered == "value" || lowered == "point")
      value = value.substr(0, comment_at(value));
    else if (lowered != "text" && lowered != "name")
      value = value.substr(0, value.find('#'));
    read_key(line, key, lowered, trim(value));
  }

  void read_key(const std::string& line, std::string_view key, const std::string& lowered,
                std::string_view value) {
    if (lowered == "name") return read_name(line, value);
    if (lowered == "js") return read_joint_names(line, value);
    if (lowered == "pose") return read_pose_form(line, value);
    if (lowered == "bool") return read_boolean(line, value);
    if (lowered == "num") return read_number(line, value);
    if (lowered == "text") return store(line, Value(std::string(value)));
    if (lowered == "point") return read_point(line, value);
    if (lowered == "value") return read_literal(line, value);
    if (lowered == "group") return read_group(line, value);
    error(line, key.empty() ? std::string_view(line) : key, "unknown-key",
          quote(key) + " is not a kind of data" + did_you_mean(key, keys()),
          "kinds are " + join(keys(), ", "));
  }

  void read_name(const std::string& line, std::string_view value) {
    finish_name();
    name_ = value;
    name_line_ = line_;
    name_used_ = false;
    groups_.clear();
    if (value.empty()) error(line, value, "no-name", "a name is missing after 'Name:'", "write `Name: Home`");
  }

  /// Warns if a name has no value.
  void finish_name() {
    if (name_.empty() || name_used_) return;
    problems_.warning("no-value", {out_.file_, static_cast<int>(name_line_) + 1, 1},
                      quote(name_) + " gets no value", "write a line such as `Bool: True` after it");
  }

  void read_joint_names(const std::string& line, std::string_view value) {
    auto joints = split_words(value, " \t,");
    auto sorted = joints;
    std::sort(sorted.begin(), sorted.end());
    if (joints.empty())
      error(line, value, "bad-joints", "no joints are named after 'JS:'", "write their names between blanks");
    if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
      error(line, value, "bad-joints", "the joint " + quote(*twice) + " is named twice");
    format_ = {Form::joints, std::move(joints)};
  }

  void read_pose_form(const std::string& line, std::string_view value) {
    static const std::vector<std::string> forms = {"RPY", "Quaternion"};
    if (equal_ignoring_case(value, forms[0])) {
      format_ = {Form::rpy, {}};
    } else if (equal_ignoring_case(value, forms[1])) {
      format_ = {Form::quaternion, {}};
    } else {
      format_ = {};
      format_broken_ = true;
      error(line, value, "bad-pose",
            quote(value) + " is no way to write a rotation" + did_you_mean(value, forms),
            "write `Pose: RPY` or `Pose: Quaternion`");
      return;
    }
    format_broken_ = false;
  }

  /// Reads a `Group:` line. It applies to the name whose value comes before or after it.
  void read_group(const std::string& line, std::string_view value) {
    if (name_.empty())
      return error(line, value, "no-name", "this group has no name", "write a line `Name: …` before it");
    group_ = value;
    ImportFile::Slot* slot = out_.slot_of(name_);
    if (!slot) return groups_.push_back(line_);
    slot->groups.push_back(line_);
    out_.values_.set_group(name_, group_);
  }

  void read_boolean(const std::string& line, std::string_view value) {
    static const std::vector<std::string> words = {"True", "False"};
    if (equal_ignoring_case(value, words[0])) return store(line, Value(true));
    if (equal_ignoring_case(value, words[1])) return store(line, Value(false));
    error(line, value, "bad-value", quote(value) + " is not a boolean" + did_you_mean(value, words),
          "write True or False");
    name_used_ = true;
  }

  void read_number(const std::string& line, std::string_view value) {
    if (const auto number = parse_any_quantity(value)) return store(line, Value(*number));
    error(line, value, "bad-value", quote(value) + " is not a number", "write such as 10, 0.5 or 40mm");
    name_used_ = true;
  }

  void read_literal(const std::string& line, std::string_view value) {
    std::string why;
    if (auto read = parse_literal(value, why)) return store(line, std::move(*read));
    error(line, value, "bad-value", quote(value) + " is not a value: " + why,
          "for example [1, 2], {name = \"x\", width = 40mm}, \"a text\"");
    name_used_ = true;
  }

  /// Reads the facts of a taught point, which follow its numbers.
  bool read_taught(const std::string& line, std::string_view facts) {
    Taught taught;
    std::string why;
    taught_.reset();
    if (!parse_taught(facts, taught, why)) {
      error(line, facts, "bad-point", "what this point remembers cannot be read: " + why,
            "for example ; frame = \"table\", tool = \"suction_cup\", robot = \"universal_robots/ur3\"");
      return false;
    }
    if (!(taught == Taught{})) taught_ = std::make_shared<Taught>(std::move(taught));
    return true;
  }

  void read_point(const std::string& line, std::string_view value) {
    name_used_ = true;
    taught_.reset();
    const auto facts = value.find(';');
    if (facts != std::string_view::npos) {
      if (!read_taught(line, trim(value.substr(facts + 1)))) return;
      value = trim(value.substr(0, facts));
    }
    if (format_.form == Form::none) {
      if (!format_broken_)
        error(line, value, "no-format", "a point needs a line 'JS:' or 'Pose:' before it",
              "write `Pose: RPY`, or `JS:` with the names of the joints");
      return;
    }
    const auto fields = split_fields(value, ',');
    const std::size_t expected = count(format_);
    if (value.empty() || fields.size() != expected)
      return error(line, value, "bad-point",
                   "this point has " + std::to_string(value.empty() ? 0 : fields.size()) + " numbers, " +
                       std::to_string(expected) + " were expected after '" + header(format_) + "'",
                   "write them between commas");
    std::vector<double> numbers;
    if (read_fields(line, value, fields, numbers)) store_point(line, value, numbers);
  }

  static std::size_t count(const PointFormat& format) {
    if (format.form == Form::joints) return format.joints.size();
    return format.form == Form::rpy ? 6 : 7;
  }

  bool is_angle(std::size_t index) const {
    return format_.form == Form::joints || (format_.form == Form::rpy && index >= 3);
  }

  bool read_fields(const std::string& line, std::string_view value, const std::vector<std::string>& fields,
                   std::vector<double>& numbers) {
    bool degrees = false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto number = read_field(fields[i], i);
      if (!number) {
        error_at(column_of(line, offset(line, value, i)), "bad-point",
                 quote(fields[i]) + " is not a number here, place " + std::to_string(i + 1) + " of the point",
                 "lengths are metres (or 40mm), angles radians (or 30deg)");
        continue;
      }
      numbers.push_back(*number);
      degrees = degrees || (is_angle(i) && std::abs(*number) > kImplausibleAngle);
    }
    if (degrees)
      problems_.warning("looks-like-degrees",
                        place(column_of(line, static_cast<std::size_t>(value.data() - line.data()))),
                        quote(value) + " looks like degrees", "angles without the unit deg are radians");
    return numbers.size() == fields.size();
  }

  std::optional<double> read_field(const std::string& field, std::size_t index) const {
    std::optional<double> number;
    if (is_angle(index)) number = parse_quantity(field, Dimension::angle);
    if (!number && !(format_.form == Form::rpy && index >= 3))
      number = parse_quantity(field, Dimension::length);
    if (number && !std::isfinite(*number)) number.reset();
    return number;
  }

  /// The column of field `index` of `value` in the line.
  static std::size_t offset(const std::string& line, std::string_view value, std::size_t index) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < index; ++i) at = value.find(',', at) + 1;
    const auto start = value.find_first_not_of(" \t", at);
    return static_cast<std::size_t>(value.data() - line.data()) +
           (start == std::string_view::npos ? at : start);
  }

  /// With the units that the numbers were written in.
  Value joint_state(std::string_view value, const std::vector<double>& n) const {
    JointState out{format_.joints, n};
    const auto fields = split_fields(value, ',');
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (parse_number(fields[i])) continue;
      out.note_given(i, parse_quantity(fields[i], Dimension::angle) ? Dimension::angle : Dimension::length);
    }
    return out;
  }

  void store_point(const std::string& line, std::string_view value, const std::vector<double>& n) {
    if (format_.form == Form::joints) return store(line, joint_state(value, n));
    const Vec3 position{n[0], n[1], n[2]};
    if (format_.form == Form::rpy)
      return store(line, Value(Point{pose_xyz_rpy(position, {n[3], n[4], n[5]}), false, taught_}));
    const double length = std::hypot(std::hypot(n[3], n[4]), std::hypot(n[5], n[6]));
    if (!(length > 1e-6) || !std::isfinite(length))
      return error(line, value, "bad-point", "the quaternion of this point is zero or not a rotation",
                   "no rotation is 0, 0, 0, 1");
    const bool unit = std::abs(length - 1) < 1e-12;
    const Quaternion q{n[3], n[4], n[5], n[6]};
    if (std::abs(length - 1) > 0.01)
      problems_.warning("not-unit", place(1),
                        "the quaternion of this point has length " + format_number(length) +
                            ", it was made a unit quaternion");
    store(line, Value(Point{{position, unit ? q : normalized(q)}, true, taught_}));
  }

  void store(const std::string& line, Value value) {
    name_used_ = true;
    if (name_.empty())
      return error(line, trim(line), "no-name", "this value has no name", "write a line `Name: …` before it");
    const int column = column_of(line, line.find_first_not_of(" \t"));
    const bool known = out_.values_.find(name_) != nullptr;
    if (const auto [at, is_new] = named_.try_emplace(name_, name_line_);
        !is_new && at->second != name_line_) {
      problems_.warning("duplicate-name", {out_.file_, static_cast<int>(name_line_) + 1, 1},
                        quote(name_) + " is defined twice, here and in line " +
                            std::to_string(at->second + 1) + "; the value here counts",
                        "rename one of them, or take it away");
      at->second = name_line_;
    }
    out_.values_.set(name_, std::move(value), place(column));
    if (!known) out_.slots_.push_back({name_, line_, format_, {}});
    ImportFile::Slot& slot = *out_.slot_of(name_);
    slot.line = line_;
    slot.format = format_;
    if (groups_.empty()) return;
    slot.groups.insert(slot.groups.end(), groups_.begin(), groups_.end());
    out_.values_.set_group(name_, group_);
    groups_.clear();
  }

  Location place(int column) const { return {out_.file_, static_cast<int>(line_) + 1, column}; }

  void error(const std::string& line, std::string_view part, std::string code, std::string what,
             std::string advice = {}) {
    const bool inside = part.data() >= line.data() && part.data() <= line.data() + line.size();
    error_at(column_of(line, inside ? static_cast<std::size_t>(part.data() - line.data()) : 0),
             std::move(code), std::move(what), std::move(advice));
  }

  void error_at(int column, std::string code, std::string what, std::string advice) {
    if (++count_ < kMostProblems)
      problems_.error(std::move(code), place(column), std::move(what), std::move(advice));
    if (count_ == kMostProblems)
      problems_.error("many-errors", place(column), "there are more errors in this file");
  }

  ImportFile& out_;
  Problems& problems_;
  PointFormat format_;
  bool format_broken_ = false;
  std::shared_ptr<const Taught> taught_;  ///< of the present point
  std::string name_, group_;
  std::vector<std::size_t> groups_;                     ///< group lines of the name, before its value
  std::unordered_map<std::string, std::size_t> named_;  ///< the last line `Name:` of each name with a value
  std::size_t name_line_ = 0, line_ = 0, count_ = 0;
  bool name_used_ = false;
};

ImportFile ImportFile::parse(std::string_view text, const std::string& file, Problems& problems) {
  ImportFile out;
  out.file_ = file;
  ImportReader(out, problems).read(text);
  return out;
}

}  // namespace polyarm::data
