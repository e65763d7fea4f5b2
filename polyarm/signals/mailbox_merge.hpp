#pragma once
/// Merges the changes of two sides that rewrite one file, although one of them does not use locks.
///
/// The other side reads the whole file and later rewrites it; the runtime may have written in between. A
/// rewrite is therefore treated as a set of changes to the version that the other side had read, and only
/// these changes are applied to the present values. This part is pure: no files, no clocks. One thread.
#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::signals {

using Values = std::map<std::string, data::Value>;

/// Count of names that differ: with different values, or present in only one of the two.
std::size_t differences(const Values& a, const Values& b);
/// The names in `after` whose group differs from that in `before`, with the new group.
std::vector<std::pair<std::string, std::string>> regrouped(const data::DataSet& before,
                                                           const data::DataSet& after);

class MailboxMerge {
 public:
  /// `start`: content of the file. `kept`: count of versions to remember.
  explicit MailboxMerge(Values start, std::size_t kept = 64);

  const Values& present() const { return present_; }
  /// Sets a value of the runtime. Returns false if it is unchanged.
  bool set(const std::string& name, const data::Value& value);
  /// True if the file does not contain the present values yet.
  bool differs_from_file() const { return differences(present_, versions_.back().values) > 0; }
  /// Call it after the present values were written to the file. Returns the version's number.
  std::uint64_t wrote();

  struct Result {
    std::vector<std::pair<std::string, data::Value>>
        changes;              ///< changes of the other side, applied to present()
    std::uint64_t base = 0;   ///< the version that it has presumably read
    bool write_back = false;  ///< the file must be written again
  };
  /// Merges a rewrite by the other side with `content`. Its base is the version with the fewest differing
  /// names (of equal ones, the latest), among those in `read`, which are known to have been read, or else
  /// among all remembered ones. A name that is missing in `content` is not a change; it is written back.
  Result outside(const Values& content, std::span<const std::uint64_t> read = {});

  /// Number of the file's present version.
  std::uint64_t current() const { return versions_.back().number; }

 private:
  struct Version {
    std::uint64_t number;
    Values values;
  };
  const Version* nearest(const Values& content, std::span<const std::uint64_t> among) const;
  void remember(Values values);

  Values present_;
  std::deque<Version> versions_;  ///< former contents of the file, oldest first
  std::size_t kept_;
  std::uint64_t next_ = 0;
};

}  // namespace polyarm::signals
