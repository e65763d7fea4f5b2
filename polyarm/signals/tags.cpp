#include "polyarm/signals/tags.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"

namespace polyarm::signals {

namespace {
void check_version(const Yaml& root, Problems& problems) {
  const std::string version = root.required("polyarm").text();
  if (version != "signals/1")
    problems.error("bad-version", root["polyarm"].where(),
                   "'" + version + "' is no kind of file that is read here",
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
                      "'" + word + "' is no type of a tag" + did_you_mean(word, types),
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
  node.check_keys({"command", "state", "type", "scale", "initial"}, problems);
  const bool given = node.has("initial");
  if (given) tag.initial = read_initial(node["initial"]);
  tag.type = read_type(node["type"], given ? type_of(tag.initial) : Tag::Type::boolean);
  if (!given) tag.initial = nothing_of(tag.type);
  if (type_of(tag.initial) != tag.type)
    throw Error(Problem{
        "bad-value", node["initial"].where(), "'" + tag.initial.text() + "' is not of the tag's type", {}});
  tag.scale = node["scale"].number(Dimension::none, 1);
  if (tag.scale == 0) throw Error(Problem{"bad-value", node["scale"].where(), "the scale cannot be 0", {}});
  read_binding(node, tag);
  return tag;
}

CameraLink read_camera(const std::string& name, const Yaml& node, const Location& where, Problems& problems) {
  if (!node.is_map())
    throw Error(Problem{"bad-camera", where, "the camera '" + name + "' is not described", {}});
  node.check_keys({"camera", "point", "data", "request", "done", "noise", "seed"}, problems);
  CameraLink out;
  out.name = name;
  out.where = where;
  out.camera = node["camera"].text(name);
  out.point = node.required("point").text();
  if (node.has("data")) out.data = node["data"].text();
  out.request = node.required("request").text();
  out.done = node.required("done").text();
  out.noise = node["noise"].boolean(false);
  const double seed = node["seed"].number(Dimension::none, 1);
  if (seed < 0 || seed > 9e15 || seed != std::floor(seed))
    throw Error(Problem{"bad-value", node["seed"].where(), "a seed is a whole number", {}});
  out.seed = static_cast<std::uint64_t>(seed);
  return out;
}

void read_all(const Yaml& root, Signals& out, Problems& problems) {
  collect(problems, [&] { check_version(root, problems); });
  root.check_keys({"polyarm", "tags", "live", "data", "cameras"}, problems);
  const Yaml tags = root["tags"], cameras = root["cameras"];
  for (const std::string& name : tags.defined() ? tags.keys() : std::vector<std::string>{})
    collect(problems,
            [&] { out.tags.push_back(read_tag(name, tags[name], tags.key_location(name), problems)); });
  if (root.has("live")) collect(problems, [&] { out.live = root["live"].texts(); });
  for (const std::string& set : root["data"].keys())
    collect(problems, [&] {
      root["data"][set].check_keys({"live"}, problems);
      if (root["data"][set]["live"].boolean(false)) out.live.push_back(set);
    });
  for (const std::string& name : cameras.defined() ? cameras.keys() : std::vector<std::string>{})
    collect(problems, [&] {
      out.cameras.push_back(read_camera(name, cameras[name], cameras.key_location(name), problems));
    });
}
}  // namespace

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
  collect(problems, [&] { read_all(Yaml::parse(text, file), out, problems); });
  return out;
}

Signals load_signals(const std::string& path) {
  Problems problems;
  Signals out = parse_signals(read_file(path), path, problems);
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::signals
