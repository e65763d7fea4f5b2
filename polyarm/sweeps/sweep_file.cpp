#include "polyarm/sweeps/sweep_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/sweeps/robot_choice.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::sweeps {

namespace {

namespace fs = std::filesystem;

Error bad(const Yaml& node, const std::string& what, const std::string& advice = {}) {
  return Error(Problem{"bad-value", node.where(), what, advice});
}

std::uint64_t whole(const Yaml& node, double least, double most) {
  const double value = node.number();
  if (!(value >= least && value <= most && value == std::floor(value)))
    throw bad(node, fmt::format("{} is a whole number from {:.0f} to {:.0f}", node.named(), least, most));
  return static_cast<std::uint64_t>(value);
}

double between(const Yaml& node, Dimension dimension, double least, double most) {
  const double value = node.number(dimension);
  if (!(value >= least && value <= most))
    throw bad(node, fmt::format("{} lies from {:g} to {:g}", node.named(), least, most));
  return value;
}

void check_count(const Yaml& node, std::size_t count) {
  if (count > kMostValues)
    throw Error(Problem{"too-many", node.where(),
                        fmt::format("{} has more than {} values", node.named(), kMostValues),
                        "take fewer steps, or a random part of the variants: sample"});
}

/// Evenly spaced from `from` to `to`, both included.
std::vector<double> spaced(double from, double to, std::uint64_t steps) {
  std::vector<double> out;
  for (std::uint64_t i = 0; i < steps; ++i)
    out.push_back(steps == 1 ? from
                             : from + (to - from) * static_cast<double>(i) / static_cast<double>(steps - 1));
  return out;
}

/// A number, a list of them, or {from, to, steps}.
std::vector<double> coordinates(const Yaml& node, Dimension dimension, Problems& problems) {
  if (!node.is_map()) return node.numbers(dimension);
  node.check_keys({"from", "to", "steps"}, problems);
  const std::uint64_t steps = whole(node.required("steps"), 1, static_cast<double>(kMostValues));
  return spaced(node.required("from").number(dimension), node.required("to").number(dimension), steps);
}

struct Coordinate {
  const char* name;
  Dimension dimension;
  std::optional<double> Place::*value;
};
constexpr Coordinate kCoordinates[] = {{"x", Dimension::length, &Place::x},
                                       {"y", Dimension::length, &Place::y},
                                       {"z", Dimension::length, &Place::z},
                                       {"yaw", Dimension::angle, &Place::yaw}};

Place read_place(const Yaml& node, Problems& problems) {
  node.check_keys({"x", "y", "z", "yaw"}, problems);
  Place out;
  for (const Coordinate& c : kCoordinates)
    if (node.has(c.name)) out.*c.value = between(node[c.name], c.dimension, -1000, 1000);
  return out;
}

void add_grid(const Yaml& node, std::vector<Place>& out, Problems& problems) {
  node.check_keys({"x", "y", "z", "yaw"}, problems);
  std::vector<Place> grid(1);
  for (const Coordinate& c : kCoordinates) {
    if (!node.has(c.name)) continue;
    const std::vector<double> values = coordinates(node[c.name], c.dimension, problems);
    if (values.empty()) throw bad(node[c.name], node[c.name].named() + " has no value");
    check_count(node, grid.size() * values.size());
    std::vector<Place> next;
    for (const Place& place : grid)
      for (const double value : values) {
        if (!(std::abs(value) <= 1000)) throw bad(node[c.name], node[c.name].named() + " lies within 1000");
        next.push_back(place);
        next.back().*c.value = value;
      }
    grid = std::move(next);
  }
  out.insert(out.end(), grid.begin(), grid.end());
}

void add_line(const Yaml& node, std::vector<Place>& out, Problems& problems) {
  node.check_keys({"from", "to", "steps"}, problems);
  const Place from = read_place(node.required("from"), problems),
              to = read_place(node.required("to"), problems);
  const std::uint64_t steps = whole(node.required("steps"), 1, static_cast<double>(kMostValues));
  std::vector<Place> line(steps);
  for (const Coordinate& c : kCoordinates) {
    const auto &a = from.*c.value, &b = to.*c.value;
    if (a.has_value() != b.has_value())
      throw bad(node, fmt::format("only one end of the line has '{}'", c.name), "give it to both ends");
    if (!a) continue;
    const std::vector<double> values = spaced(*a, *b, steps);
    for (std::size_t i = 0; i < line.size(); ++i) line[i].*c.value = values[i];
  }
  out.insert(out.end(), line.begin(), line.end());
}

/// Places, grids and lines, in a list or alone.
std::vector<Place> read_places(const Yaml& node, Problems& problems) {
  if (!node.defined()) return {Place{}};
  std::vector<Place> out;
  for (const Yaml& each : node.items()) {
    collect(problems, [&] {
      if (!each.is_map())
        throw bad(each, "a base place is " + each.kind(),
                  "{x: 0.1, y: 0}, {grid: {x: …}} or {line: {from: …}}");
      if (each.has("grid")) {
        each.check_keys({"grid"}, problems);
        add_grid(each["grid"], out, problems);
      } else if (each.has("line")) {
        each.check_keys({"line"}, problems);
        add_line(each["line"], out, problems);
      } else {
        for (const Yaml::Entry& entry : each.entries())
          if (entry.value.is_map() || entry.value.is_list())
            throw Error(Problem{"bad-value", entry.where,
                                "'" + entry.key + "' of one place is " + entry.value.kind(),
                                "places in a grid are {grid: {x: {from: -0.1, to: 0.1, steps: 5}}}"});
        out.push_back(read_place(each, problems));
      }
    });
    check_count(node, out.size());
  }
  return out;
}

std::vector<std::string> read_robots(const Yaml& node,
                                     const std::vector<description::CatalogueEntry>& catalogue,
                                     const fs::path& folder, Problems& problems) {
  if (!node.defined()) return {""};
  std::vector<std::string> out;
  for (const Yaml& each : node.items())
    collect(problems, [&] {
      for (std::string& name : choose_robots(each.text(), catalogue, folder.string(), each.where()))
        if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(std::move(name));
    });
  return out;
}

FaultStep read_step(const Yaml& node, Problems& problems) {
  node.check_keys({"at", "for", "force", "person", "emergency_stop"}, problems);
  FaultStep out;
  if (node.has("at")) out.at_s = between(node["at"], Dimension::time, 0, 1e6);
  if (node.has("for")) out.for_s = between(node["for"], Dimension::time, 0, 1e6);
  for (const Yaml::Entry& entry : node["force"].entries()) {
    const std::string text = entry.value.text();
    std::optional<double> value = parse_number(text);
    if (text == "true" || text == "on") value = 1;
    if (text == "false" || text == "off") value = 0;
    if (!value) throw bad(entry.value, "'" + text + "' is no number", "0, 1, true or false");
    out.force[entry.key] = *value;
  }
  out.person = node["person"].text("");
  const std::vector<std::string> words = {"hold", "resume", "stop", "recover", "discard", "back"};
  if (!out.person.empty() && std::find(words.begin(), words.end(), out.person) == words.end())
    throw bad(node["person"], "a person cannot '" + out.person + "'" + did_you_mean(out.person, words),
              join(words, ", "));
  out.emergency_stop = node["emergency_stop"].boolean(false);
  if (out.force.empty() && out.person.empty() && !out.emergency_stop)
    throw bad(node, "this step does nothing",
              "force: {arm/tool/vacuum: 0}, person: hold or emergency_stop: true");
  return out;
}

std::string one_line(const Fault& fault) {
  std::string out;
  for (const FaultStep& step : fault.steps) {
    out += fmt::format("at {} ", step.at_s);
    if (step.for_s) out += fmt::format("for {} ", *step.for_s);
    for (const auto& [name, value] : step.force) out += fmt::format("{}={} ", name, value);
    out += step.person + (step.emergency_stop ? "emergency_stop" : "") + ";";
  }
  return out;
}

/// NAME: {} · NAME: {one step} · NAME: [steps]
std::vector<Fault> read_faults(const Yaml& node, Problems& problems) {
  if (!node.defined()) return {Fault{}};
  if (!node.is_map())
    throw bad(node, "'faults' is " + node.kind(), "names with what fails: {none: {}, no vacuum: {force: …}}");
  std::vector<Fault> out;
  for (const Yaml::Entry& entry : node.entries()) {
    Fault fault{entry.key, {}, {}};
    const std::vector<Yaml> steps = entry.value.items();
    if (steps.size() > kMostSteps)
      throw Error(
          Problem{"too-many", entry.where, fmt::format("a fault has more than {} steps", kMostSteps), {}});
    for (const Yaml& step : steps)
      collect(problems, [&] {
        if (!step.is_map())
          throw bad(step, "what fails is " + step.kind(), "{at: 5s, force: {arm/tool/vacuum: 0}}");
        if (!step.entries().empty()) fault.steps.push_back(read_step(step, problems));
      });
    fault.text = one_line(fault);
    out.push_back(std::move(fault));
  }
  check_count(node, out.size());
  return out;
}

/// A list of whole numbers, or {from, count}.
std::vector<std::uint64_t> read_seeds(const Yaml& node, Problems& problems) {
  if (!node.defined()) return {1};
  std::vector<std::uint64_t> out;
  if (node.is_map()) {
    node.check_keys({"from", "count"}, problems);
    const std::uint64_t from = node.has("from") ? whole(node["from"], 0, 9e15) : 1,
                        count = whole(node.required("count"), 1, static_cast<double>(kMostValues));
    for (std::uint64_t i = 0; i < count; ++i) out.push_back(from + i);
    return out;
  }
  for (const Yaml& each : node.items()) out.push_back(whole(each, 0, 9e15));
  check_count(node, out.size());
  return out;
}

std::vector<double> read_speeds(const Yaml& node) {
  if (!node.defined()) return {1};
  std::vector<double> out;
  for (const Yaml& each : node.items()) {
    const double share = each.number();  // 50% is 0.5
    if (!(share > 0 && share <= 1))
      throw bad(each, fmt::format("a speed of {:g} cannot be", share),
                "a share of the programmed speed: 0.5 or 50%");
    out.push_back(share);
  }
  check_count(node, out.size());
  return out;
}

std::vector<ValueAxis> read_values(const Yaml& node) {
  std::vector<ValueAxis> out;
  if (node.defined() && !node.is_map())
    throw bad(node, "'values' is " + node.kind(), "names of the cell with their values: {Count: [1, 2]}");
  for (const Yaml::Entry& entry : node.entries()) {
    out.push_back({entry.key, entry.value.texts(), entry.where});
    check_count(entry.value, out.back().values.size());
  }
  if (out.size() > kMostAxes)
    throw Error(
        Problem{"too-many", node.where(), fmt::format("more than {} values are varied", kMostAxes), {}});
  return out;
}

Vary read_vary(const Yaml& node, Problems& problems) {
  Vary out;
  if (!node.defined()) return out;
  node.check_keys({"base", "yaw", "points"}, problems);
  if (node.has("base")) out.base = between(node["base"], Dimension::length, 0, 10);
  if (node.has("yaw")) out.yaw = between(node["yaw"], Dimension::angle, 0, std::numbers::pi);
  for (const Yaml::Entry& entry : node["points"].entries())
    out.points[entry.key] = between(entry.value, Dimension::length, 0, 1);
  if (out.points.size() > kMostAxes)
    throw Error(
        Problem{"too-many", node["points"].where(), fmt::format("more than {} points vary", kMostAxes), {}});
  return out;
}

/// `require: {clearance: 10mm}`, `measure: {clearance: 50mm}`, `stop_after: {cycles: 3, seconds: 600}`.
void read_run(const Yaml& yaml, Sweep& out, Problems& problems) {
  const Yaml stop = yaml["stop_after"], measure = yaml["measure"], require = yaml["require"];
  stop.check_keys({"cycles", "seconds", "wall_seconds"}, problems);
  if (stop.has("cycles")) out.cycles = whole(stop["cycles"], 1, 1e9);
  if (stop.has("seconds")) out.seconds = between(stop["seconds"], Dimension::time, 1e-3, 1e6);
  if (stop.has("wall_seconds")) out.patience = between(stop["wall_seconds"], Dimension::time, 1, 1e6);
  measure.check_keys({"clearance"}, problems);
  if (measure.has("clearance")) {
    const Yaml clearance = measure["clearance"];
    out.clearance = clearance.text() == "off" ? 0 : between(clearance, Dimension::length, 0, 1);
  }
  require.check_keys({"clearance"}, problems);
  if (require.has("clearance")) out.least_clearance = between(require["clearance"], Dimension::length, 0, 1);
  if (out.least_clearance > out.clearance)
    throw bad(require["clearance"], "the clearance that is required is larger than what is measured",
              fmt::format("measure: {{clearance: {:g}}}", out.least_clearance));
}

fs::path find_cell(const Yaml& node, const fs::path& folder) {
  const fs::path path = folder / node.text();
  std::error_code ignored;
  if (is_file(path / "cell.yaml") || is_file(path)) return fs::weakly_canonical(path, ignored);
  throw Error(Problem{"no-cell", node.where(),
                      "there is no cell in '" + path.lexically_normal().string() + "'",
                      "a folder with a cell.yaml, relative to the sweep file"});
}

void read_combination(const Yaml& yaml, Sweep& out) {
  const std::vector<std::string> ways = {"product", "zip"};
  const std::string way = yaml["combine"].text("product");
  if (std::find(ways.begin(), ways.end(), way) == ways.end())
    throw bad(yaml["combine"], "combine is '" + way + "'" + did_you_mean(way, ways), "product or zip");
  out.combine = way == "zip" ? Combine::zip : Combine::product;
  if (yaml.has("sample")) out.sample = whole(yaml["sample"], 1, kMostVariants);
  if (yaml.has("sample_seed")) out.sample_seed = whole(yaml["sample_seed"], 0, 9e15);
}

/// Where the file names programs, values, points, forced interfaces and the robot.
std::map<std::string, Location> places_of_names(const Yaml& yaml) {
  std::map<std::string, Location> out;
  const auto keys = [&](const Yaml& map) {
    for (const Yaml::Entry& entry : map.entries()) out.try_emplace(entry.key, entry.where);
  };
  for (const Yaml& program : yaml["programs"].items())
    if (program.is_scalar()) out.try_emplace(program.text(), program.where());
  keys(yaml["values"]);
  keys(yaml["vary"]["points"]);
  for (const Yaml::Entry& fault : yaml["faults"].entries())
    for (const Yaml& step : fault.value.items()) keys(step["force"]);
  if (yaml.has("robot")) out["robot"] = yaml["robot"].where();
  return out;
}

/// An axis without values has no variants.
void require_values(const Yaml& yaml, const Sweep& sweep, Problems& problems) {
  const auto require = [&](const char* key, std::size_t count) {
    if (count == 0 && !problems.has_errors())
      problems.error("bad-value", yaml.key_location(key), fmt::format("'{}' has no value", key),
                     "leave the key out to take what the cell file says");
  };
  require("robots", sweep.robots.size());
  require("base", sweep.places.size());
  require("programs", sweep.programs.size());
  require("speeds", sweep.speeds.size());
  require("faults", sweep.faults.size());
  require("seeds", sweep.seeds.size());
  for (const ValueAxis& axis : sweep.values)
    if (axis.values.empty()) problems.error("bad-value", axis.where, "'" + axis.name + "' has no value");
}

Sweep read(const Yaml& yaml, const fs::path& path, const description::Catalogue& catalogue) {
  Problems problems;
  Sweep out;
  out.file = path;
  out.name = path.stem().string();
  const fs::path folder = path.parent_path();
  check_repeats(yaml, problems);
  yaml.check_keys(
      {"polyarm", "cell", "robot", "robots", "base", "programs", "speeds", "faults", "seeds", "values",
       "vary", "combine", "sample", "sample_seed", "hardware", "stop_after", "measure", "require"},
      problems);
  collect(problems, [&] {
    const std::string kind = yaml.required("polyarm").text();
    if (kind != "sweep/1") throw bad(yaml["polyarm"], "this file is '" + kind + "'", "polyarm: sweep/1");
  });
  collect(problems, [&] { out.cell = find_cell(yaml.required("cell"), folder); });
  collect(problems, [&] { out.robot = yaml["robot"].text(""); });
  collect(problems, [&] { out.robots = read_robots(yaml["robots"], catalogue.entries(), folder, problems); });
  collect(problems, [&] { out.places = read_places(yaml["base"], problems); });
  collect(problems, [&] {
    out.programs = yaml.has("programs") ? yaml["programs"].texts() : std::vector<std::string>{""};
    check_count(yaml["programs"], out.programs.size());
  });
  collect(problems, [&] { out.speeds = read_speeds(yaml["speeds"]); });
  collect(problems, [&] { out.faults = read_faults(yaml["faults"], problems); });
  collect(problems, [&] { out.seeds = read_seeds(yaml["seeds"], problems); });
  collect(problems, [&] { out.values = read_values(yaml["values"]); });
  collect(problems, [&] { out.vary = read_vary(yaml["vary"], problems); });
  collect(problems, [&] { read_combination(yaml, out); });
  collect(problems, [&] { out.hardware = yaml["hardware"].text(""); });
  collect(problems, [&] { read_run(yaml, out, problems); });
  out.where = places_of_names(yaml);
  require_values(yaml, out, problems);
  if (out.seeds.size() > 1 && !out.vary.any())
    problems.error("bad-value", yaml.key_location("seeds"), "several seeds, and nothing that they vary",
                   "vary: {base: 2mm, points: {Pick: 1mm}}");
  problems.throw_if_errors();
  return out;
}

/// "x=-0.1:0.1:5" or "yaw=0|90deg" as a key of a grid.
std::string axis_of_grid(const std::string& word) {
  const auto equals = word.find('=');
  if (equals == std::string::npos)
    throw Error("bad-value", "'" + word + "' is no axis of --base", "x=-0.1:0.1:5,y=0|0.1,yaw=0|90deg");
  const std::string name = word.substr(0, equals), value = word.substr(equals + 1);
  const std::vector<std::string> span = split_fields(value, ':');
  if (span.size() == 3)
    return fmt::format("{}: {{from: {}, to: {}, steps: {}}}", name, span[0], span[1], span[2]);
  return fmt::format("{}: [{}]", name, join(split_fields(value, '|'), ", "));
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

std::string quoted_list(const std::string& commas) {
  std::vector<std::string> out;
  for (const std::string& each : split_fields(commas, ','))
    if (!each.empty()) out.push_back(quoted(each));
  return "[" + join(out, ", ") + "]";
}

}  // namespace

Sweep read_sweep(const std::string& text, const fs::path& path, const description::Catalogue& catalogue) {
  return read(Yaml::parse(text, path.string()), path, catalogue);
}

Sweep read_sweep_file(const fs::path& path, const description::Catalogue& catalogue) {
  return read_sweep(read_file(path, bounds::kYamlBytes), fs::absolute(path), catalogue);
}

std::string text_of(const Words& words) {
  std::string out = "polyarm: sweep/1\ncell: " + quoted(words.cell) + "\n";
  if (!words.robots.empty()) out += "robots: " + quoted_list(words.robots) + "\n";
  if (!words.base.empty()) {
    std::vector<std::string> axes;
    for (const std::string& word : split_fields(words.base, ',')) axes.push_back(axis_of_grid(word));
    out += "base: {grid: {" + join(axes, ", ") + "}}\n";
  }
  if (!words.programs.empty()) out += "programs: " + quoted_list(words.programs) + "\n";
  if (!words.speeds.empty()) out += "speeds: [" + words.speeds + "]\n";
  if (!words.seeds.empty()) out += "seeds: [" + words.seeds + "]\n";
  if (!words.hardware.empty()) out += "hardware: " + words.hardware + "\n";
  return out;
}

}  // namespace polyarm::sweeps
