#include "polyarm/shapes/measured_look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/shapes/style.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::shapes {

namespace {

constexpr double kUnit = 1e-4;      // m; lengths in the file are whole multiples of it
constexpr double kTurn = 1e-4;      // of a quaternion's parts
constexpr double kSame = 0.6;       // units; outlines that differ less are the same in a file
constexpr long kLongest = 500'000;  // units
// A file may come with a cell of a stranger: larger ones are an error and use no memory.
constexpr std::size_t kMostLofts = 400, kMostSections = 64;
constexpr const char* kAgain = "measure the look again with polyarm robots fit";

/// The whole numbers of a text, separated by spaces; of a longer list only the first ones.
std::vector<double> integers(std::string_view text, const Location& where) {
  std::vector<double> out;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end && out.size() <= kTangents + 1) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    long value = 0;
    const auto [next, failed] = std::from_chars(at, end, value);
    if (failed != std::errc{} || (next != end && *next != ' ') || std::abs(value) > kLongest)
      throw Error(Problem{"bad-value", where, "whole numbers of at most 50 m are expected here", kAgain});
    out.push_back(static_cast<double>(value));
    at = next;
  }
  return out;
}

Pose read_frame(const Yaml& yaml) {
  const std::vector<double> n = integers(yaml.text(), yaml.where());
  Pose out;
  if (n.size() == 7) {
    out.position = kUnit * Vec3{n[0], n[1], n[2]};
    const double size = std::hypot(std::hypot(n[3], n[4]), std::hypot(n[5], n[6]));
    if (size > 0) {
      out.rotation = {n[3] / size, n[4] / size, n[5] / size, n[6] / size};
      return out;
    }
  }
  throw Error(
      Problem{"bad-value", yaml.where(), "a frame has seven numbers: a position and a quaternion", kAgain});
}

MeasuredSection read_section(std::string_view text, const Location& where) {
  const std::vector<double> n = integers(text, where);
  const std::size_t count = n.empty() ? 0 : n.size() - 1;
  if (std::find(kTangentCounts.begin(), kTangentCounts.end(), count) == kTangentCounts.end())
    throw Error(Problem{"bad-value", where,
                        fmt::format("a section has a place and 1, 4, 8, 16 or {} extents", kTangents),
                        kAgain});
  MeasuredSection out;
  out.at = kUnit * n[0];
  out.extent = outline_of(std::span(n).subspan(1));
  for (double& extent : out.extent) extent *= kUnit;
  return out;
}

std::vector<MeasuredSection> read_sections(const Yaml& yaml) {
  const std::string text = yaml.text();
  std::vector<MeasuredSection> out;
  for (std::size_t at = 0; at <= text.size();) {
    if (out.size() == kMostSections)
      throw Error(Problem{"too-many", yaml.where(),
                          fmt::format("a loft has at most {} sections", kMostSections), kAgain});
    const std::size_t end = std::min(text.find(',', at), text.size());
    out.push_back(read_section(std::string_view(text).substr(at, end - at), yaml.where()));
    at = end + 1;
  }
  const auto above = [](const MeasuredSection& a, const MeasuredSection& b) { return a.at >= b.at; };
  if (out.size() < 2 || std::adjacent_find(out.begin(), out.end(), above) != out.end())
    throw Error(
        Problem{"bad-value", yaml.where(), "a loft has at least two sections in ascending order", kAgain});
  return out;
}

MeasuredLoft read_loft(const std::string& link, const Yaml& yaml, Problems& problems) {
  yaml.check_keys({"paint", "frame", "sections"}, problems);
  const std::string paint = yaml["paint"].text("");
  if (!paint.empty() && !read_color(paint))
    throw Error(
        Problem{"bad-value", yaml["paint"].where(), "'" + paint + "' is not a colour", "write #rrggbb"});
  return {link, paint, read_frame(yaml.required("frame")), read_sections(yaml.required("sections"))};
}

/// In double quotes, as YAML reads it.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    if (c == '"' || c == '\\')
      out += std::string{'\\', c};
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return out + "\"";
}

/// A name as a key of YAML: in quotes if it is not plain.
std::string key_of(const std::string& name) {
  const bool is_plain = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '/' || c == '.' || c == '-';
  });
  return is_plain && std::isalpha(static_cast<unsigned char>(name[0])) && lower(name) != "null"
             ? name
             : quoted(name);
}

long units(double length) {
  return std::lround(length / kUnit);
}

std::string text_of(const MeasuredSection& section) {
  std::string out = fmt::format("{}", units(section.at));
  for (const double extent : fewest_tangents(section.extent, kSame * kUnit))
    out += fmt::format(" {}", units(extent));
  return out;
}

