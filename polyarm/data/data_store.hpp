#pragma once
/// The one name space of a running cell: variables and points from its data files, and tags.
///
/// Owned by the cell thread; it never blocks and does no I/O. What has to reach a file is collected and taken
/// by whoever binds the sets to their files.
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

/// What a tag is to the runtime.
enum class TagRole {
  plain,    ///< a value of the cell
  command,  ///< its value goes out to a command interface
  state,    ///< its value comes in from a state interface; a file that is loaded does not change it
};

/// A value of a set that has to be written to the set's file.
struct PendingWrite {
  std::string set;
  std::string name;
  Value value;
};

/// One change of one name, for display.
struct Change {
  std::uint64_t version = 0;  ///< of the store after the change
  std::string name;
  std::optional<Value> old;  ///< nothing: the name is new
  std::optional<Value> now;  ///< nothing: the name is gone
  std::string who;
};

/// What is known of a name beside its value.
struct NameFacts {
  bool tag = false;
  bool forced = false;          ///< a person has forced the value; what others set waits behind it
  Nanoseconds changed_at = -1;  ///< cell time of the last change; -1: it has had no other value
  std::string changed_by;
  std::vector<std::string> sets;
};

class DataStore {
 public:
  static constexpr std::size_t kChangesKept = 1024;
  /// And so many values in all of them, so that changes of long lists keep no more than that.
  static constexpr std::size_t kMostKept = 500'000;
  /// Names that a cell may have; more are refused.
  static constexpr std::size_t kMostNames = 50'000;

  /// The time that changes from now on are noted with.
  void set_now(Nanoseconds now) { now_ = now; }
  /// Nothing where there is no such name.
  std::optional<NameFacts> facts(const std::string& name) const;
  /// Until release() the name has this value, whatever is set meanwhile. Throws Error("unknown-name" |
  /// "bad-value") for a name that there is not, or another kind of value.
  void force(const std::string& name, Value value, const std::string& who);
  /// The name gets the value that was set last behind the forced one.
  void release(const std::string& name, const std::string& who);

  /// Declares a tag. A name that a data set brought keeps its value and becomes the tag.
  void declare_tag(const std::string& name, Value initial, TagRole role = TagRole::plain);
  bool is_tag(const std::string& name) const;
  std::optional<TagRole> tag_role(const std::string& name) const;

  /// Loads the data set called `set` (the name of its file): names that came only from its former content and
  /// are not in it any more go; all others stay. State tags keep their value, which is then pending for the
  /// file.
  void load(const std::string& set, const DataSet& content, const std::string& who);
  /// Takes values that `set`'s file got from outside. They are not pending for that file.
  void take_outside(const std::string& set, const std::vector<std::pair<std::string, Value>>& values,
                    const std::string& who);
  std::vector<std::string> sets() const;
  /// The first loaded set that holds `name`, or an empty text.
  std::string set_of(const std::string& name) const;
  /// The group that a data set or a person has put the name into, empty where none has. It is for lists
  /// alone: programs do not see it, and version() stays as it is.
  std::string group_of(const std::string& name) const;
  void set_group(const std::string& name, const std::string& group);
  /// Grows with every change of any group.
  std::uint64_t groups_version() const { return groups_version_; }

  /// The value, or nullptr. The pointer holds until the next change of the store.
  const Value* find(std::string_view name) const;
  std::vector<std::string> names() const;
  /// Changes `name` and notes the write for every set that holds it. A new name joins the set that was loaded
  /// first. False where the value was the same already.
  /// Throws Error("too-many") for a new name beyond kMostNames.
  bool set(const std::string& name, Value value, const std::string& who);

  /// The writes since the last call, the last one for each set and name.
  std::vector<PendingWrite> take_writes();

  /// Grows with every change of any value.
  std::uint64_t version() const { return version_; }
  /// The changes after `version`, as far as they are kept.
  std::vector<Change> changes_since(std::uint64_t version) const;

 private:
  struct Slot {
    Value value;
    std::vector<std::size_t> sets;
    std::optional<TagRole> tag;
    std::optional<Value> behind;  ///< what would be the value if it were not forced
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
  std::size_t kept_ = 0;  ///< values in them
  std::uint64_t version_ = 0, groups_version_ = 0;
  Nanoseconds now_ = 0;
};

}  // namespace polyarm::data
