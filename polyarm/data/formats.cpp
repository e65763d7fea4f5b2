#include "polyarm/data/formats.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::data {

namespace {
// --- JSON and YAML: plain values, and maps with a key that says what they are ---

std::string json_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (c == '\n')
      out += "\\n";
    else if (c == '\r')
      out += "\\r";
    else if (c == '\t')
      out += "\\t";
    else if (static_cast<unsigned char>(c) < 0x20)
      out += "\\u00" + std::string(1, "01"[c >> 4]) + "0123456789abcdef"[c & 15];
    else
      out += c;
  }
  return out + "\"";
}

std::string json_numbers(const std::vector<double>& numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + format_number(number);
  return "[" + out + "]";
}

std::string json_joints(const JointState& joints) {
  if (joints.names.empty()) return json_numbers(joints.positions);
  std::string out;
  for (std::size_t i = 0; i < joints.names.size(); ++i)
    out += (i ? ", " : "") + json_text(joints.names[i]) + ": " + format_number(joints.positions[i]);
  return "{" + out + "}";
}

std::vector<double> numbers_of(const Point& point) {
  const Vec3& p = point.pose.position;
  const Quaternion& q = point.pose.rotation;
  if (point.quaternion_given) return {p.x, p.y, p.z, q.x, q.y, q.z, q.w};
  const Vec3 rpy = to_rpy(q);
  return {p.x, p.y, p.z, rpy.x, rpy.y, rpy.z};
}

std::string json_of(const Value& value);

std::string json_point(const Point& point) {
  std::string out = std::string("{\"") + (point.quaternion_given ? "quaternion" : "pose") +
                    "\": " + json_numbers(numbers_of(point));
  if (const Taught* taught = point.taught.get()) {
    for (const auto& [key, text] :
         {std::pair{"frame", &taught->frame}, {"tool", &taught->tool}, {"robot", &taught->robot}})
      if (!text->empty()) out += std::string(", \"") + key + "\": " + json_text(*text);
    if (!taught->joints.positions.empty()) out += ", \"joints\": " + json_joints(taught->joints);
  }
  return out + "}";
}

std::string json_of(const Value& value) {
  if (const bool* flag = value.as_boolean()) return *flag ? "true" : "false";
  if (const std::string* text = value.as_text()) return json_text(*text);
  if (const JointState* joints = value.as_joints()) return "{\"joints\": " + json_joints(*joints) + "}";
  if (const Point* point = value.as_point()) return json_point(*point);
  if (const Number* number = value.as_number())
    return number->dimension == Dimension::none
               ? format_number(number->value)
               : "{\"number\": " + format_number(number->value) +
                     ", \"unit\": " + json_text(unit_text(number->dimension)) + "}";
  std::string out;
  if (const List* list = value.as_list()) {
    for (const Value& item : *list) out += (out.empty() ? "" : ", ") + json_of(item);
    return "[" + out + "]";
  }
  const Record& record = *value.as_record();
  for (std::size_t i = 0; i < record.names.size(); ++i)
    out += (i ? ", " : "") + json_text(record.names[i]) + ": " + json_of(record.values[i]);
  return "{\"record\": {" + out + "}}";
}

std::optional<std::vector<double>> plain_numbers(const Value& value) {
  if (!value.as_list()) return std::nullopt;
  std::vector<double> out;
  for (const Value& item : *value.as_list()) {
    if (!item.as_number()) return std::nullopt;
    out.push_back(item.as_number()->value);
  }
  return out;
}

std::optional<JointState> joints_from(const Value& value) {
  if (const auto numbers = plain_numbers(value)) return JointState{{}, *numbers};
  if (!value.as_record()) return std::nullopt;
  JointState out{value.as_record()->names, {}};
  for (const Value& item : value.as_record()->values) {
    if (!item.as_number()) return std::nullopt;
    out.positions.push_back(item.as_number()->value);
  }
  return out;
}

/// Six or seven numbers; a quaternion is made one.
std::optional<Point> point_from(const std::vector<double>& n) {
  if (n.size() != 6 && n.size() != 7) return std::nullopt;
  for (const double number : n)
    if (!std::isfinite(number)) return std::nullopt;
  Point out{pose_xyz_rpy({n[0], n[1], n[2]}, {n[3], n[4], n[5]}), n.size() == 7};
  if (n.size() == 6) return out;
  const Quaternion q{n[3], n[4], n[5], n[6]};
  const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
  if (!(length > 1e-6)) return std::nullopt;
  out.pose.rotation = std::abs(length - 1) < 1e-12 ? q : normalized(q);
  return out;
}

/// The numbers under these names, where all of them stand there.
std::optional<std::vector<double>> named_numbers(const Record& record,
                                                 std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const char* name : names) {
    const Value* value = record.find(name);
    if (!value || !value->as_number()) return std::nullopt;
    out.push_back(value->as_number()->value);
  }
  return out;
}

std::optional<Value> typed_record(const Record& record, std::string& why);

