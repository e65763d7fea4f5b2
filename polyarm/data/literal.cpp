#include "polyarm/data/literal.hpp"

#include <cctype>
#include <cmath>
#include <memory>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/data/format_parts.hpp"

namespace polyarm::data {

namespace {
constexpr int kDeepest = 32;

bool is_name_char(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || static_cast<unsigned char>(c) >= 0x80;
}

/// A plain name unchanged, any other in quotes.
std::string name_text(const std::string& name) {
  bool plain = !name.empty() && !std::isdigit(static_cast<unsigned char>(name.front()));
  for (const char c : name) plain = plain && is_name_char(c);
  return plain ? name : quoted(name);
}

std::string joints_text(const JointState& joints) {
  std::string out;
  for (std::size_t i = 0; i < joints.positions.size(); ++i) {
    out += i ? ", " : "";
    if (i < joints.names.size()) out += name_text(joints.names[i]) + " = ";
    out += format_number(joints.positions[i]);
  }
  return "joints(" + out + ")";
}

std::string pose_text(const Point& point) {
  std::string out;
  for (const double number : numbers_of(point)) out += (out.empty() ? "" : ", ") + format_number(number);
  if (const std::string taught = point.taught ? taught_text(*point.taught) : ""; !taught.empty())
    out += ", " + taught;
  return (point.quaternion_given ? "quat(" : "pose(") + out + ")";
}

/// One pass over the text; the first error ends it.
class Reader {
 public:
  Reader(std::string_view text, std::string& why) : text_(text), why_(why) {}

  std::optional<Value> whole() {
    auto value = read(0);
    if (value && !at_end()) return fail("'" + std::string(text_.substr(at_, 20)) + "' is left over");
    return value;
  }

  bool taught(Taught& out) {
    while (!at_end()) {
      std::string key;
      if (!name(key) || !expect('=')) return false;
      if (!fact(key, out, 0)) return false;
      if (!at_end() && !expect(',')) return false;
    }
    return true;
  }

 private:
  std::nullopt_t fail(const std::string& why) {
    if (why_.empty()) why_ = why;
    return std::nullopt;
  }
  void skip() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  bool at_end() {
    skip();
    return at_ >= text_.size();
  }
  bool next_is(char c) {
    skip();
    return at_ < text_.size() && text_[at_] == c;
  }
  bool take(char c) {
    if (!next_is(c)) return false;
    ++at_;
    return true;
  }
  bool expect(char c) {
    if (take(c)) return true;
    fail(std::string("a '") + c + "' is missing before '" + std::string(text_.substr(at_, 20)) + "'");
    return false;
  }

  bool name(std::string& out) {
    skip();
    if (next_is('"')) {
      const auto text = read_text();
      if (text) out = *text;
      return text.has_value();
    }
    const std::size_t start = at_;
    while (at_ < text_.size() && is_name_char(text_[at_])) ++at_;
    out = text_.substr(start, at_ - start);
    if (!out.empty()) return true;
    fail("a name is missing before '" + std::string(text_.substr(at_, 20)) + "'");
    return false;
  }

  std::optional<std::string> read_text() {
    std::string out;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      char c = text_[at_];
      if (c == '\\' && at_ + 1 < text_.size()) {
        const char code = text_[++at_];
        if (code == 'u') {
          if (!read_code_point(out)) return fail("\\u needs four hexadecimal digits");
          continue;
        }
        c = code == 'n' ? '\n' : code == 'r' ? '\r' : code == 't' ? '\t' : code;
      }
      out += c;
    }
    if (at_ >= text_.size()) return fail("a quote is not closed");
    ++at_;
    return out;
  }

