#include "polyarm/signals/links_file.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/secrets.hpp"

namespace polyarm::signals {

namespace {
[[noreturn]] void refuse(const Yaml& node, const std::string& what, const std::string& advice = {}) {
  throw Error(Problem{"bad-link", node.where(), what, advice});
}

/// The index of the word in `names`. Reports any other word, with the nearest name.
std::size_t one_of(const Yaml& node, const std::vector<std::string>& names) {
  const std::string word = node.text();
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end())
    throw Error(Problem{"bad-value", node.where(),
                        "'" + word + "' is not known here" + did_you_mean(word, names),
                        "known are: " + join(names, ", ")});
  return static_cast<std::size_t>(found - names.begin());
}

int whole(const Yaml& node, int fallback, int lower, int upper) {
  const double value = node.number(Dimension::none, fallback);
  if (value != std::floor(value) || value < lower || value > upper)
    throw Error(
        Problem{"bad-value",
                node.where(),
                "this is a whole number from " + std::to_string(lower) + " to " + std::to_string(upper),
                {}});
  return static_cast<int>(value);
}

Nanoseconds time_of(const Yaml& node, Nanoseconds fallback) {
  const double value = node.number(Dimension::time, seconds(fallback));
  if (!(value > 0) || value > 1e6)
    throw Error(Problem{"bad-value", node.where(), "this must be a time above 0", "for example 50ms"});
  return nanoseconds(value);
}

/// Metres or radians per unit.
double unit_scale(const Yaml& node, Dimension dimension) {
  const Unit* unit = find_unit(node.text());
  if (!unit || unit->dimension != dimension)
    refuse(node, "'" + node.text() + "' is not a unit of " + polyarm::name(dimension),
           dimension == Dimension::length ? "mm, cm or m" : "deg or rad");
  return unit->scale;
}

/// A name that becomes one level of a topic.
void require_level(const Yaml& node, const std::string& name, bool may_be_empty) {
  if ((name.empty() && !may_be_empty) || name.size() > 100 || name.find_first_of("/+#") != std::string::npos)
    refuse(node, "'" + name + "' cannot be a level of a topic", "1 to 100 characters without / + #");
}

class TagReader {
 public:
  TagReader(const LinkEntry& link, const Yaml& node, const std::string& name, const Location& where,
            Problems& problems)
      : link_(link), node_(node), problems_(problems) {
    tag_.name = name;
    tag_.where = where;
  }

  LinkTag read() {
    if (!node_.is_map())
      throw Error(Problem{
          "bad-link", tag_.where, "'" + tag_.name + "' is not described",
          link_.graph.contains("sparkplug") ? "write {direction: out}"
          : link_.kind == "mqtt"            ? "write {topic: cell/" + tag_.name + ", direction: out}"
          : link_.kind == "ros2"
              ? "write {topic: /" + tag_.name + ", message: std_msgs/Bool, field: data, direction: out}"
              : "write {coil: 0, direction: out}"});
    if (link_.kind == "mqtt" && link_.graph.contains("sparkplug"))
      read_metric();
    else if (link_.kind == "mqtt")
      read_topic();
    else if (link_.kind == "ros2")
      read_message();
    else
      read_registers();
    if (tag_.role == LinkTag::Role::topic) read_direction();
    read_numbers();
    return tag_;
  }

 private:
  static const std::vector<std::string>& types() {
    static const std::vector<std::string> names = {"bool", "number", "text", "pose"};
    return names;
  }

