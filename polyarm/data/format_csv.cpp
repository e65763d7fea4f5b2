/// Data sets in CSV with a header row.
#include <algorithm>
#include <memory>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/data/format_parts.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::data {

namespace {
const std::vector<std::string>& columns() {
  static const std::vector<std::string> names = {"name", "type",  "value", "x",     "y",      "z",
                                                 "rx",   "ry",    "rz",    "qx",    "qy",     "qz",
                                                 "qw",   "frame", "tool",  "robot", "joints", "group"};
  return names;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

std::vector<std::vector<std::string>> csv_rows(std::string_view text) {
  std::vector<std::vector<std::string>> rows(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& field = rows.back().back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      field += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && c == ',')
      rows.back().emplace_back();
    else if (!quoted && c == '\n')
      rows.emplace_back(1);
    else if (quoted || c != '\r')
      field += c;
  }
  return rows;
}

std::string csv_joints(const JointState& joints) {
  std::string out;
  for (std::size_t i = 0; i < joints.positions.size(); ++i)
    out += (i ? " " : "") + (i < joints.names.size() ? joints.names[i] + "=" : "") +
           format_number(joints.positions[i]);
  return out;
}

std::optional<JointState> read_csv_joints(const std::string& text) {
  JointState out;
  for (const std::string& word : split_words(text)) {
    const auto equals = word.rfind('=');
    if (equals != std::string::npos) out.names.push_back(word.substr(0, equals));
    const auto number = parse_number(equals == std::string::npos ? word : word.substr(equals + 1));
    if (!number) return std::nullopt;
    out.positions.push_back(*number);
  }
  if (!out.names.empty() && out.names.size() != out.positions.size()) return std::nullopt;
  return out;
}

class CsvReader {
 public:
  CsvReader(const std::string& file, DataSet& out, Problems& problems)
      : file_(file), out_(out), problems_(problems) {}

  void read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    const auto rows = csv_rows(text);
    for (const std::string& heading : rows.front()) headings_.push_back(lower(trim(heading)));
    if (std::find(headings_.begin(), headings_.end(), "name") == headings_.end())
      return problems_.error("bad-value", {file_, 1},
                             "the first line of a CSV names its columns, one of them 'name'",
                             "columns are " + join(columns(), ", "));
    for (std::size_t i = 1; i < rows.size(); ++i) {
      row_ = &rows[i];
      line_ = static_cast<int>(i) + 1;
      if (row_->size() > 1 || !trim(row_->front()).empty()) read_row();
    }
  }

 private:
  std::string field(const char* column) const {
    const auto at = std::find(headings_.begin(), headings_.end(), column);
    const auto index = static_cast<std::size_t>(at - headings_.begin());
    return index < row_->size() && at != headings_.end() ? (*row_)[index] : std::string();
  }

  void read_row() {
    const std::string name(trim(field("name")));
    if (name.empty()) return problems_.error("no-name", {file_, line_}, "this row has no name");
    std::string why;
    if (auto value = read_value(lower(trim(field("type"))), why))
      keep(name, std::move(*value));
    else
      problems_.error("bad-value", {file_, line_}, "'" + name + "' is not a value: " + why);
  }

  void keep(const std::string& name, Value value) {
    out_.set(name, std::move(value), {file_, line_});
    const std::string group(trim(field("group")));
    collect(problems_, [&] { check_group(group); });
    out_.set_group(name, group);
  }

  std::optional<Value> read_value(const std::string& type, std::string& why) {
    const std::string written = field("value");
    if (type == "text") return Value(written);
    if (type == "pose" || (type.empty() && !trim(field("x")).empty())) return read_pose(why);
    const std::string joints = field("joints");
    if (type == "joint state" || type == "joints" || (type.empty() && !trim(joints).empty())) {
      if (const auto state = read_csv_joints(joints)) return Value(*state);
      why = "'" + joints + "' is not a list of JOINT=POSITION";
      return std::nullopt;
    }
    auto value = parse_literal(trim(written), why);
    if (!value && type.empty()) return Value(written);
    return value;
  }

  std::optional<Value> read_pose(std::string& why) {
    const bool quaternion = !trim(field("qw")).empty();
    std::vector<double> n;
    for (const char* column : quaternion ? std::vector<const char*>{"x", "y", "z", "qx", "qy", "qz", "qw"}
                                         : std::vector<const char*>{"x", "y", "z", "rx", "ry", "rz"}) {
      const auto number = parse_quantity(field(column), n.size() < 3 ? Dimension::length
                                                        : quaternion ? Dimension::none
                                                                     : Dimension::angle);
      if (!number) {
        why = std::string("its ") + column + " is '" + field(column) + "', no number";
        return std::nullopt;
      }
      n.push_back(*number);
    }
    auto point = point_from(n);
    if (!point) {
      why = "its quaternion is not valid";
      return std::nullopt;
    }
    Taught taught{field("frame"), field("tool"), field("robot"),
                  read_csv_joints(field("joints")).value_or(JointState{})};
    if (!(taught == Taught{})) point->taught = std::make_shared<Taught>(taught);
    return Value(*point);
  }

  const std::string& file_;
  DataSet& out_;
  Problems& problems_;
  std::vector<std::string> headings_;
  const std::vector<std::string>* row_ = nullptr;
  int line_ = 0;
};
}  // namespace

std::string write_csv(const DataSet& set) {
  std::string out = join(columns(), ",") + "\n";
  for (const Entry& entry : set.entries()) {
    std::vector<std::string> row(columns().size());
    row[0] = entry.name;
    row[17] = entry.group;
    const std::string type = name(entry.value.kind());
    row[1] = type.substr(type.find(' ') + 1);
    if (const Point* point = entry.value.as_point()) {
      const std::vector<double> n = numbers_of(*point);
      for (std::size_t k = 0; k < n.size(); ++k)
        row[3 + k + (point->quaternion_given && k >= 3 ? 3 : 0)] = format_number(n[k]);
      if (const Taught* taught = point->taught.get())
        row[13] = taught->frame, row[14] = taught->tool, row[15] = taught->robot,
        row[16] = csv_joints(taught->joints);
    } else if (const JointState* joints = entry.value.as_joints()) {
      row[16] = csv_joints(*joints);
    } else {
      row[2] = entry.value.as_text() ? *entry.value.as_text() : literal(entry.value);
    }
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) line += (k ? "," : "") + csv_field(row[k]);
    out += line + "\n";
  }
  return out;
}

void read_csv(std::string_view text, const std::string& file, DataSet& out, Problems& problems) {
  CsvReader(file, out, problems).read(text);
}

}  // namespace polyarm::data
