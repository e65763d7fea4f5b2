#include "polyarm/data/data_set.hpp"

#include <algorithm>

namespace polyarm::data {

void DataSet::set(const std::string& name, Value value, Location where) {
  const auto [at, added] = index_.try_emplace(name, entries_.size());
  if (added) {
    entries_.push_back({name, std::move(value), std::move(where), {}});
    return;
  }
  Entry& entry = entries_[at->second];
  entry.value = std::move(value);
  if (where.line > 0) entry.where = std::move(where);
}

void DataSet::set_group(const std::string& name, std::string group) {
  const auto at = index_.find(name);
  if (at != index_.end()) entries_[at->second].group = std::move(group);
}

const Entry* DataSet::find(const std::string& name) const {
  const auto at = index_.find(name);
  return at == index_.end() ? nullptr : &entries_[at->second];
}

const Value* DataSet::value(const std::string& name) const {
  const Entry* entry = find(name);
  return entry ? &entry->value : nullptr;
}

std::vector<std::string> DataSet::names() const {
  std::vector<std::string> out;
  for (const Entry& entry : entries_) out.push_back(entry.name);
  return out;
}

bool operator==(const DataSet& a, const DataSet& b) {
  return std::equal(a.entries_.begin(), a.entries_.end(), b.entries_.begin(), b.entries_.end(),
                    [](const Entry& x, const Entry& y) {
                      return x.name == y.name && x.value == y.value && x.group == y.group;
                    });
}

std::optional<ScriptInformation> script_information(const DataSet& set) {
  const Value* script = set.value("ScriptFile");
  if (!script || !script->as_text()) return std::nullopt;
  ScriptInformation out{*script->as_text(), std::nullopt};
  const Value* points = set.value("PointFile");
  if (points && points->as_text()) out.point_file = *points->as_text();
  return out;
}

}  // namespace polyarm::data