  void read_registers() {
    node_.check_keys({"coil", "discrete", "holding", "input", "type", "format", "direction", "first", "group",
                      "scale", "offset", "range", "within", "length", "angle"},
                     problems_);
    const std::vector<std::string> areas = {"coil", "discrete", "holding", "input"};
    int found = 0;
    for (std::size_t k = 0; k < areas.size(); ++k) {
      if (!node_.has(areas[k])) continue;
      ++found;
      tag_.area = static_cast<LinkTag::Area>(k);
      tag_.address = whole(node_[areas[k]], 0, 0, 65535);
    }
    if (found != 1)
      refuse(node_, "'" + tag_.name + "' has " + (found ? "more than one place" : "no place"),
             "one of: " + join(areas, ", ") + ", with its address from 0");
    const bool bits = tag_.area == LinkTag::Area::coil || tag_.area == LinkTag::Area::discrete;
    tag_.type = bits ? LinkTag::Type::boolean : LinkTag::Type::number;
    if (node_.has("type")) tag_.type = static_cast<LinkTag::Type>(one_of(node_["type"], types()));
    if (tag_.type == LinkTag::Type::text) refuse(node_["type"], "Modbus carries no text");
    if (bits != (tag_.type == LinkTag::Type::boolean) && (bits || tag_.type != LinkTag::Type::boolean))
      refuse(node_["type"], "a bit holds a bool only");
    if (node_.has("format"))
      tag_.format = static_cast<LinkTag::Format>(
          one_of(node_["format"], {"uint16", "int16", "uint32", "int32", "float32", "float64"}));
    if (tag_.address + tag_.registers() > 65536)
      refuse(node_, "'" + tag_.name + "' goes beyond address 65535");
    tag_.group = node_["group"].text("");
    if (!tag_.group.empty() && !link_.groups.contains(tag_.group)) {
      std::vector<std::string> known;
      for (const auto& [name, every] : link_.groups) known.push_back(name);
      refuse(node_["group"], "there is no poll group '" + tag_.group + "'" + did_you_mean(tag_.group, known),
             "add it to the link: groups: {" + tag_.group + ": 1s}");
    }
  }

  void read_topic() {
    node_.check_keys({"topic", "type", "direction", "first", "json", "field", "retain", "qos", "stale",
                      "scale", "offset", "range", "within", "length", "angle"},
                     problems_);
    tag_.topic = node_.required("topic").text();
    if (tag_.topic.empty() || tag_.topic.find_first_of("+#") != std::string::npos)
      refuse(node_["topic"], "'" + tag_.topic + "' is not a topic of one value",
             "+ and # are not allowed here");
    if (node_.has("type")) tag_.type = static_cast<LinkTag::Type>(one_of(node_["type"], types()));
    tag_.field = node_["field"].text("");
    tag_.json = node_["json"].boolean(!tag_.field.empty() || tag_.type == LinkTag::Type::pose);
    tag_.retain = node_["retain"].boolean(false);
    tag_.qos = whole(node_["qos"], 1, 0, 2);
    if (node_.has("stale")) tag_.stale = time_of(node_["stale"], 0);
    tag_.format = LinkTag::Format::float64;
  }

  /// A metric of Sparkplug, of the node itself or of a device.
  void read_metric() {
    node_.check_keys({"metric", "device", "type", "direction", "first", "stale", "scale", "offset", "range"},
                     problems_);
    tag_.topic = node_["metric"].text(tag_.name);
    tag_.group = node_["device"].text("");
    if (tag_.topic.empty() || tag_.topic.size() > 200)
      refuse(node_["metric"], "the name of a metric has 1 to 200 characters");
    require_level(node_["device"], tag_.group, true);
    if (node_.has("type")) tag_.type = static_cast<LinkTag::Type>(one_of(node_["type"], types()));
    if (tag_.type == LinkTag::Type::pose) refuse(node_["type"], "a metric is a bool, a number or a text");
    if (node_.has("stale")) tag_.stale = time_of(node_["stale"], 0);
    tag_.cell_first = true;
    tag_.format = LinkTag::Format::float64;
  }

