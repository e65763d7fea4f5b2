/// Requests about tags, forcing them, and links.
#include <algorithm>
#include <memory>

#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/tags.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that requests about tags need.
struct TagOwners {
  CellData& data;
  Machine& machine;
  Observer& events;
};

/// Interval of the reports that show whether the client of a forced value is still connected.
constexpr Nanoseconds kTellEvery = 200'000'000;

Any any_of_value(const data::Value& value) {
  if (const bool* flag = value.as_boolean()) return *flag;
  if (const data::Number* number = value.as_number()) return number->value;
  return value.text();
}

const signals::Tag* declared(const TagOwners& cell, const std::string& name) {
  for (const signals::Tag& tag : cell.data.signals().tags)
    if (tag.name == name) return &tag;
  return nullptr;
}

/// Adds where the tag's value comes from or goes to.
void add_source(const TagOwners& cell, const std::string& name, const data::NameFacts& facts, TagState& out) {
  const signals::Tag* tag = declared(cell, name);
  out.direction = "internal";
  out.source = facts.sets.empty() ? "cell" : "data " + join(facts.sets, ", ");
  out.quality = "good";
  if (tag && tag->role == data::TagRole::command) out.direction = "out", out.source = tag->interface;
  if (tag && tag->role == data::TagRole::state) out.direction = "in", out.source = tag->interface;
  if (const auto link = cell.data.links().source_of(name)) {
    out.direction = out.direction == "internal" ? link->direction : out.direction + ", " + link->direction;
    out.source += ", link " + link->link;
    out.quality = link->quality;
  }
  if (const auto sent = cell.data.tags().sent(name)) out.output = *sent;
  if (!tag) return;
  out.unit = tag->unit;
  const auto rule = [](const std::optional<data::Value>& value) {
    return value ? std::optional(any_of_value(*value)) : std::nullopt;
  };
  out.rules = {rule(tag->rules.on_stop), rule(tag->rules.on_hold), rule(tag->rules.on_link_loss)};
}

TagState tag_state(const TagOwners& cell, const std::string& name) {
  const data::Value& value = *cell.data.store.find(name);
  const data::NameFacts facts = *cell.data.store.facts(name);
  const std::string type = data::name(value.kind());
  TagState out;
  out.name = name;
  out.type = type.substr(type.find(' ') + 1);
  out.value = any_of_value(value);
  out.text = value.text();
  out.forced = facts.forced;
  out.tag = facts.tag;
  out.changed_by = facts.changed_by;
  if (facts.changed_at >= 0) out.changed_s = seconds(facts.changed_at);
  add_source(cell, name, facts, out);
  return out;
}

std::vector<LinkState> link_states(const TagOwners& cell) {
  std::vector<LinkState> out;
  for (const CellLinks::Status& link : cell.data.links().status())
    out.push_back({link.entry->name, link.entry->address(), link.state.up, link.state.reason, link.state.losses,
                   link.state.exchanges, static_cast<double>(link.state.round_ns) * 1e-6,
                   link.entry->on_loss == signals::LinkEntry::OnLoss::hold ? "hold" : "go_on",
                   link.entry->tags.size()});
  return out;
}

/// Parses the value of a request as the type that the name has.
data::Value desired_value(const data::Value& like, const Any& given) {
  const std::optional<std::string> text = given.text();
  if (like.as_boolean()) {
    if (const auto flag = given.flag()) return *flag;
    if (text && equal_ignoring_case(*text, "true")) return true;
    if (text && equal_ignoring_case(*text, "false")) return false;
  }
  if (const data::Number* number = like.as_number()) {
    if (const auto value = given.number()) return data::Number{*value, number->dimension};
    if (text)
      if (const auto value = parse_quantity(*text, number->dimension))
        return data::Number{*value, number->dimension};
  }
  if (like.as_text() && text) return *text;
  throw Error("bad-argument", "'value' is " + given.dump() + ", the tag is " + data::name(like.kind()),
              like.as_boolean() ? "true or false" : "");
}

/// The client's name, as its door gives it.
std::string asker(const std::optional<std::string>& by) {
  return !by || by->empty() ? "a person" : by->substr(0, 80);
}

const data::Value& value_named(const TagOwners& cell, const std::string& name) {
  if (const data::Value* value = cell.data.store.find(name)) return *value;
  throw Error("unknown-name",
              "there is no tag or variable '" + name + "'" + did_you_mean(name, cell.data.store.names()));
}