std::string text_of(const MeasuredLoft& loft) {
  const Vec3& p = loft.frame.position;
  const Quaternion& q = loft.frame.rotation;
  const auto part = [](double value) { return std::lround(value / kTurn); };
  std::string out = "    - {";
  if (!loft.paint.empty()) out += fmt::format("paint: \"{}\", ", loft.paint);
  out += fmt::format("frame: \"{} {} {} {} {} {} {}\", sections: \"", units(p.x), units(p.y), units(p.z),
                     part(q.x), part(q.y), part(q.z), part(q.w));
  for (std::size_t i = 0; i < loft.sections.size(); ++i)
    out += (i > 0 ? ", " : "") + text_of(loft.sections[i]);
  return out + "\"}\n";
}

/// The corner between a tangent and the next one, `step` further.
std::pair<double, double> corner(double here, double next, double angle, double step) {
  const double along = (next - here * std::cos(step)) / std::sin(step);
  return {here * std::cos(angle) - along * std::sin(angle), here * std::sin(angle) + along * std::cos(angle)};
}

}  // namespace

std::array<double, kTangents> outline_of(std::span<const double> numbers) {
  std::array<double, kTangents> out{};
  if (numbers.size() == 1) out.fill(numbers[0]);
  if (numbers.size() == kTangents) std::copy(numbers.begin(), numbers.end(), out.begin());
  if (numbers.size() == 1 || numbers.size() == kTangents) return out;
  const double step = 2 * std::numbers::pi / static_cast<double>(numbers.size());
  std::vector<std::pair<double, double>> corners;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    corners.push_back(
        corner(numbers[i], numbers[(i + 1) % numbers.size()], step * static_cast<double>(i), step));
  for (std::size_t k = 0; k < kTangents; ++k) {
    const double angle = 2 * std::numbers::pi / kTangents * static_cast<double>(k), c = std::cos(angle),
                 s = std::sin(angle);
    double most = -1e300;
    for (const auto& [x, y] : corners) most = std::max(most, x * c + y * s);
    out[k] = most;
  }
  return out;
}

std::vector<double> fewest_tangents(const std::array<double, kTangents>& extent, double tolerance) {
  for (const std::size_t count : kTangentCounts) {
    std::vector<double> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(extent[i * kTangents / count]);
    if (count == 1)
      out[0] = (*std::min_element(extent.begin(), extent.end()) +
                *std::max_element(extent.begin(), extent.end())) /
               2;
    const std::array<double, kTangents> have = outline_of(out);
    double most = 0;
    for (std::size_t k = 0; k < kTangents; ++k) most = std::max(most, std::abs(have[k] - extent[k]));
    if (most <= tolerance) return out;
  }
  return {extent.begin(), extent.end()};
}

MeasuredLook read_measured_look(const std::filesystem::path& path) {
  const Yaml yaml = Yaml::load(path.string());
  Problems problems;
  if (yaml["polyarm"].text("") != "look/1")
    throw Error(Problem{"wrong-kind", yaml.where(), "the line 'polyarm: look/1' is missing", {}});
  yaml.check_keys({"polyarm", "source", "links"}, problems);
  MeasuredLook out;
  out.source = yaml["source"].text("");
  for (const Yaml::Entry& link : yaml["links"].entries())
    for (const Yaml& loft : link.value.items()) {
      if (out.lofts.size() == kMostLofts)
        throw Error(Problem{"too-many", loft.where(), fmt::format("a robot has at most {} lofts", kMostLofts),
                            kAgain});
      out.lofts.push_back(read_loft(link.key, loft, problems));
    }
  problems.throw_if_errors();
  return out;
}

std::string text_of(const MeasuredLook& look) {
  std::map<std::string, std::string> by_link;
  std::vector<std::string> order;
  for (const MeasuredLoft& loft : look.lofts) {
    if (!by_link.contains(loft.link)) order.push_back(loft.link);
    by_link[loft.link] += text_of(loft);
  }
  std::string out = "polyarm: look/1\n";
  if (!look.source.empty()) out += fmt::format("source: {}\n", quoted(look.source));
  out += "links:\n";
  for (const std::string& link : order) out += fmt::format("  {}:\n{}", key_of(link), by_link[link]);
  return out;
}

std::size_t text_size(const std::vector<MeasuredLoft>& lofts) {
  std::size_t out = 0;
  for (const MeasuredLoft& loft : lofts) out += text_of(loft).size();
  return out;
}

void add_loft(Solid& solid, const MeasuredLoft& loft, const Paint& paint) {
  constexpr double kStep = 2 * std::numbers::pi / kTangents;
  std::vector<std::vector<Vec3>> loops;
  for (const MeasuredSection& section : loft.sections) {
    std::vector<Vec3>& loop = loops.emplace_back();
    for (std::size_t k = 0; k < kTangents; ++k) {
      const auto [x, y] = corner(section.extent[k], section.extent[(k + 1) % kTangents],
                                 kStep * static_cast<double>(k), kStep);
      loop.push_back(loft.frame * Vec3{x, y, section.at});
    }
  }
  solid.skin(loops, paint);
}

}  // namespace polyarm::shapes
