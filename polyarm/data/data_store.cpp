#include "polyarm/data/data_store.hpp"

#include <algorithm>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::data {

void DataStore::declare_tag(const std::string& name, Value initial, TagRole role) {
  const auto [at, added] = slots_.try_emplace(name);
  at->second.tag = role;
  if (added) change(name, at->second, std::move(initial), "cell", true);
}

bool DataStore::is_tag(const std::string& name) const {
  return tag_role(name).has_value();
}

std::optional<TagRole> DataStore::tag_role(const std::string& name) const {
  const auto at = slots_.find(name);
  return at == slots_.end() ? std::nullopt : at->second.tag;
}

std::size_t DataStore::set_index(const std::string& set) {
  const auto at = std::find(sets_.begin(), sets_.end(), set);
  if (at != sets_.end()) return static_cast<std::size_t>(at - sets_.begin());
  sets_.push_back(set);
  return sets_.size() - 1;
}

void DataStore::load(const std::string& set, const DataSet& content, const std::string& who) {
  const std::size_t index = set_index(set);
  std::erase_if(writes_, [&](const auto& write) { return write.first.first == index; });
  forget_missing(index, content, who);
  for (const Entry& entry : content.entries()) {
    load_entry(index, entry, who);
    set_group(entry.name, entry.group);
  }
}

void DataStore::forget_missing(std::size_t set, const DataSet& content, const std::string& who) {
  for (auto at = slots_.begin(); at != slots_.end();) {
    Slot& slot = at->second;
    const bool leaves = !content.find(at->first) && std::erase(slot.sets, set) > 0;
    if (!leaves || !slot.sets.empty() || slot.tag) {
      ++at;
      continue;
    }
    ++version_;
    record(at->first, slot.value, std::nullopt, who);
    at = slots_.erase(at);
  }
}

void DataStore::load_entry(std::size_t set, const Entry& entry, const std::string& who) {
  const auto [at, added] = slots_.try_emplace(entry.name);
  Slot& slot = at->second;
  if (std::find(slot.sets.begin(), slot.sets.end(), set) == slot.sets.end()) slot.sets.push_back(set);
  if (slot.tag == TagRole::state) {
    if (!(slot.value == entry.value)) writes_[{set, entry.name}] = slot.value;
    return;
  }
  if (change(entry.name, slot, entry.value, who, added)) note_writes(entry.name, slot, set);
}

void DataStore::take_outside(const std::string& set, const std::vector<std::pair<std::string, Value>>& values,
                             const std::string& who) {
  const std::size_t index = set_index(set);
  for (const auto& [name, value] : values) load_entry(index, {name, value, {}, {}}, who);
}

std::vector<std::string> DataStore::sets() const {
  return sets_;
}

std::string DataStore::set_of(const std::string& name) const {
  const auto at = slots_.find(name);
  return at == slots_.end() || at->second.sets.empty() ? std::string{} : sets_[at->second.sets.front()];
}

std::string DataStore::group_of(const std::string& name) const {
  const auto at = slots_.find(name);
  return at == slots_.end() ? std::string{} : at->second.group;
}

void DataStore::set_group(const std::string& name, const std::string& group) {
  const auto at = slots_.find(name);
  if (at == slots_.end() || at->second.group == group) return;
  at->second.group = group;
  ++groups_version_;
}

const Value* DataStore::find(std::string_view name) const {
  const auto at = slots_.find(name);
  return at == slots_.end() ? nullptr : &at->second.value;
}

std::vector<std::string> DataStore::names() const {
  std::vector<std::string> out;
  for (const auto& slot : slots_) out.push_back(slot.first);
  std::sort(out.begin(), out.end());
  return out;
}

bool DataStore::set(const std::string& name, Value value, const std::string& who) {
  if (slots_.size() >= kMostNames && !slots_.contains(name))
    throw Error("too-many", "the cell has " + std::to_string(kMostNames) + " names already",
                "keep many values in a list");
  const auto [at, added] = slots_.try_emplace(name);
  if (added && !sets_.empty()) at->second.sets.push_back(0);
  if (!change(name, at->second, std::move(value), who, added)) return false;
  note_writes(name, at->second);
  return true;
}