  /// A field of a ROS 2 topic, or a part of a service.
  void read_message() {
    node_.check_keys({"topic", "call",      "request", "answer",  "message",     "service", "field",
                      "type",  "direction", "first",   "latched", "best_effort", "with",    "stale",
                      "scale", "offset",    "range",   "within",  "length",      "angle"},
                     problems_);
    const std::vector<std::string> roles = {"topic", "call", "request", "answer"};
    int found = 0;
    for (std::size_t k = 0; k < roles.size(); ++k) {
      if (!node_.has(roles[k])) continue;
      ++found;
      tag_.role = static_cast<LinkTag::Role>(k);
      tag_.topic = node_[roles[k]].text();
    }
    if (found != 1)
      refuse(node_, "'" + tag_.name + "' has " + (found ? "more than one place" : "no place"),
             "one of: " + join(roles, ", ") + ", with the name of a topic or service");
    const bool service = tag_.role != LinkTag::Role::topic;
    if (tag_.role == LinkTag::Role::topic || tag_.role == LinkTag::Role::call)
      tag_.message = node_.required(service ? "service" : "message").text();
    if (node_.has("type")) tag_.type = static_cast<LinkTag::Type>(one_of(node_["type"], types()));
    tag_.direction = tag_.role == LinkTag::Role::answer    ? Direction::in
                     : tag_.role == LinkTag::Role::request ? Direction::out
                                                           : Direction::both;
    if (tag_.role == LinkTag::Role::call && (tag_.type != LinkTag::Type::boolean || node_.has("field")))
      refuse(node_, "'" + tag_.name + "' calls a service: it is a bool of its own, and no field");
    if (service && node_.has("direction") &&
        one_of(node_["direction"], {"in", "out", "both"}) != static_cast<std::size_t>(tag_.direction))
      refuse(node_["direction"], "this goes " + std::string(name(tag_.direction)), "leave out `direction`");
    tag_.cell_first = true;
    tag_.field = node_["field"].text("");
    tag_.retain = node_["latched"].boolean(false);
    tag_.best_effort = node_["best_effort"].boolean(false);
    for (const std::string& field : node_["with"].keys()) tag_.constants[field] = node_["with"][field].text();
    if (node_.has("stale")) tag_.stale = time_of(node_["stale"], 0);
    tag_.format = LinkTag::Format::float64;
  }

  void read_direction() {
    const bool theirs =
        link_.kind == "modbus" && (tag_.area == LinkTag::Area::discrete || tag_.area == LinkTag::Area::input);
    const Direction only = link_.server ? Direction::out : Direction::in;
    if (node_.has("direction"))
      tag_.direction = static_cast<Direction>(one_of(node_["direction"], {"in", "out", "both"}));
    else if (theirs)
      tag_.direction = only;
    else
      refuse(node_, "'" + tag_.name + "' has no direction", "in (comes into the cell), out, or both");
    if (theirs && tag_.direction != only)
      refuse(node_["direction"], std::string("of a ") + (link_.server ? "server" : "client") +
                                     ", discrete inputs and input registers go " + name(only) + " only");
    if (node_.has("first")) tag_.cell_first = one_of(node_["first"], {"far", "cell"}) == 1;
  }

  void read_numbers() {
    tag_.scale = node_["scale"].number(Dimension::none, 1);
    tag_.offset = node_["offset"].number(Dimension::none, 0);
    if (tag_.scale == 0) refuse(node_["scale"], "the scale cannot be 0");
    if (node_.has("range")) {
      const std::vector<double> range = node_["range"].numbers();
      if (range.size() != 2 || range[0] > range[1]) refuse(node_["range"], "a range is [LOWEST, HIGHEST]");
      tag_.range = {range[0], range[1]};
    }
    if (node_.has("length")) tag_.scale *= unit_scale(node_["length"], Dimension::length);
    if (node_.has("angle")) tag_.angle_scale = unit_scale(node_["angle"], Dimension::angle);
    if (node_.has("within")) tag_.within = read_range(node_);
  }