  /// After \u: reads four digits as in JSON and appends UTF-8; unpaired surrogates become the replacement
  /// character.
  bool read_code_point(std::string& out) {
    unsigned code = 0;
    for (int k = 0; k < 4; ++k) {
      const char digit = at_ + 1 < text_.size() ? text_[at_ + 1] : ' ';
      if (!std::isxdigit(static_cast<unsigned char>(digit))) return false;
      code = 16 * code + static_cast<unsigned>(std::isdigit(static_cast<unsigned char>(digit))
                                                   ? digit - '0'
                                                   : (digit | 32) - 'a' + 10);
      ++at_;
    }
    if (code >= 0xD800 && code < 0xE000) code = 0xFFFD;
    if (code < 0x80) {
      out += static_cast<char>(code);
    } else if (code < 0x800) {
      out += static_cast<char>(0xC0 | code >> 6);
      out += static_cast<char>(0x80 | (code & 63));
    } else {
      out += static_cast<char>(0xE0 | code >> 12);
      out += static_cast<char>(0x80 | (code >> 6 & 63));
      out += static_cast<char>(0x80 | (code & 63));
    }
    return true;
  }

  std::optional<Value> read(int depth) {
    if (depth > kDeepest) return fail("it is nested more than 32 deep");
    if (at_end()) return fail("a value is missing");
    const char c = text_[at_];
    if (c == '"') {
      const auto text = read_text();
      if (!text) return std::nullopt;
      return Value(*text);
    }
    if (c == '[') return list(depth);
    if (c == '{') return record(depth);
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '-' || c == '+' || c == '.') return number();
    return word(depth);
  }

  std::optional<Value> list(int depth) {
    List out;
    for (take('['); !take(']');) {
      if (!out.empty() && !expect(',')) return std::nullopt;
      auto item = read(depth + 1);
      if (!item) return std::nullopt;
      out.push_back(std::move(*item));
    }
    return Value(std::move(out));
  }

  std::optional<Value> record(int depth) {
    Record out;
    for (take('{'); !take('}');) {
      if (!out.names.empty() && !expect(',')) return std::nullopt;
      std::string key;
      if (!name(key) || (!take(':') && !expect('='))) return std::nullopt;
      if (out.find(key)) return fail("'" + key + "' occurs twice");
      auto value = read(depth + 1);
      if (!value) return std::nullopt;
      out.names.push_back(std::move(key));
      out.values.push_back(std::move(*value));
    }
    return Value(std::move(out));
  }

  std::optional<Value> number() {
    const std::size_t start = at_;
    while (at_ < text_.size() && std::string_view(",)]}= \t\r\n").find(text_[at_]) == std::string_view::npos)
      ++at_;
    const std::string_view written = text_.substr(start, at_ - start);
    if (const auto bare = parse_number(written)) return Value(*bare);
    for (int i = 0; i <= static_cast<int>(Dimension::angular_acceleration); ++i) {
      const auto dimension = static_cast<Dimension>(i);
      const auto value = parse_quantity(written, dimension);
      if (value && std::isfinite(*value)) return Value(Number{*value, dimension});
    }
    return fail("'" + std::string(written) + "' is not a number");
  }

  std::optional<Value> word(int depth) {
    std::string text;
    if (!name(text)) return std::nullopt;
    const std::string lowered = lower(text);
    if (lowered == "true") return Value(true);
    if (lowered == "false") return Value(false);
    if (lowered == "joints") return joints();
    if (lowered == "pose" || lowered == "quat") return pose(lowered == "quat", depth);
    return fail("'" + text + "' is not a value; put a text in quotes");
  }

  std::optional<double> plain(Dimension dimension) {
    skip();
    const auto value = number();
    if (!value) return std::nullopt;
    const Number n = *value->as_number();
    if (n.dimension != Dimension::none && n.dimension != dimension)
      return fail("a number has the unit of " + std::string(polyarm::name(n.dimension)));
    return n.value;
  }

  std::optional<Value> joints() {
    JointState out;
    if (!expect('(')) return std::nullopt;
    while (!take(')')) {
      if (!out.positions.empty() && !expect(',')) return std::nullopt;
      skip();
      const bool named = at_ < text_.size() &&
                         (text_[at_] == '"' || (is_name_char(text_[at_]) &&
                                                !std::isdigit(static_cast<unsigned char>(text_[at_]))));
      std::string joint;
      if (named && (!name(joint) || !expect('='))) return std::nullopt;
      const auto value = joint_number();
      if (!value) return std::nullopt;
      if (named) out.names.push_back(std::move(joint));
      out.note_given(out.positions.size(), value->dimension);
      out.positions.push_back(value->value);
    }
    if (!out.names.empty() && out.names.size() != out.positions.size())
      return fail("some joints have names and some do not");
    return Value(std::move(out));
  }

