#include "polyarm/signals/link_exchange.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::signals {

namespace {
using process::Packer;
using process::Unpacker;

constexpr std::size_t kMostName = 65536;  // for texts from the cell's own files

template <class Enum>
std::uint8_t number_of(Enum value) {
  return static_cast<std::uint8_t>(value);
}
template <class Enum>
Enum enum_of(Unpacker& in) {
  return static_cast<Enum>(in.number<std::uint8_t>());
}
std::uint32_t count_of(std::size_t size) {
  return static_cast<std::uint32_t>(size);
}

void pack(Packer& out, const Pose& pose) {
  for (const double each : {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x, pose.rotation.y,
                            pose.rotation.z, pose.rotation.w})
    out.number(each);
}
Pose unpack_pose(Unpacker& in) {
  double n[7];
  for (double& each : n) each = in.number<double>();
  return {{n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}};
}

void pack(Packer& out, const LinkTag& tag) {
  out.text(tag.name).number(number_of(tag.direction)).number(number_of(tag.type));
  out.number(tag.scale).number(tag.offset).number(tag.angle_scale).number(tag.range.has_value());
  const auto range = tag.range.value_or(std::array<double, 2>{});
  out.number(range[0]).number(range[1]);
  for (const auto& corner : {tag.within.lower, tag.within.upper})
    for (const double each : corner) out.number(each);
  out.number(tag.cell_first).number(number_of(tag.area)).number(tag.address).number(number_of(tag.format));
  out.text(tag.group).text(tag.topic).number(tag.json).text(tag.field).number(tag.retain).number(tag.qos);
  out.number(tag.stale);
}

LinkTag unpack_tag(Unpacker& in) {
  LinkTag out;
  out.name = in.text(kMostName);
  out.direction = enum_of<Direction>(in);
  out.type = enum_of<LinkTag::Type>(in);
  out.scale = in.number<double>();
  out.offset = in.number<double>();
  out.angle_scale = in.number<double>();
  const bool ranged = in.truth();
  const double lower = in.number<double>(), upper = in.number<double>();
  if (ranged) out.range = {lower, upper};
  for (auto* corner : {&out.within.lower, &out.within.upper})
    for (double& each : *corner) each = in.number<double>();
  out.cell_first = in.truth();
  out.area = enum_of<LinkTag::Area>(in);
  out.address = in.number<int>();
  out.format = enum_of<LinkTag::Format>(in);
  out.group = in.text(kMostName);
  out.topic = in.text(kMostName);
  out.json = in.truth();
  out.field = in.text(kMostName);
  out.retain = in.truth();
  out.qos = in.number<int>();
  out.stale = in.number<Nanoseconds>();
  return out;
}

void pack(Packer& out, const data::Value& value) {
  out.number(number_of(value.kind()));
  if (const bool* truth = value.as_boolean()) out.number(*truth);
  if (const data::Number* number = value.as_number()) out.number(number->value);
  if (const std::string* text = value.as_text()) out.text(*text);
  if (const data::Point* point = value.as_point()) {
    out.number(point->quaternion_given);
    pack(out, point->pose);
  }
}

std::optional<data::Value> unpack_value(Unpacker& in) {
  switch (enum_of<data::Kind>(in)) {
    case data::Kind::boolean:
      return data::Value(in.truth());
    case data::Kind::number:
      return data::Value(in.number<double>());
    case data::Kind::text:
      return data::Value(in.text(bounds::kTextBytes));
    case data::Kind::pose: {
      data::Point point;
      point.quaternion_given = in.truth();
      point.pose = unpack_pose(in);
      return data::Value(std::move(point));
    }
    default:
      return std::nullopt;
  }
}

/// True if taken_number() and taken_pose() accept the value.
bool is_taken(const LinkTag& tag, const data::Value& value) {
  if (tag.direction == Direction::out) return false;
  switch (tag.type) {
    case LinkTag::Type::boolean:
      return value.as_boolean() != nullptr;
    case LinkTag::Type::text:
      return value.as_text() != nullptr;
    case LinkTag::Type::number: {
      const data::Number* number = value.as_number();
      return number && std::isfinite(number->value) &&
             (!tag.range || (number->value >= (*tag.range)[0] && number->value <= (*tag.range)[1]));
    }
    case LinkTag::Type::pose: {
      const data::Point* point = value.as_point();
      return point && !tag.within.refuses(point->pose);
    }
  }
  return false;
}

std::string cut(const std::string& text) {
  return text.substr(0, kMostLinkWords);
}
}  // namespace

