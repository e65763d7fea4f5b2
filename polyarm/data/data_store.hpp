#pragma once
/// The single name space of a running cell: variables and points from its data files, and tags.
///
/// Cell thread only; it never blocks and does no I/O. Values that must reach a file are collected; the owner
/// of the file binding takes them with take_writes().
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

/// The role of a tag.
enum class TagRole {
  plain,    ///< a value of the cell
  command,  ///< its value is sent to a command interface
  state,    ///< its value is read from a state interface; loading a file does not change it
};

/// A value that must be written to the file of its set.
struct PendingWrite {
  std::string set;
  std::string name;
  Value value;
};

/// One change of one name, for display.
struct Change {
  std::uint64_t version = 0;  ///< of the store after the change
  std::string name;
  std::optional<Value> old;  ///< empty: the name is new
  std::optional<Value> now;  ///< empty: the name was removed
  std::string who;
};

/// Properties of a name in addition to its value.
struct NameFacts {
  bool tag = false;
  bool forced = false;          ///< the value is forced; values set meanwhile take effect at release()
  Nanoseconds changed_at = -1;  ///< cell time of the last change, ns; -1: never changed
  std::string changed_by;
  std::vector<std::string> sets;
};

class DataStore {
 public:
  static constexpr std::size_t kChangesKept = 1024;
  /// The most values in all kept changes. Bounds the memory when long lists change often.
  static constexpr std::size_t kMostKept = 500'000;
  /// The largest number of names of a cell; the store refuses more.
  static constexpr std::size_t kMostNames = 50'000;

  /// Sets the time stamp of the next changes.
  void set_now(Nanoseconds now) { now_ = now; }
  /// Empty if the name does not exist.
  std::optional<NameFacts> facts(const std::string& name) const;
  /// Forces a value until release(); other writers do not change it. Throws Error("unknown-name" |
  /// "bad-value") if the name does not exist or the value is of another kind.
  void force(const std::string& name, Value value, const std::string& who);
  /// Ends forcing; the name gets the last value that was set meanwhile.
  void release(const std::string& name, const std::string& who);

  /// Declares a tag. An existing name from a data set keeps its value and becomes the tag.
  void declare_tag(const std::string& name, Value initial, TagRole role = TagRole::plain);
  bool is_tag(const std::string& name) const;
  std::optional<TagRole> tag_role(const std::string& name) const;

  /// Loads the data set `set` (the name of its file). Removes names that came only from the former content of
  /// this set and are not in the new one. State tags keep their value, which becomes a pending write to the
  /// file.
  void load(const std::string& set, const DataSet& content, const std::string& who);
  /// Takes over values that another program wrote to `set`'s file. They do not become pending writes to that
  /// file.
  void take_outside(const std::string& set, const std::vector<std::pair<std::string, Value>>& values,
                    const std::string& who);
  std::vector<std::string> sets() const;
  /// The first loaded set that contains `name`, or an empty text.
  std::string set_of(const std::string& name) const;
  /// The group of the name, from a data set or the user; empty if it has none. Only for lists: programs do
  /// not see it, and version() does not count it.
  std::string group_of(const std::string& name) const;
  void set_group(const std::string& name, const std::string& group);
  /// Increases with every change of any group.
  std::uint64_t groups_version() const { return groups_version_; }

  /// The value, or nullptr. The pointer is valid until the next change of the store.
  const Value* find(std::string_view name) const;
  std::vector<std::string> names() const;
  /// Changes `name` and records the write for every set that contains it. A new name joins the set that was
  /// loaded first. Returns false if the value is unchanged.
  /// Throws Error("too-many") for a new name beyond kMostNames.
  bool set(const std::string& name, Value value, const std::string& who);

  /// The writes since the last call, only the last one for each set and name.
  std::vector<PendingWrite> take_writes();

  /// Increases with every change of any value.
  std::uint64_t version() const { return version_; }
  /// The changes after `version` that are still kept.
  std::vector<Change> changes_since(std::uint64_t version) const;

 private:
  struct Slot {
    Value value;
    std::vector<std::size_t> sets;
    std::optional<TagRole> tag;
    std::optional<Value> behind;  ///< the value that release() restores; empty: not forced
    Nanoseconds changed_at = -1;
    std::string changed_by;
    std::string group;
  };
  struct NameHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };

  std::size_t set_index(const std::string& set);
  void forget_missing(std::size_t set, const DataSet& content, const std::string& who);
  void load_entry(std::size_t set, const Entry& entry, const std::string& who);
  bool change(const std::string& name, Slot& slot, Value value, const std::string& who, bool is_new);
  void note_writes(const std::string& name, const Slot& slot, std::optional<std::size_t> except = {});
  void record(const std::string& name, std::optional<Value> old, std::optional<Value> now,
              const std::string& who);

  std::unordered_map<std::string, Slot, NameHash, std::equal_to<>> slots_;
  std::vector<std::string> sets_;
  std::map<std::pair<std::size_t, std::string>, Value> writes_;
  std::deque<Change> changes_;
  std::size_t kept_ = 0;  ///< number of values in them
  std::uint64_t version_ = 0, groups_version_ = 0;
  Nanoseconds now_ = 0;
};

}  // namespace polyarm::data