  /// An angle, or a length for a sliding joint.
  std::optional<Number> joint_number() {
    skip();
    const auto value = number();
    if (!value) return std::nullopt;
    const Dimension dimension = value->as_number()->dimension;
    if (dimension != Dimension::none && dimension != Dimension::angle && dimension != Dimension::length)
      return fail("a joint has an angle or a length");
    return *value->as_number();
  }

  std::optional<Value> pose(bool quaternion, int depth) {
    if (!expect('(')) return std::nullopt;
    std::vector<double> n;
    const std::size_t count = quaternion ? 7 : 6;
    while (n.size() < count) {
      if (!n.empty() && !expect(',')) return std::nullopt;
      const auto value = plain(n.size() < 3 ? Dimension::length
                               : quaternion ? Dimension::none
                                            : Dimension::angle);
      if (!value) return std::nullopt;
      n.push_back(*value);
    }
    Point out{pose_xyz_rpy({n[0], n[1], n[2]}, {n[3], n[4], n[5]}), quaternion};
    if (quaternion) {
      const double length = std::hypot(std::hypot(n[3], n[4]), std::hypot(n[5], n[6]));
      if (!(length > 1e-6)) return fail("a quaternion of zeros is not a rotation");
      const Quaternion q{n[3], n[4], n[5], n[6]};
      out.pose.rotation = std::abs(length - 1) < 1e-12 ? q : normalized(q);
    }
    Taught taught;
    while (!take(')')) {
      std::string key;
      if (!expect(',') || !name(key) || !expect('=') || !fact(key, taught, depth + 1)) return std::nullopt;
    }
    if (!(taught == Taught{})) out.taught = std::make_shared<Taught>(std::move(taught));
    return Value(std::move(out));
  }

  bool fact(const std::string& key, Taught& out, int depth) {
    const auto value = read(depth + 1);
    if (!value) return false;
    if (key == "joints" && value->as_joints())
      out.joints = *value->as_joints();
    else if (value->as_text() && (key == "frame" || key == "tool" || key == "robot"))
      (key == "frame" ? out.frame : key == "tool" ? out.tool : out.robot) = *value->as_text();
    else
      return fail("a point remembers frame, tool and robot (texts) and joints, not '" + key + "'"), false;
    return true;
  }

  std::string_view text_;
  std::string& why_;
  std::size_t at_ = 0;
};
}  // namespace

std::string literal(const Value& value) {
  if (const std::string* text = value.as_text()) return quoted(*text);
  if (value.as_boolean()) return *value.as_boolean() ? "true" : "false";
  if (const JointState* joints = value.as_joints()) return joints_text(*joints);
  if (const Point* point = value.as_point()) return pose_text(*point);
  std::string out;
  if (const List* list = value.as_list()) {
    for (const Value& item : *list) out += (out.empty() ? "" : ", ") + literal(item);
    return "[" + out + "]";
  }
  if (const Record* record = value.as_record()) {
    for (std::size_t i = 0; i < record->names.size(); ++i)
      out += (i ? ", " : "") + name_text(record->names[i]) + " = " + literal(record->values[i]);
    return "{" + out + "}";
  }
  return value.text();
}

std::optional<Value> parse_literal(std::string_view text, std::string& why) {
  why.clear();
  return Reader(text, why).whole();
}

std::string taught_text(const Taught& taught) {
  std::string out;
  const auto add = [&](const char* key, const std::string& text) {
    if (!text.empty()) out += (out.empty() ? "" : ", ") + std::string(key) + " = " + text;
  };
  add("frame", taught.frame.empty() ? "" : quoted(taught.frame));
  add("tool", taught.tool.empty() ? "" : quoted(taught.tool));
  add("robot", taught.robot.empty() ? "" : quoted(taught.robot));
  add("joints", taught.joints.positions.empty() ? "" : joints_text(taught.joints));
  return out;
}

bool parse_taught(std::string_view text, Taught& taught, std::string& why) {
  why.clear();
  return Reader(text, why).taught(taught);
}

}  // namespace polyarm::data