  const LinkEntry& link_;
  const Yaml& node_;
  Problems& problems_;
  LinkTag tag_;
};

void read_host(const Yaml& node, LinkEntry& out, int fallback_port) {
  out.host = node["host"].text(out.host);
  if (!is_loopback(out.host) && !node["beyond_loopback"].boolean(false))
    refuse(node["host"], "'" + out.host + "' is beyond this machine",
           "set `beyond_loopback: true` if the link is meant to go there");
  out.port = whole(node["port"], fallback_port, 1, 65535);
  out.poll = time_of(node["poll"], out.poll);
  out.timeout = time_of(node["timeout"], out.timeout);
  if (node.has("on_loss"))
    out.on_loss = static_cast<LinkEntry::OnLoss>(one_of(node["on_loss"], {"hold", "go_on"}));
}

void read_modbus(const Yaml& node, LinkEntry& out, Problems& problems) {
  node.check_keys({"modbus", "host", "beyond_loopback", "port", "unit", "poll", "timeout", "word_order",
                   "groups", "on_loss", "tags"},
                  problems);
  out.kind = "modbus";
  out.server = one_of(node["modbus"], {"client", "server"}) == 1;
  if (out.server) out.timeout = 2'000'000'000;
  read_host(node, out, 502);
  out.unit = whole(node["unit"], 1, 0, 255);
  if (node.has("word_order"))
    out.low_word_first = one_of(node["word_order"], {"high_first", "low_first"}) == 1;
  for (const std::string& group : node["groups"].keys())
    out.groups[group] = time_of(node["groups"][group], 0);
}

/// Settings of an edge node of Sparkplug.
void read_sparkplug(const Yaml& node, LinkEntry& out) {
  out.graph["sparkplug"] = "B";
  for (const char* key : {"group", "node", "primary_host"}) {
    if (!node.has(key) && key != std::string("group")) continue;
    const std::string text = node.required(key).text();
    require_level(node[key], text, false);
    out.graph[key] = text;
  }
  if (!out.graph.contains("node")) out.graph["node"] = out.name;
}

void read_mqtt(const Yaml& node, const std::filesystem::path& folder, LinkEntry& out, Problems& problems) {
  std::vector<std::string> keys = {"mqtt",          "host", "beyond_loopback", "port", "client_id", "user",
                                   "password_file", "tls",  "keep_alive",      "poll", "timeout",   "on_loss",
                                   "tags"};
  out.kind = "mqtt";
  if (one_of(node["mqtt"], {"client", "sparkplug"}) == 1) {
    keys.insert(keys.end(), {"group", "node", "primary_host"});
    read_sparkplug(node, out);
  } else {
    keys.push_back("will");
  }
  node.check_keys(keys, problems);
  const auto file = [&](const Yaml& named) {
    const std::string text = named.text("");
    return text.empty() || text.starts_with(kSecretPrefix) ? text : (folder / text).string();
  };
  out.tls = node.has("tls");
  out.timeout = 2'000'000'000;
  read_host(node, out, out.tls ? 8883 : 1883);
  if (out.tls && node["tls"].is_map()) {
    node["tls"].check_keys({"ca", "certificate", "key"}, problems);
    out.ca_file = file(node["tls"]["ca"]);
    out.certificate = file(node["tls"]["certificate"]);
    out.key = file(node["tls"]["key"]);
  }
  out.client_id = node["client_id"].text("");
  out.user = node["user"].text("");
  out.password_file = file(node["password_file"]);
  for (const std::string& secret : {out.password_file, out.key})
    if (!secret.empty() && !secret.starts_with(kSecretPrefix)) mark_secret(secret);
  out.keep_alive = time_of(node["keep_alive"], out.keep_alive);
  const Yaml will = node["will"];
  if (out.graph.contains("sparkplug") && out.client_id.empty())
    out.client_id = out.graph["group"] + "-" + out.graph["node"];
  if (!will.defined()) return;
  will.check_keys({"topic", "text", "retain", "qos"}, problems);
  out.will_topic = will.required("topic").text();
  out.will_text = will["text"].text("");
  out.will_retain = will["retain"].boolean(true);
  out.will_qos = whole(will["qos"], 1, 0, 2);
}

void read_ros2(const Yaml& node, LinkEntry& out, Problems& problems) {
  const std::vector<std::string> joins = {"domain", "range", "peers", "namespace", "distribution", "node"};
  std::vector<std::string> keys = {"ros2", "timeout", "on_loss", "tags"};
  keys.insert(keys.end(), joins.begin(), joins.end());
  node.check_keys(keys, problems);
  out.kind = "ros2";
  one_of(node["ros2"], {"node"});
  out.timeout = time_of(node["timeout"], out.timeout);
  if (node.has("on_loss"))
    out.on_loss = static_cast<LinkEntry::OnLoss>(one_of(node["on_loss"], {"hold", "go_on"}));
  for (const std::string& key : joins)
    if (node.has(key)) out.graph[key] = node[key].is_list() ? join(node[key].texts(), ",") : node[key].text();
}

/// Reports two tags that share an address.
void check_places(const LinkEntry& link, Problems& problems) {
  if (link.kind != "modbus") return;
  std::vector<const LinkTag*> order;
  for (const LinkTag& tag : link.tags) order.push_back(&tag);
  std::stable_sort(order.begin(), order.end(), [](const LinkTag* a, const LinkTag* b) {
    return std::tie(a->area, a->address) < std::tie(b->area, b->address);
  });
  const LinkTag* furthest = nullptr;  // of the previous tags, the one that ends last
  for (const LinkTag* tag : order) {
    if (furthest && furthest->area == tag->area && tag->address < furthest->address + furthest->registers()) {
      const auto [a, b] = std::minmax(furthest, tag);  // in the order of the file
      problems.error("bad-link", b->where,
                     "'" + b->name + "' and '" + a->name + "' share an address of '" + link.name + "'",
                     "a float32 takes two registers, a float64 four, a pose six numbers");
    }
    if (!furthest || furthest->area != tag->area ||
        furthest->address + furthest->registers() < tag->address + tag->registers())
      furthest = tag;
  }
}

LinkEntry read_link(const std::string& name, const Yaml& node, const Location& where,
                    const std::filesystem::path& folder, Problems& problems) {
  LinkEntry out;
  out.name = name;
  out.where = where;
  if (node.has("modbus") + node.has("mqtt") + node.has("ros2") != 1)
    throw Error(Problem{
        "bad-link", where, "the link '" + name + "' has no protocol, or two",
        "write `modbus: client`, `modbus: server`, `mqtt: client`, `mqtt: sparkplug` or `ros2: node`"});
  if (node.has("modbus")) read_modbus(node, out, problems);
  if (node.has("mqtt")) read_mqtt(node, folder, out, problems);
  if (node.has("ros2")) read_ros2(node, out, problems);
  const Yaml tags = node["tags"];
  for (const std::string& tag : tags.keys())
    collect(problems, [&] {
      out.tags.push_back(TagReader(out, tags[tag], tag, tags.key_location(tag), problems).read());
    });
  check_places(out, problems);
  return out;
}
}  // namespace

PoseRange read_range(const Yaml& node) {
  const Yaml within = node["within"];
  const std::vector<Yaml> corners = within.items();
  if (corners.size() != 2)
    refuse(within, "a range of poses is [[x, y, z], [x, y, z]]", "two opposite corners");
  const Vec3 a = corners[0].vec3(), b = corners[1].vec3();
  PoseRange out;
  out.lower = {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
  out.upper = {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
  return out;
}

std::vector<LinkEntry> read_links(const Yaml& node, const std::filesystem::path& folder, Problems& problems) {
  std::vector<LinkEntry> out;
  if (node.keys().size() > bounds::kLinks)
    throw Error(Problem{"too-many", node.where(),
                        "there are more than " + std::to_string(bounds::kLinks) + " links",
                        "let one link carry the tags of several"});
  for (const std::string& name : node.keys())
    collect(problems,
            [&] { out.push_back(read_link(name, node[name], node.key_location(name), folder, problems)); });
  return out;
}

}  // namespace polyarm::signals
