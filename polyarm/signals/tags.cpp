#include "polyarm/signals/tags.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/signals/links_file.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::signals {

namespace {
void check_version(const Yaml& root, Problems& problems) {
  const std::string version = root.required("polyarm").text();
  if (version != "signals/1")
    problems.error("bad-version", root["polyarm"].where(),
                   "'" + version + "' is not a kind of file that is read here",
                   "this version reads `polyarm: signals/1`");
}

Tag::Type read_type(const Yaml& node, Tag::Type fallback) {
  if (!node.defined()) return fallback;
  const std::string word = node.text();
  if (word == "bool") return Tag::Type::boolean;
  if (word == "number") return Tag::Type::number;
  if (word == "text") return Tag::Type::text;
  const std::vector<std::string> types = {"bool", "number", "text"};
  throw Error(Problem{"bad-value", node.where(),
                      "'" + word + "' is not a type of a tag" + did_you_mean(word, types),
                      "types are bool, number and text"});
}

data::Value read_initial(const Yaml& node) {
  const std::string text = node.text();
  if (equal_ignoring_case(text, "true")) return true;
  if (equal_ignoring_case(text, "false")) return false;
  if (const auto number = parse_number(text)) return *number;
  return text;
}

Tag::Type type_of(const data::Value& value) {
  if (value.as_boolean()) return Tag::Type::boolean;
  return value.as_number() ? Tag::Type::number : Tag::Type::text;
}

data::Value nothing_of(Tag::Type type) {
  if (type == Tag::Type::boolean) return false;
  if (type == Tag::Type::number) return 0;
  return "";
}

data::Value read_ruled(const Yaml& node, const Tag& tag) {
  const data::Value value = read_initial(node);
  if (type_of(value) == tag.type) return value;
  throw Error(Problem{"bad-value", node.where(),
                      "'" + node.text() + "' is not of the type of '" + tag.name + "'",
                      "write keep, or a value of the tag"});
}

/// Reads `on_stop`, `on_hold` and `on_link_loss`: keep, or a value.
void read_rules(const Yaml& node, Tag& tag) {
  const std::pair<const char*, std::optional<data::Value>*> rules[] = {
      {"on_stop", &tag.rules.on_stop},
      {"on_hold", &tag.rules.on_hold},
      {"on_link_loss", &tag.rules.on_link_loss}};
  for (const auto& [key, rule] : rules) {
    if (!node.has(key) || node[key].text() == "keep") continue;
    if (tag.role == data::TagRole::state)
      throw Error(Problem{"bad-tag", node[key].where(), "the tag '" + tag.name + "' is not an output", {}});
    *rule = read_ruled(node[key], tag);
  }
}

/// Warns of rules that would drop a held part.
void warn_of_drops(const Yaml& node, const Tag& tag, Problems& problems) {
  const bool holds = tag.interface.ends_with("/tool/vacuum") || tag.interface.ends_with("/tool/grip");
  for (const char* key : {"on_stop", "on_hold", "on_link_loss"})
    if (holds && node.has(key) && node[key].text() != "keep")
      problems.warning("drops-part", node[key].where(),
                       "'" + tag.name + "' works the gripper: `" + key + ": " + node[key].text() +
                           "` drops a part that it holds",
                       "write keep, or leave it out");
}

void read_binding(const Yaml& node, Tag& tag) {
  if (node.has("command") && node.has("state"))
    throw Error(Problem{"bad-tag", node.where(),
                        "the tag '" + tag.name + "' cannot be both a command and a state", "make two tags"});
  if (node.has("command")) tag.role = data::TagRole::command, tag.interface = node["command"].text();
  if (node.has("state")) tag.role = data::TagRole::state, tag.interface = node["state"].text();
  if (tag.role != data::TagRole::plain && tag.type == Tag::Type::text)
    throw Error(Problem{"bad-tag", node.where(),
                        "the tag '" + tag.name + "' is bound to an interface, which holds no text",
                        "types of a bound tag are bool and number"});
}

Tag read_tag(const std::string& name, const Yaml& node, const Location& where, Problems& problems) {
  Tag tag;
  tag.name = name;
  tag.where = where;
  if (node.defined() && !node.is_map())
    throw Error(Problem{"bad-tag", node.where(), "the tag '" + name + "' is not described",
                        "write {command: …}, {state: …} or {initial: …}"});
  node.check_keys(
      {"command", "state", "type", "scale", "initial", "unit", "on_stop", "on_hold", "on_link_loss"},
      problems);
  const bool given = node.has("initial");
  if (given) tag.initial = read_initial(node["initial"]);
  tag.type = read_type(node["type"], given ? type_of(tag.initial) : Tag::Type::boolean);
  if (!given) tag.initial = nothing_of(tag.type);
  if (type_of(tag.initial) != tag.type)
    throw Error(Problem{
        "bad-value", node["initial"].where(), "'" + tag.initial.text() + "' is not of the tag's type", {}});
  tag.scale = node["scale"].number(Dimension::none, 1);
  if (tag.scale == 0) throw Error(Problem{"bad-value", node["scale"].where(), "the scale cannot be 0", {}});
  tag.unit = node["unit"].text("");
  read_binding(node, tag);
  read_rules(node, tag);
  warn_of_drops(node, tag, problems);
  return tag;
}

Heartbeat read_heartbeat(const Yaml& node) {
  Heartbeat out;
  out.where = node.where();
  out.tag = node.is_map() ? node.required("tag").text() : node.text();
  if (node.has("every")) out.period = nanoseconds(node["every"].number(Dimension::time));
  if (out.period < 10'000'000)
    throw Error(
        Problem{"bad-value", node["every"].where(), "a heartbeat changes every 10 ms at the most often", {}});
  return out;
}

CameraLink read_camera(const std::string& name, const Yaml& node, const Location& where, Problems& problems) {
  if (!node.is_map())
    throw Error(Problem{"bad-camera", where, "the camera '" + name + "' is not described", {}});
  node.check_keys(
      {"camera", "point", "data", "request", "done", "noise", "seed", "on", "mount", "view", "reach"},
      problems);
  CameraLink out;
  out.name = name;
  out.where = where;
  out.camera = node["camera"].text(name);
  out.point = node.required("point").text();
  if (node.has("data")) out.data = node["data"].text();
  out.request = node.required("request").text();
  out.done = node.required("done").text();
  out.noise = node["noise"].boolean(false);
  out.on = node["on"].text("");
  if (node.has("mount")) out.mount = node["mount"].pose();
  out.view = node["view"].number(Dimension::angle, out.view);
  out.reach = node["reach"].number(Dimension::length, out.reach);
  if (!(out.view > 0 && out.view < 1.6 && out.reach > 0))
    throw Error(
        Problem{"bad-camera", where, "a camera sees 0 to 90 degrees to each side, and farther than 0 m", {}});
  const double seed = node["seed"].number(Dimension::none, 1);
  if (seed < 0 || seed > 9e15 || seed != std::floor(seed))
    throw Error(Problem{"bad-value", node["seed"].where(), "a seed is a whole number", {}});
  out.seed = static_cast<std::uint64_t>(seed);
  return out;
}

/// Accepts the name with or without the file extension.
void add_live(const std::string& written, const Location& where, Signals& out) {
  const std::vector<std::string>& endings = data::file_endings();
  const std::filesystem::path path(written);
  const bool ends = std::find(endings.begin(), endings.end(), path.extension().string()) != endings.end();
  out.live.push_back(ends ? path.stem().string() : written);
  out.live_where[out.live.back()] = where;
}

void read_all(const Yaml& root, const std::filesystem::path& folder, Signals& out, Problems& problems) {
  collect(problems, [&] { check_version(root, problems); });
  root.check_keys({"polyarm", "tags", "live", "data", "cameras", "links", "heartbeat", "watch", "points"},
                  problems);
  const Yaml tags = root["tags"], cameras = root["cameras"];
  for (const std::string& name : tags.defined() ? tags.keys() : std::vector<std::string>{})
    collect(problems,
            [&] { out.tags.push_back(read_tag(name, tags[name], tags.key_location(name), problems)); });
  if (root.has("live"))
    collect(problems, [&] {
      for (const std::string& set : root["live"].texts()) add_live(set, root.key_location("live"), out);
    });
  for (const std::string& set : root["data"].keys())
    collect(problems, [&] {
      root["data"][set].check_keys({"live"}, problems);
      if (root["data"][set]["live"].boolean(false)) add_live(set, root["data"].key_location(set), out);
    });
  for (const std::string& name : cameras.defined() ? cameras.keys() : std::vector<std::string>{})
    collect(problems, [&] {
      out.cameras.push_back(read_camera(name, cameras[name], cameras.key_location(name), problems));
    });
  collect(problems, [&] { out.links = read_links(root["links"], folder, problems); });
  if (root.has("heartbeat")) collect(problems, [&] { out.heartbeat = read_heartbeat(root["heartbeat"]); });
  for (const std::string& tag : root["watch"].keys())
    collect(problems, [&] {
      const Yaml within = root["watch"][tag];
      out.watched.push_back({tag, nanoseconds(within.number(Dimension::time)), within.where()});
    });
  for (const std::string& point : root["points"].keys())
    collect(problems, [&] { out.points[point] = read_range(root["points"][point]); });
}
}  // namespace

const data::Value& Tag::output(const data::Value& value, const Situation& now) const {
  if (now.stopped && rules.on_stop) return *rules.on_stop;
  if (now.held && rules.on_hold) return *rules.on_hold;
  if (now.link_lost && rules.on_link_loss) return *rules.on_link_loss;
  return value;
}

std::optional<double> Tag::to_interface(const data::Value& value) const {
  if (type == Type::boolean && value.as_boolean()) return *value.as_boolean() ? 1.0 : 0.0;
  if (type == Type::number && value.as_number()) return scale * value.as_number()->value;
  return std::nullopt;
}

data::Value Tag::from_interface(double value) const {
  if (type == Type::boolean) return value >= 0.5;
  return value / scale;
}

Signals parse_signals(const std::string& text, const std::string& file, Problems& problems) {
  Signals out;
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  collect(problems, [&] {
    const Yaml yaml = Yaml::parse(text, file);
    check_repeats(yaml, problems);
    read_all(yaml, folder, out, problems);
  });
  return out;
}

Signals load_signals(const std::string& path) {
  Problems problems;
  Signals out = parse_signals(read_file(path), path, problems);
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::signals