/// What JSON and YAML wrote plainly, as what it means; nothing, and why, where it means nothing.
std::optional<Value> typed(const Value& plain, std::string& why) {
  if (const Record* record = plain.as_record()) return typed_record(*record, why);
  if (!plain.as_list()) return plain;
  List out;
  for (const Value& item : *plain.as_list()) {
    auto value = typed(item, why);
    if (!value) return std::nullopt;
    out.push_back(std::move(*value));
  }
  return Value(std::move(out));
}

std::optional<Value> typed_fields(const Record& record, std::string& why) {
  Record out;
  for (std::size_t i = 0; i < record.names.size(); ++i) {
    auto value = typed(record.values[i], why);
    if (!value) return std::nullopt;
    out.names.push_back(record.names[i]);
    out.values.push_back(std::move(*value));
  }
  return Value(std::move(out));
}

std::optional<Value> typed_point(const Record& record, const std::vector<double>& numbers, std::string& why) {
  auto point = point_from(numbers);
  if (!point) {
    why = "a pose has 6 numbers (x y z roll pitch yaw) or 7 (x y z qx qy qz qw)";
    return std::nullopt;
  }
  Taught taught;
  for (const auto& [key, text] :
       {std::pair{"frame", &taught.frame}, {"tool", &taught.tool}, {"robot", &taught.robot}})
    if (const Value* value = record.find(key); value && value->as_text()) *text = *value->as_text();
  if (const Value* value = record.find("joints"))
    if (const auto joints = joints_from(*value)) taught.joints = *joints;
  if (!(taught == Taught{})) point->taught = std::make_shared<Taught>(taught);
  return Value(*point);
}

std::optional<Value> typed_record(const Record& record, std::string& why) {
  for (const char* key : {"pose", "quaternion"})
    if (const Value* value = record.find(key)) {
      const auto numbers = plain_numbers(*value);
      return typed_point(record, numbers.value_or(std::vector<double>{}), why);
    }
  if (const auto numbers = named_numbers(record, {"x", "y", "z", "qx", "qy", "qz", "qw"}))
    return typed_point(record, *numbers, why);
  if (const auto numbers = named_numbers(record, {"x", "y", "z", "rx", "ry", "rz"}))
    return typed_point(record, *numbers, why);
  const Value* number = record.find("number");
  const Value* unit = record.find("unit");
  if (number && unit && number->as_number() && unit->as_text()) {
    const Unit* known = find_unit(*unit->as_text());
    if (known) return Value(Number{number->as_number()->value * known->scale, known->dimension});
    why = "'" + *unit->as_text() + "' is no unit";
    return std::nullopt;
  }
  if (const Value* joints = record.find("joints"); joints && record.names.size() == 1)
    if (const auto state = joints_from(*joints)) return Value(*state);
  if (const Value* inner = record.find("record"); inner && inner->as_record() && record.names.size() == 1)
    return typed_fields(*inner->as_record(), why);
  return typed_fields(record, why);
}

/// Takes `polyarm` and `values` off where they are there.
void read_tree(const Value& tree, const std::string& file, DataSet& out, Problems& problems) {
  const Record* record = tree.as_record();
  if (!record) return problems.error("bad-value", {file}, "a map of names and values is expected here");
  const Value* version = record->find("polyarm");
  if (version && version->text() != "data/1")
    return problems.error("bad-version", {file},
                          "'" + version->text() + "' is no kind of file that is read here",
                          "this version reads `polyarm: data/1`");
  if (const Value* values = record->find("values"); values && values->as_record())
    record = values->as_record();
  for (std::size_t i = 0; i < record->names.size(); ++i) {
    std::string why;
    if (record->names[i] == "polyarm") continue;
    if (const auto value = typed(record->values[i], why))
      out.set(record->names[i], *value);
    else
      problems.error("bad-value", {file}, "'" + record->names[i] + "' is no value: " + why);
  }
}

Value tree_of(const Yaml& node) {
  if (node.is_map()) {
    Record out;
    for (const Yaml::Entry& entry : node.entries()) {
      out.names.push_back(entry.key);
      out.values.push_back(entry.value.defined() ? tree_of(entry.value) : Value(""));
    }
    return out;
  }
  if (node.is_list()) {
    List out;
    for (const Yaml& item : node.items()) out.push_back(tree_of(item));
    return out;
  }
  const std::string text = node.text();
  std::string ignored;
  const auto value = parse_literal(text, ignored);
  return value && (value->as_boolean() || value->as_number()) ? *value : Value(text);
}

// --- CSV, with names over the columns ---