void pack(Packer& out, const LinkEntry& entry) {
  out.text(entry.name).text(entry.kind).number(entry.server).text(entry.host).number(entry.port);
  out.number(entry.poll).number(entry.timeout).number(entry.unit).number(entry.low_word_first);
  out.number(count_of(entry.groups.size()));
  for (const auto& [name, every] : entry.groups) out.text(name).number(every);
  out.number(count_of(entry.graph.size()));
  for (const auto& [key, text] : entry.graph) out.text(key).text(text);
  out.text(entry.client_id).text(entry.user).text(entry.password).text(entry.will_topic).text(entry.will_text);
  out.number(entry.will_retain).number(entry.will_qos).number(entry.tls);
  out.text(entry.ca_file).text(entry.certificate).text(entry.key).number(entry.keep_alive);
  out.number(count_of(entry.tags.size()));
  for (const LinkTag& tag : entry.tags) pack(out, tag);
}

LinkEntry unpack_entry(Unpacker& in) {
  LinkEntry out;
  out.name = in.text(kMostName);
  out.kind = in.text(kMostName);
  out.server = in.truth();
  out.host = in.text(kMostName);
  out.port = in.number<int>();
  out.poll = in.number<Nanoseconds>();
  out.timeout = in.number<Nanoseconds>();
  out.unit = in.number<int>();
  out.low_word_first = in.truth();
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    const std::string name = in.text(kMostName);
    out.groups[name] = in.number<Nanoseconds>();
  }
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    const std::string key = in.text(kMostName);
    out.graph[key] = in.text(kMostName);
  }
  for (std::string* text : {&out.client_id, &out.user, &out.password, &out.will_topic, &out.will_text})
    *text = in.text(kMostName);
  out.will_retain = in.truth();
  out.will_qos = in.number<int>();
  out.tls = in.truth();
  for (std::string* text : {&out.ca_file, &out.certificate, &out.key}) *text = in.text(kMostName);
  out.keep_alive = in.number<Nanoseconds>();
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) out.tags.push_back(unpack_tag(in));
  return out;
}

void pack(Packer& out, const std::vector<LinkValue>& values) {
  out.number(count_of(values.size()));
  for (const LinkValue& each : values) {
    out.number(count_of(each.tag));
    pack(out, each.value);
  }
}

std::vector<LinkValue> unpack_values(Unpacker& in) {
  std::vector<LinkValue> out;
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    const std::size_t tag = in.number<std::uint32_t>();
    if (auto value = unpack_value(in); value && in.good()) out.push_back({tag, std::move(*value)});
  }
  return out;
}

void pack(Packer& out, const LinkReport& news) {
  pack(out, news.values);
  out.number(count_of(news.seen.size()));
  for (const std::size_t tag : news.seen) out.number(count_of(tag));
  out.number(count_of(news.refused.size()));
  for (const auto& [tag, why] : news.refused) out.number(count_of(tag)).text(cut(why));
  out.number(count_of(news.notes.size()));
  for (const std::string& note : news.notes) out.text(cut(note));
  out.number(news.alive);
}

bool unpack_reports(Unpacker& in, const LinkEntry& entry, LinkReport& news) {
  const std::size_t tags = entry.tags.size();
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    const std::size_t tag = in.number<std::uint32_t>();
    auto value = unpack_value(in);
    if (!in.good() || tag >= tags || !value || !is_taken(entry.tags[tag], *value)) return false;
    news.values.push_back({tag, std::move(*value)});
  }
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    news.seen.push_back(in.number<std::uint32_t>());
    if (news.seen.back() >= tags) return false;
  }
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left) {
    const std::size_t tag = in.number<std::uint32_t>();
    if (tag >= tags) return false;
    news.refuse(tag, printable_line(in.text(kMostLinkWords)));
  }
  for (auto left = in.number<std::uint32_t>(); left > 0 && in.good(); --left)
    news.notes.push_back(printable_line(in.text(kMostLinkWords)));
  news.alive = in.truth();
  return in.good() && in.rest().empty();
}

}  // namespace polyarm::signals