bool DataStore::change(const std::string& name, Slot& slot, Value value, const std::string& who,
                       bool is_new) {
  if (slot.behind) {
    slot.behind = std::move(value);
    return false;
  }
  if (!is_new && slot.value == value) return false;
  slot.changed_at = is_new ? -1 : now_;
  slot.changed_by = who;
  std::optional<Value> old;
  if (!is_new) old = std::move(slot.value);
  slot.value = std::move(value);
  ++version_;
  record(name, std::move(old), slot.value, who);
  return true;
}

std::optional<NameFacts> DataStore::facts(const std::string& name) const {
  const auto at = slots_.find(name);
  if (at == slots_.end()) return std::nullopt;
  const Slot& slot = at->second;
  NameFacts out{slot.tag.has_value(), slot.behind.has_value(), slot.changed_at, slot.changed_by, {}};
  for (const std::size_t set : slot.sets) out.sets.push_back(sets_[set]);
  return out;
}

void DataStore::force(const std::string& name, Value value, const std::string& who) {
  const auto at = slots_.find(name);
  if (at == slots_.end())
    throw Error("unknown-name", "there is no tag or variable '" + name + "'" + did_you_mean(name, names()),
                "polyarm tags shows them");
  Slot& slot = at->second;
  if (slot.value.kind() != value.kind())
    throw Error("bad-value",
                "'" + name + "' is " + data::name(slot.value.kind()) + ", not " + data::name(value.kind()));
  const Value behind = slot.behind.value_or(slot.value);
  slot.behind.reset();
  if (change(name, slot, std::move(value), who, false)) note_writes(name, slot);
  slot.behind = behind;
}

void DataStore::release(const std::string& name, const std::string& who) {
  const auto at = slots_.find(name);
  if (at == slots_.end() || !at->second.behind) return;
  Value behind = std::move(*at->second.behind);
  at->second.behind.reset();
  if (change(name, at->second, std::move(behind), who, false)) note_writes(name, at->second);
}

void DataStore::note_writes(const std::string& name, const Slot& slot, std::optional<std::size_t> except) {
  for (const std::size_t set : slot.sets)
    if (set != except) writes_[{set, name}] = slot.value;
}

std::vector<PendingWrite> DataStore::take_writes() {
  std::vector<PendingWrite> out;
  for (auto& [key, value] : writes_) out.push_back({sets_[key.first], key.second, std::move(value)});
  writes_.clear();
  return out;
}

static_assert(DataStore::kMostNames == bounds::kDataNames && DataStore::kMostKept == bounds::kValuesKept &&
              DataStore::kChangesKept == bounds::kChangesKept);

namespace {
/// The number of values in a change, as counted towards kMostKept; 64 bytes of text count as one value. It is
/// constant, because the values of a change are never modified.
std::size_t weight(const Change& change) {
  std::size_t out = 1;
  for (const std::optional<Value>* value : {&change.old, &change.now})
    if (*value) out += (*value)->extent().values + ((*value)->as_text() ? (*value)->as_text()->size() / 64 : 0);
  return out;
}
}  // namespace

void DataStore::record(const std::string& name, std::optional<Value> old, std::optional<Value> now,
                       const std::string& who) {
  changes_.push_back({version_, name, std::move(old), std::move(now), who});
  kept_ += weight(changes_.back());
  while (changes_.size() > kChangesKept || (kept_ > kMostKept && changes_.size() > 1)) {
    kept_ -= weight(changes_.front());
    changes_.pop_front();
  }
}

std::vector<Change> DataStore::changes_since(std::uint64_t version) const {
  const auto first =
      std::upper_bound(changes_.begin(), changes_.end(), version,
                       [](std::uint64_t v, const Change& change) { return v < change.version; });
  return {first, changes_.end()};
}

}  // namespace polyarm::data
