#pragma once
/// How two sides that rewrite one file lose nothing, though one of them knows nothing of locks.
///
/// The other side reads the whole file, thinks, and rewrites the whole file; in between the runtime may have
/// written. Its rewrite therefore is taken as: the version that it had read, and its changes to that. Only
/// these changes are applied to the present values. This is the pure part, without files or clocks.
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

/// How many names differ: other values, or only in one of the two.
std::size_t differences(const Values& a, const Values& b);
/// The names of `after` whose groups are not those that they have in `before`, and the groups.
std::vector<std::pair<std::string, std::string>> regrouped(const data::DataSet& before,
                                                           const data::DataSet& after);

class MailboxMerge {
 public:
  /// `start` is the content of the file; `kept` is how many versions are remembered.
  explicit MailboxMerge(Values start, std::size_t kept = 64);

  const Values& present() const { return present_; }
  /// The runtime sets a value. False where it was so already.
  bool set(const std::string& name, const data::Value& value);
  /// Whether the file's content is behind the present values.
  bool differs_from_file() const { return differences(present_, versions_.back().values) > 0; }
  /// The present values now stand in the file. Gives the number of the version.
  std::uint64_t wrote();

  struct Result {
    std::vector<std::pair<std::string, data::Value>>
        changes;              ///< that the other side made, applied to present()
    std::uint64_t base = 0;   ///< the version that it is taken to have read
    bool write_back = false;  ///< the file has to be written again
  };
  /// The other side rewrote the file to `content`. It is taken to have read the version with the fewest
  /// differing names, the latest of equals: among those in `read`, which are known to have been read, else
  /// among all that are remembered. A name that is missing in `content` is not taken as a change and is
  /// written back.
  Result outside(const Values& content, std::span<const std::uint64_t> read = {});

  /// The number of the version that stands in the file.
  std::uint64_t current() const { return versions_.back().number; }

 private:
  struct Version {
    std::uint64_t number;
    Values values;
  };
  const Version* nearest(const Values& content, std::span<const std::uint64_t> among) const;
  void remember(Values values);

  Values present_;
  std::deque<Version> versions_;  ///< what the file has held, oldest first
  std::size_t kept_;
  std::uint64_t next_ = 0;
};

}  // namespace polyarm::signals