/// A forced value that is released when the request ends, for whatever reason.
class Force {
 public:
  Force(const TagOwners& cell, std::string name, data::Value value, std::string by)
      : cell_(cell), name_(std::move(name)), by_(std::move(by)) {
    const auto facts = cell_.data.store.facts(name_);
    if (facts && facts->forced) throw Error("in-use", "'" + name_ + "' is forced already", "end that first");
    cell_.data.store.force(name_, std::move(value), by_);
    cell_.events.on_note("'" + name_ + "' is forced to " + cell_.data.store.find(name_)->text() + " by " +
                         by_);
  }
  ~Force() {
    if (!forced()) return;  // somebody has released it
    cell_.data.store.release(name_, by_);
    cell_.events.on_note("'" + name_ + "' is no longer forced");
  }
  bool forced() const {
    const auto facts = cell_.data.store.facts(name_);
    return facts && facts->forced;
  }
  Force(const Force&) = delete;
  Force& operator=(const Force&) = delete;

 private:
  TagOwners cell_;
  std::string name_, by_;
};

TagsList::Answer tags_list(const TagOwners& cell, const TagsList& request) {
  std::vector<std::string> wanted = request.names.value_or(Names{});
  const bool all = wanted.empty();
  if (all) wanted = cell.data.store.names();
  TagsList::Answer out;
  for (const std::string& name : wanted) {
    value_named(cell, name);
    if (!all || cell.data.store.facts(name)->tag || cell.data.links().source_of(name))
      out.tags.push_back(tag_state(cell, name));
  }
  out.links = link_states(cell);
  return out;
}

TagState tags_set(const TagOwners& cell, const TagsSet& request) {
  const data::Value& like = value_named(cell, request.name);
  if (cell.data.store.tag_role(request.name) == data::TagRole::state)
    throw Error("read-only", "'" + request.name + "' is a measured value of the hardware",
                "force it: polyarm tags force " + request.name + " VALUE keeps the value as long as it runs");
  if (const auto link = cell.data.links().source_of(request.name); link && link->direction == "in")
    throw Error("read-only", "'" + request.name + "' comes from the link '" + link->link + "'",
                "force it: polyarm tags force " + request.name + " VALUE keeps the value as long as it runs");
  cell.data.store.set(request.name, desired_value(like, request.value), asker(request.by));
  return tag_state(cell, request.name);
}

Poll<TagState> tags_force(const TagOwners& cell, const TagsForce& request) {
  using Forced = Progress<TagState>;
  const data::Value& like = value_named(cell, request.name);
  auto force = std::make_shared<Force>(cell, request.name, desired_value(like, request.value), asker(request.by));
  return [cell, force, name = request.name, reported = Nanoseconds{-1}]() mutable {
    if (!force->forced()) return Forced::done(tag_state(cell, name));
    if (reported >= 0 && cell.machine.now() - reported < kTellEvery) return Forced{};
    reported = cell.machine.now();
    return Forced::more(tag_state(cell, name));
  };
}

TagState tags_release(const TagOwners& cell, const TagsRelease& request) {
  const auto facts = cell.data.store.facts(request.name);
  if (!facts || !facts->forced) throw Error("not-forced", "'" + request.name + "' is not forced");
  cell.data.store.release(request.name, asker(request.by));
  cell.events.on_note("'" + request.name + "' is no longer forced");
  return tag_state(cell, request.name);
}

OrNull<std::string> text_of(const std::optional<data::Value>& value) {
  OrNull<std::string> out;
  if (value) out = value->text();
  return out;
}

TagsHistory::Answer tags_history(const TagOwners& cell, const TagsHistory& request) {
  const std::vector<std::string> names = request.names.value_or(Names{});
  const auto after = static_cast<std::uint64_t>(std::max(0.0, request.after.value_or(0)));
  TagsHistory::Answer out;
  out.last = cell.data.store.version();
  for (const data::Change& change : cell.data.store.changes_since(after)) {
    if (!names.empty() && std::find(names.begin(), names.end(), change.name) == names.end()) continue;
    out.changes.push_back({change.version, change.name, text_of(change.old), text_of(change.now), change.who});
  }
  return out;
}

}  // namespace

std::vector<Handler> tag_handlers() {
  return handlers<tags_list, tags_set, tags_force, tags_release, tags_history>();
}

}  // namespace polyarm::cell
