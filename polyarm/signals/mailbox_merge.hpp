#pragma once
/// Merges the changes of two sides that rewrite one file, although one of them does not use locks.
///
/// The other side reads the whole file and later rewrites the whole file; the runtime may have written in
/// between. A rewrite therefore counts as a set of changes to the version that the other side had read. Only
/// these changes are applied to the present values. This is the pure part, without files or clocks; one
/// thread.
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

/// The number of names that differ: with other values, or in only one of the two.
std::size_t differences(const Values& a, const Values& b);
/// The names of `after` whose groups differ from those in `before`, with the new groups.
std::vector<std::pair<std::string, std::string>> regrouped(const data::DataSet& before,
                                                           const data::DataSet& after);

class MailboxMerge {
 public:
  /// `start` is the content of the file; `kept` is the number of versions to remember.
  explicit MailboxMerge(Values start, std::size_t kept = 64);

  const Values& present() const { return present_; }
  /// Sets a value of the runtime. False if it is unchanged.
  bool set(const std::string& name, const data::Value& value);
  /// True if the file does not yet contain the present values.
  bool differs_from_file() const { return differences(present_, versions_.back().values) > 0; }
  /// Call it after the present values were written to the file. Returns the number of the version.
  std::uint64_t wrote();

  struct Result {
    std::vector<std::pair<std::string, data::Value>>
        changes;              ///< changes by the other side, applied to present()
    std::uint64_t base = 0;   ///< the version that it presumably read
    bool write_back = false;  ///< the file must be written again
  };
  /// Merges a rewrite by the other side with `content`. Its base is the version with the fewest differing
  /// names, the latest of equal ones: among those in `read`, which are known to have been read, else among
  /// all remembered ones. A name that is missing in `content` does not count as a change and is written back.
  Result outside(const Values& content, std::span<const std::uint64_t> read = {});

  /// The number of the file's present version.
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