const std::vector<std::string>& columns() {
  static const std::vector<std::string> names = {"name", "type",  "value", "x",     "y",     "z",
                                                 "rx",   "ry",    "rz",    "qx",    "qy",    "qz",
                                                 "qw",   "frame", "tool",  "robot", "joints"};
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

std::string write_csv(const DataSet& set) {
  std::string out = join(columns(), ",") + "\n";
  for (const Entry& entry : set.entries()) {
    std::vector<std::string> row(columns().size());
    row[0] = entry.name;
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
      out_.set(name, std::move(*value), {file_, line_});
    else
      problems_.error("bad-value", {file_, line_}, "'" + name + "' is no value: " + why);
  }

  std::optional<Value> read_value(const std::string& type, std::string& why) {
    const std::string written = field("value");
    if (type == "text") return Value(written);
    if (type == "pose" || (type.empty() && !trim(field("x")).empty())) return read_pose(why);
    const std::string joints = field("joints");
    if (type == "joint state" || type == "joints" || (type.empty() && !trim(joints).empty())) {
      if (const auto state = read_csv_joints(joints)) return Value(*state);
      why = "'" + joints + "' is no list of JOINT=POSITION";
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
      why = "its quaternion is none";
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

// --- SRDF ---

void read_srdf(std::string_view text, const std::string& file, DataSet& out, Problems& problems) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS || !document.RootElement())
    return problems.error("bad-xml", {file, document.ErrorLineNum()}, "this is no SRDF: it is no XML");
  for (auto* state = document.RootElement()->FirstChildElement("group_state"); state;
       state = state->NextSiblingElement("group_state")) {
    JointState joints;
    bool good = state->Attribute("name") != nullptr;
    for (auto* joint = state->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
      const char* const value = joint->Attribute("value");
      const auto number = value ? parse_number(value) : std::nullopt;
      good = good && joint->Attribute("name") && number;
      if (!good) break;
      joints.names.emplace_back(joint->Attribute("name"));
      joints.positions.push_back(*number);
    }
    if (good && !joints.names.empty())
      out.set(state->Attribute("name"), joints, {file, state->GetLineNum()});
    else
      problems.error("bad-value", {file, state->GetLineNum()},
                     "this group_state has no name, or a joint without name and value");
  }
}

std::string write_srdf(const DataSet& set, const std::string& group, Problems& problems) {
  tinyxml2::XMLPrinter out;
  out.OpenElement("robot");
  out.PushAttribute("name", group.c_str());
  for (const Entry& entry : set.entries()) {
    const JointState* joints = entry.value.as_joints();
    if (!joints || joints->names.empty()) {
      problems.warning("cannot-keep", entry.where,
                       "'" + entry.name + "' is " + name(entry.value.kind()) +
                           "; an SRDF holds joint states with names only, it is left out");
      continue;
    }
    out.OpenElement("group_state");
    out.PushAttribute("name", entry.name.c_str());
    out.PushAttribute("group", group.c_str());
    for (std::size_t i = 0; i < joints->names.size(); ++i) {
      out.OpenElement("joint");
      out.PushAttribute("name", joints->names[i].c_str());
      out.PushAttribute("value", format_number(joints->positions[i]).c_str());
      out.CloseElement();
    }
    out.CloseElement();
  }
  out.CloseElement();
  return out.CStr();
}
}  // namespace

SetForm form_of_file(const std::string& file) {
  const auto dot = file.rfind('.');
  const auto form = form_named(lower(dot == std::string::npos ? "" : file.substr(dot + 1)));
  return form.value_or(SetForm::text);
}

std::optional<SetForm> form_named(std::string_view name) {
  if (name == "text" || name == "data" || name == "points" || name == "txt") return SetForm::text;
  if (name == "csv") return SetForm::csv;
  if (name == "json") return SetForm::json;
  if (name == "yaml" || name == "yml") return SetForm::yaml;
  if (name == "srdf" || name == "xml") return SetForm::srdf;
  return std::nullopt;
}

DataSet read_form(std::string_view text, SetForm form, const std::string& file, Problems& problems) {
  DataSet out;
  if (const auto why = why_not_text(text)) {
    problems.error("not-text", {file}, *why);
    return out;
  }
  switch (form) {
    case SetForm::text:
      return ImportFile::parse(text, file, problems).values();
    case SetForm::csv:
      CsvReader(file, out, problems).read(text);
      break;
    case SetForm::json: {
      std::string why;
      if (const auto tree = parse_literal(text, why))
        read_tree(*tree, file, out, problems);
      else
        problems.error("bad-json", {file}, "this is no JSON of values: " + why);
      break;
    }
    case SetForm::yaml:
      collect(problems, [&] { read_tree(tree_of(Yaml::parse(text, file)), file, out, problems); });
      break;
    case SetForm::srdf:
      read_srdf(text, file, out, problems);
      break;
  }
  return out;
}

std::string write_form(const DataSet& set, SetForm form, const std::string& group, Problems& problems) {
  if (form == SetForm::csv) return write_csv(set);
  if (form == SetForm::srdf) return write_srdf(set, group, problems);
  if (form == SetForm::text) {
    ImportFile out = ImportFile::parse("", "", problems);
    for (const Entry& entry : set.entries()) out.set(entry.name, entry.value);
    return out.text();
  }
  const bool json = form == SetForm::json;
  std::string out = json ? "{\"polyarm\": \"data/1\",\n \"values\": {" : "polyarm: data/1\nvalues:\n";
  for (std::size_t i = 0; i < set.entries().size(); ++i) {
    const Entry& entry = set.entries()[i];
    out += (json ? (i ? ",\n  " : "\n  ") : "  ") + json_text(entry.name) + ": " + json_of(entry.value) +
           (json ? "" : "\n");
  }
  return out + (json ? "\n}}\n" : "");
}

}  // namespace polyarm::data
