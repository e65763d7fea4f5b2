#include "polyarm/data/formats.hpp"

#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/data/format_parts.hpp"
#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

std::string quoted(const std::string& text) {
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

std::vector<double> numbers_of(const Point& point) {
  const Vec3& p = point.pose.position;
  const Quaternion& q = point.pose.rotation;
  if (point.quaternion_given) return {p.x, p.y, p.z, q.x, q.y, q.z, q.w};
  const Vec3 rpy = to_rpy(q);
  return {p.x, p.y, p.z, rpy.x, rpy.y, rpy.z};
}

/// From six or seven numbers; normalises a quaternion.
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
      read_csv(text, file, out, problems);
      break;
    case SetForm::json:
      read_json(text, file, out, problems);
      break;
    case SetForm::yaml:
      read_yaml(text, file, out, problems);
      break;
    case SetForm::srdf:
      read_srdf(text, file, out, problems);
      break;
  }
  return out;
}

std::string write_form(const DataSet& set, SetForm form, const std::string& group, Problems& problems) {
  switch (form) {
    case SetForm::csv:
      return write_csv(set);
    case SetForm::json:
      return write_json(set);
    case SetForm::yaml:
      return write_yaml(set);
    case SetForm::srdf:
      return write_srdf(set, group, problems);
    case SetForm::text:
      break;
  }
  ImportFile out = ImportFile::parse("", "", problems);
  for (const Entry& entry : set.entries()) {
    out.set(entry.name, entry.value);
    out.set_group(entry.name, entry.group);
  }
  return out.text();
}

}  // namespace polyarm::data
