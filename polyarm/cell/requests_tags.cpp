/// Requests about tags, their forcing, and links.
#include <algorithm>
#include <memory>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

namespace {

/// A force that is renewed this often shows whether its asker is still there.
constexpr Nanoseconds kTellEvery = 200'000'000;

Json json_of(const data::Value& value) {
  if (const bool* flag = value.as_boolean()) return *flag;
  if (const data::Number* number = value.as_number()) return number->value;
  return value.text();
}

const signals::Tag* declared(const Cell& cell, const std::string& name) {
  for (const signals::Tag& tag : cell.signals().tags)
    if (tag.name == name) return &tag;
  return nullptr;
}

/// Where the tag's value comes from or goes to, and how.
void add_source(const Cell& cell, const std::string& name, const data::NameFacts& facts, Json& out) {
  const signals::Tag* tag = declared(cell, name);
  std::string direction = "internal", source = facts.sets.empty() ? "cell" : "data " + join(facts.sets, ", ");
  std::string quality = "good";
  if (tag && tag->role == data::TagRole::command) direction = "out", source = tag->interface;
  if (tag && tag->role == data::TagRole::state) direction = "in", source = tag->interface;
  if (const auto link = cell.links().source_of(name)) {
    direction = direction == "internal" ? link->direction : direction + ", " + link->direction;
    source += ", link " + link->link;
    quality = link->quality;
  }
  out["unit"] = tag ? tag->unit : "";
  out["direction"] = direction;
  out["source"] = source;
  out["quality"] = quality;
  const auto sent = cell.tags().sent(name);
  out["output"] = sent ? Json(*sent) : Json();
  Json rules = Json::object();
  const auto rule = [&](const char* key, const std::optional<data::Value>& value) {
    if (value) rules[key] = json_of(*value);
  };
  if (tag) rule("on_stop", tag->rules.on_stop);
  if (tag) rule("on_hold", tag->rules.on_hold);
  if (tag) rule("on_link_loss", tag->rules.on_link_loss);
  out["rules"] = rules;
}

Json tag_json(Cell& cell, const std::string& name) {
  const data::Value& value = *cell.store().find(name);
  const data::NameFacts facts = *cell.store().facts(name);
  std::string type = data::name(value.kind());
  Json out{{"name", name},
           {"type", type.substr(type.find(' ') + 1)},
           {"value", json_of(value)},
           {"text", value.text()},
           {"forced", facts.forced},
           {"tag", facts.tag},
           {"changed_s", Json()},
           {"changed_by", facts.changed_by}};
  if (facts.changed_at >= 0) out["changed_s"] = seconds(facts.changed_at);
  add_source(cell, name, facts, out);
  return out;
}

Json links_json(const Cell& cell) {
  Json out = Json::array();
  for (const CellLinks::Status& link : cell.links().status())
    out.push_back({{"name", link.entry->name},
                   {"address", link.entry->address()},
                   {"up", link.state.up},
                   {"reason", link.state.reason},
                   {"losses", link.state.losses},
                   {"exchanges", link.state.exchanges},
                   {"round_ms", static_cast<double>(link.state.round_ns) * 1e-6},
                   {"on_loss", link.entry->on_loss == signals::LinkEntry::OnLoss::hold ? "hold" : "go_on"},
                   {"tags", link.entry->tags.size()}});
  return out;
}

/// The value that a request says, of the kind that the name has.
data::Value wanted_value(const data::Value& like, const Json& given) {
  if (like.as_boolean()) {
    if (given.is_boolean()) return given.get<bool>();
    if (given.is_string() && equal_ignoring_case(given.get<std::string>(), "true")) return true;
    if (given.is_string() && equal_ignoring_case(given.get<std::string>(), "false")) return false;
  }
  if (const data::Number* number = like.as_number()) {
    if (given.is_number()) return data::Number{given.get<double>(), number->dimension};
    if (given.is_string())
      if (const auto value = parse_quantity(given.get<std::string>(), number->dimension))
        return data::Number{*value, number->dimension};
  }
  if (like.as_text() && given.is_string()) return given.get<std::string>();
  throw Error("bad-argument", "'value' is " + given.dump() + ", the tag is " + data::name(like.kind()),
              like.as_boolean() ? "true or false" : "");
}

/// Who asks, as a door says it.
std::string who_asks(const Json& arguments) {
  const std::string by = text_argument(arguments, "by", "");
  return by.empty() ? "a person" : by.substr(0, 80);
}

/// Released when the request ends, however it ends.
class Force {
 public:
  Force(Cell& cell, std::string name, data::Value value, std::string by)
      : cell_(cell), name_(std::move(name)), by_(std::move(by)) {
    const auto facts = cell_.store().facts(name_);
    if (facts && facts->forced) throw Error("in-use", "'" + name_ + "' is forced already", "end that first");
    cell_.store().force(name_, std::move(value), by_);
    cell_.tell("'" + name_ + "' is forced to " + cell_.store().find(name_)->text() + " by " + by_);
  }
  ~Force() {
    if (!forced()) return;  // somebody has released it
    cell_.store().release(name_, by_);
    cell_.tell("'" + name_ + "' is no longer forced");
  }
  bool forced() const {
    const auto facts = cell_.store().facts(name_);
    return facts && facts->forced;
  }
  Force(const Force&) = delete;
  Force& operator=(const Force&) = delete;

