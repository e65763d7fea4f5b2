#include "polyarm/data/import_format.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/import_text.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::data {

namespace {
using Form = PointFormat::Form;

std::vector<double> numbers_of(const Value& value, const PointFormat& format) {
  std::vector<double> out;
  if (const JointState* joints = value.as_joints()) {
    for (const std::string& joint : format.joints) out.push_back(*joints->find(joint));
    return out;
  }
  const Pose& pose = value.as_point()->pose;
  out = {pose.position.x, pose.position.y, pose.position.z};
  if (format.form == Form::quaternion) {
    const Quaternion& q = pose.rotation;
    out.insert(out.end(), {q.x, q.y, q.z, q.w});
  } else {
    const Vec3 rpy = to_rpy(pose.rotation);
    out.insert(out.end(), {rpy.x, rpy.y, rpy.z});
  }
  return out;
}

std::string point_line(const Value& value, const PointFormat& format) {
  std::string out;
  for (const double number : numbers_of(value, format))
    out += (out.empty() ? "" : ", ") + format_number(number);
  const Point* point = value.as_point();
  if (const std::string taught = point && point->taught ? taught_text(*point->taught) : ""; !taught.empty())
    out += "; " + taught;
  return "Point: " + out;
}

/// The format for `value` under the format `around`.
PointFormat format_for(const Value& value, const PointFormat& around) {
  if (const Point* point = value.as_point()) {
    if (around.form == Form::rpy || around.form == Form::quaternion) return around;
    return {point->quaternion_given ? Form::quaternion : Form::rpy, {}};
  }
  const JointState& joints = *value.as_joints();
  const bool same = around.form == Form::joints && around.joints.size() == joints.names.size() &&
                    std::all_of(around.joints.begin(), around.joints.end(),
                                [&](const std::string& joint) { return joints.find(joint) != nullptr; });
  return same ? around : PointFormat{Form::joints, joints.names};
}

bool keeps_as_joint_name(const std::string& joint) {
  return !joint.empty() && joint.find_first_of(" \t\r\n,#") == std::string::npos;
}

/// True if the format has no key for the value, so that it is written as a literal: `Value: …`.
bool is_awkward(const Value& value) {
  if (value.as_list() || value.as_record()) return true;
  if (const std::string* text = value.as_text())
    return text->find_first_of("\r\n") != std::string::npos || trim(*text) != *text;
  const JointState* joints = value.as_joints();
  return joints && (joints->names.empty() ||
                    !std::all_of(joints->names.begin(), joints->names.end(), keeps_as_joint_name));
}

bool is_finite(const Value& value) {
  const auto all = [](const List& list) { return std::all_of(list.begin(), list.end(), is_finite); };
  if (const Number* number = value.as_number()) return std::isfinite(number->value);
  if (const List* list = value.as_list()) return all(*list);
  if (const Record* record = value.as_record()) return all(record->values);
  const auto finite = [](double number) { return std::isfinite(number); };
  if (const JointState* joints = value.as_joints())
    return std::all_of(joints->positions.begin(), joints->positions.end(), finite);
  if (const Point* point = value.as_point()) {
    const Pose& p = point->pose;
    const double all_of_it[] = {p.position.x, p.position.y, p.position.z, p.rotation.x,
                                p.rotation.y, p.rotation.z, p.rotation.w};
    return std::all_of(std::begin(all_of_it), std::end(all_of_it), finite);
  }
  return true;
}

std::string plain_line(const Value& value) {
  if (is_awkward(value)) return "Value: " + literal(value);
  if (value.as_boolean()) return "Bool: " + value.text();
  if (value.as_number()) return "Num: " + value.text();
  return *value.as_text() == "" ? "Text:" : "Text: " + value.text();
}

/// " # why" at the end of a line whose value is neither a name nor a text.
std::string comment_of(const std::string& line) {
  const std::string key = lower(trim(std::string_view(line).substr(0, line.find(':'))));
  const auto at = comment_at(line);
  if (key == "text" || key == "name" || at == std::string::npos) return "";
  const auto start = line.find_last_not_of(" \t", at - 1);
  const auto first = start == std::string::npos ? 0 : start + 1;
  return line.substr(first, line.find_first_of("\r\n", at) - first);
}
}  // namespace

