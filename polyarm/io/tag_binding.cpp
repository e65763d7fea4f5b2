#include "polyarm/io/tag_binding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

std::size_t CellStates::add(std::string name) {
  names_.push_back(std::move(name));
  values_.push_back(0);
  return values_.size() - 1;
}

std::optional<std::size_t> CellStates::find(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names_.begin());
}

namespace {
/// Suggests names for the first 50 wrong ones only, because each search compares all names.
class Suggestions {
 public:
  explicit Suggestions(std::vector<std::string> known) : known_{std::move(known)} {}
  std::string operator()(const std::string& wrong) {
    constexpr int kMost = 50;
    return ++wrong_ <= kMost ? did_you_mean(wrong, known_) : std::string{};
  }
  /// "known with this ending: arm/tool/vacuum"; empty: none, or too many to list.
  std::string with_ending_of(const std::string& wrong) const {
    constexpr std::size_t kListed = 6;
    const std::string ending = "/" + wrong.substr(wrong.rfind('/') + 1);
    std::vector<std::string> found;
    for (const std::string& name : known_)
      if (name.ends_with(ending)) found.push_back(name);
    return found.empty() || found.size() > kListed ? "" : "known with this ending: " + join(found, ", ");
  }

 private:
  std::vector<std::string> known_;
  int wrong_ = 0;
};

Suggestions states_of(const hardware::InterfaceTable& table, const CellStates& own) {
  std::vector<std::string> known = table.state_names();
  known.insert(known.end(), own.names().begin(), own.names().end());
  return Suggestions(std::move(known));
}

/// What the hardware states before the first cycle, such as the parts of a feeder; else the tag's own.
data::Value initial_value(const signals::Tag& tag, const hardware::InterfaceTable& table) {
  if (tag.role != data::TagRole::state) return tag.initial;
  const auto index = table.find_state(tag.interface);
  const double value = index ? table.states()[*index] : std::numeric_limits<double>::quiet_NaN();
  return std::isfinite(value) ? tag.from_interface(value) : tag.initial;
}
}  // namespace

TagBinding::TagBinding(const std::vector<signals::Tag>& tags, const hardware::InterfaceTable& table,
                       const CellStates& own, data::DataStore& store, Problems& problems)
    : store_(store) {
  Suggestions states = states_of(table, own), commands(table.command_names());
  for (const signals::Tag& tag : tags) {
    store_.declare_tag(tag.name, initial_value(tag, table), tag.role);
    if (tag.role == data::TagRole::state) {
      const auto from_cell = own.find(tag.interface);
      const auto from_table = table.find_state(tag.interface);
      if (from_cell)
        in_.push_back({tag, true, *from_cell});
      else if (from_table)
        in_.push_back({tag, false, *from_table});
      else
        problems.error("unknown-interface", tag.where,
                       "the tag '" + tag.name + "' reads '" + tag.interface + "', which nothing offers" +
                           states(tag.interface),
                       table.find_command(tag.interface) ? "it is a command: write {command: …}"
                                                         : states.with_ending_of(tag.interface));
    }
    if (tag.role == data::TagRole::command) {
      if (!table.find_command(tag.interface)) {
        problems.error("unknown-interface", tag.where,
                       "the tag '" + tag.name + "' drives '" + tag.interface + "', which nothing offers" +
                           commands(tag.interface),
                       table.find_state(tag.interface) || own.find(tag.interface)
                           ? "it is a state: write {state: …}"
                           : commands.with_ending_of(tag.interface));
        continue;
      }
      const auto at = std::find(command_names_.begin(), command_names_.end(), tag.interface);
      out_.push_back({tag, static_cast<std::size_t>(at - command_names_.begin())});
      if (at == command_names_.end()) command_names_.push_back(tag.interface);
    }
  }
  values_.assign(command_names_.size(), std::numeric_limits<double>::quiet_NaN());
}

void TagBinding::read(std::span<const double> states, const CellStates& own) {
  for (In& in : in_) {
    const double value = in.own ? own.value(in.index) : states[in.index];
    if (value == in.last || std::isnan(value)) continue;
    in.last = value;
    store_.set(in.tag.name, in.tag.from_interface(value), "state");
  }
}

void TagBinding::write(const signals::Situation& situation) {
  if (!io_ || (store_.version() == seen_version_ && situation == seen_situation_)) return;
  seen_version_ = store_.version();
  seen_situation_ = situation;
  bool changed = false;
  for (const Out& out : out_) {
    const data::Value* value = store_.find(out.tag.name);
    const auto number = value ? out.tag.to_interface(out.tag.output(*value, situation)) : std::nullopt;
    if (!number || values_[out.index] == *number) continue;
    values_[out.index] = *number;
    changed = true;
  }
  if (changed) io_->send(values_);
}

std::optional<double> TagBinding::sent(const std::string& tag) const {
  for (const Out& out : out_)
    if (out.tag.name == tag && !std::isnan(values_[out.index])) return values_[out.index];
  return std::nullopt;
}

}  // namespace polyarm::cell