 private:
  Cell& cell_;
  std::string name_, by_;
};

Poll tags_list(Cell& cell, const Json& arguments) {
  std::vector<std::string> wanted = list_argument(arguments, "names");
  const bool all = wanted.empty();
  if (all) wanted = cell.store().names();
  Json tags = Json::array();
  for (const std::string& name : wanted) {
    const auto facts = cell.store().facts(name);
    if (!facts)
      throw Error("unknown-name",
                  "there is no tag or variable '" + name + "'" + did_you_mean(name, cell.store().names()));
    if (!all || facts->tag || cell.links().source_of(name)) tags.push_back(tag_json(cell, name));
  }
  return at_once({{"tags", tags}, {"links", links_json(cell)}});
}

Poll tags_set(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  const data::Value* like = cell.store().find(name);
  if (!like)
    throw Error("unknown-name",
                "there is no tag or variable '" + name + "'" + did_you_mean(name, cell.store().names()));
  if (cell.store().tag_role(name) == data::TagRole::state)
    throw Error("read-only", "'" + name + "' says what the hardware measures",
                "force it: polyarm tags force " + name + " VALUE keeps the value as long as it runs");
  if (const auto link = cell.links().source_of(name); link && link->direction == "in")
    throw Error("read-only", "'" + name + "' comes from the link '" + link->link + "'",
                "force it: polyarm tags force " + name + " VALUE keeps the value as long as it runs");
  cell.store().set(name, wanted_value(*like, arguments.value("value", Json())), who_asks(arguments));
  return at_once(tag_json(cell, name));
}

Poll tags_force(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  const data::Value* like = cell.store().find(name);
  if (!like)
    throw Error("unknown-name",
                "there is no tag or variable '" + name + "'" + did_you_mean(name, cell.store().names()));
  auto force = std::make_shared<Force>(cell, name, wanted_value(*like, arguments.value("value", Json())),
                                       who_asks(arguments));
  return [force, name, told = Nanoseconds{-1}](Cell& c) mutable {
    if (!force->forced()) return Progress::done(tag_json(c, name));
    if (told >= 0 && c.now() - told < kTellEvery) return Progress{};
    told = c.now();
    return Progress::more(tag_json(c, name));
  };
}

Poll tags_release(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  const auto facts = cell.store().facts(name);
  if (!facts || !facts->forced) throw Error("not-forced", "'" + name + "' is not forced");
  cell.store().release(name, who_asks(arguments));
  cell.tell("'" + name + "' is no longer forced");
  return at_once(tag_json(cell, name));
}

Poll tags_history(Cell& cell, const Json& arguments) {
  const std::vector<std::string> names = list_argument(arguments, "names");
  const auto after = static_cast<std::uint64_t>(std::max(0.0, number_argument(arguments, "after", 0)));
  Json changes = Json::array();
  for (const data::Change& change : cell.store().changes_since(after)) {
    if (!names.empty() && std::find(names.begin(), names.end(), change.name) == names.end()) continue;
    changes.push_back({{"number", change.version},
                       {"name", change.name},
                       {"old", change.old ? Json(change.old->text()) : Json()},
                       {"now", change.now ? Json(change.now->text()) : Json()},
                       {"by", change.who}});
  }
  return at_once({{"last", cell.store().version()}, {"changes", changes}});
}

}  // namespace

const std::vector<RequestRow>& tag_rows() {
  static const std::vector<RequestRow> table = {
      {{"tags.list",
        {{"names", kNames}},
        "{tags: [{name, type, unit, value, text, direction, source, quality, forced, changed_s, changed_by, "
        "output, "
        "rules}], links: [{name, address, up, reason, losses, exchanges, round_ms, on_loss, tags}]}",
        "every tag, or those named (variables of data, too), and the links",
        false},
       tags_list},
      {{"tags.set",
        {{"name", kText, true}, {"value", ArgumentType::any, true}, {"by", kText}},
        "{name, value, …}, as in tags.list",
        "change a tag or variable once, as a person; `by` is told as who has changed it (the pendant's port "
        "puts "
        "its client's name there)",
        true},
       tags_set},
      {{"tags.force",
        {{"name", kText, true}, {"value", ArgumentType::any, true}, {"by", kText}},
        "{name, value, …} again and again",
        "the tag keeps the value whatever is set meanwhile, for as long as the asker is there",
        true},
       tags_force},
      {{"tags.release",
        {{"name", kText, true}, {"by", kText}},
        "{name, value, …}, as in tags.list",
        "a forced tag follows its source again, whoever forced it",
        true},
       tags_release},
      {{"tags.history",
        {{"names", kNames}, {"after", kNumber}},
        "{last, changes: [{number, name, old, now, by}]}",
        "who changed what, oldest first: the newest 1024 changes of tags, variables and points, or those "
        "after a number",
        false},
       tags_history},
  };
  return table;
}

}  // namespace polyarm::cell