std::optional<std::string> why_not_text(std::string_view content) {
  if (content.size() > 1 && content[0] == '\x80' && content[1] > 1 && content[1] < 6)
    return "this is a Python pickle, which is never read because reading one can run any program; export it "
           "as text";
  if (content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF"))
    return "this text is in UTF-16; save it as UTF-8";
  if (content.find('\0') != std::string_view::npos) return "this is a binary file, a text file was expected";
  return std::nullopt;
}

void check_can_keep(const std::string& name, const Value& value, const std::string& file) {
  const auto refuse = [&](const std::string& why) {
    throw Error(Problem{"cannot-keep", {file}, quote(name) + " cannot be kept in this file: " + why, {}});
  };
  if (name.empty() || trim(name) != name || name.find_first_of("\r\n") != std::string::npos)
    refuse("a name here is one line without blanks around it");
  if (!is_finite(value)) refuse("it has a number that is not finite");
  if (const std::string* text = value.as_text(); text && why_not_text(*text)) refuse("it is not a text");
  if (const JointState* joints = value.as_joints();
      joints && !joints->names.empty() && joints->names.size() != joints->positions.size())
    refuse("its joints do not all have a name and a position");
}

void check_group(const std::string& group) {
  if (group.size() <= 64 && trim(group) == group && group.find_first_of("\r\n#") == std::string::npos) return;
  throw Error("bad-group", quote(group) + " is not a name of a group",
              "one line of at most 64 letters, without # and without blanks around it");
}

ImportFile ImportFile::load(const std::string& path) {
  Problems problems;
  ImportFile out = parse(read_file(path, bounds::kDataBytes), path, problems);
  problems.throw_if_errors();
  out.warnings_ = problems.list();
  return out;
}

std::string ImportFile::block(const Value& value, const PointFormat& format,
                              const std::string& old_line) const {
  const std::string indent = old_line.substr(0, old_line.find_first_not_of(" \t"));
  if (!value.is_place() || is_awkward(value)) return indent + plain_line(value) + comment_of(old_line);
  const PointFormat own = format_for(value, format);
  const std::string line = indent + point_line(value, own) + comment_of(old_line);
  if (own == format) return line;
  const std::string after = header(format);
  return indent + header(own) + newline_ + line + (after.empty() ? "" : newline_ + indent + after);
}

void ImportFile::set(const std::string& name, const Value& value) {
  const Value* present = values_.value(name);
  if (present && *present == value) return;
  check_can_keep(name, value, file_);
  const Slot* slot = slot_of(name);
  if (!slot) return append(name, value);
  Line& line = lines_[slot->line];
  line.text = block(value, slot->format, line.text);
  Problems none;
  const std::string text = header(slot->format) + "\nName: " + name + "\n" + line.text;
  values_.set(name, *parse(text, file_, none).values().value(name));
}

void ImportFile::append(const std::string& name, const Value& value) {
  if (!lines_.empty() && lines_.back().ending.empty()) lines_.back().ending = newline_;
  const std::string written = block(value, last_format_, "");
  lines_.push_back({"Name: " + name, newline_});
  lines_.push_back({written, newline_});
  slots_.push_back({name, lines_.size() - 1, last_format_, {}});
  Problems none;
  const std::string text = header(last_format_) + "\nName: " + name + "\n" + written;
  values_.set(name, *parse(text, file_, none).values().value(name));
}

ImportFile::Slot* ImportFile::slot_of(const std::string& name) {
  const auto at = std::find_if(slots_.rbegin(), slots_.rend(), [&](const Slot& s) { return s.name == name; });
  return at == slots_.rend() ? nullptr : &*at;
}

void ImportFile::insert_line(std::size_t at, const std::string& text) {
  lines_.insert(lines_.begin() + static_cast<std::ptrdiff_t>(at), {text, newline_});
  for (Slot& slot : slots_) {
    if (slot.line >= at) ++slot.line;
    for (std::size_t& line : slot.groups)
      if (line >= at) ++line;
  }
}

void ImportFile::erase_line(std::size_t at) {
  lines_.erase(lines_.begin() + static_cast<std::ptrdiff_t>(at));
  for (Slot& slot : slots_) {
    if (slot.line > at) --slot.line;
    std::erase(slot.groups, at);
    for (std::size_t& line : slot.groups)
      if (line > at) --line;
  }
}

void ImportFile::set_group(const std::string& name, const std::string& group) {
  check_group(group);
  Slot* slot = slot_of(name);
  if (!slot)
    throw Error(Problem{
        "unknown-name", {file_}, "there is no " + quote(name) + did_you_mean(name, values_.names()), {}});
  if (values_.find(name)->group == group) return;
  const std::size_t at = slot->groups.empty() ? slot->line : slot->groups.front();
  const std::string& old = lines_[at].text;
  const std::string text = old.substr(0, old.find_first_not_of(" \t")) + "Group: " + group +
                           (slot->groups.empty() ? "" : comment_of(old));
  while (!slot->groups.empty()) erase_line(slot->groups.back());
  if (!group.empty()) {
    insert_line(at, text);
    slot->groups = {at};
  }
  values_.set_group(name, group);
}

std::string ImportFile::text() const {
  std::string out = mark_;
  for (const Line& line : lines_) out += line.text + line.ending;
  return out;
}

}  // namespace polyarm::data
