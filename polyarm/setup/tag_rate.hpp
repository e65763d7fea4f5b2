#pragma once
/// Limits how many changes of one tag are printed, so a fast remote device does not fill a disk.
#include <cstddef>
#include <map>
#include <string>

#include "polyarm/base/time.hpp"

namespace polyarm::cell {

/// Use from one thread at a time.
class TagRate {
 public:
  static constexpr std::size_t kMostASecond = 100;  ///< per tag

  struct Verdict {
    bool shown;            ///< print this change
    std::size_t left_out;  ///< number of earlier changes that were not printed, to be reported now
  };
  /// Call for a change at this cell time, ns.
  Verdict look(Nanoseconds time, const std::string& tag) {
    Count& count = counts_[tag];
    Verdict out{true, 0};
    if (time < count.begin || time - count.begin >= kSecond) {
      out.left_out = count.seen > kMostASecond ? count.seen - kMostASecond : 0;
      count = {time, 0};
    }
    out.shown = ++count.seen <= kMostASecond;
    return out;
  }

 private:
  static constexpr Nanoseconds kSecond = 1'000'000'000;
  struct Count {
    Nanoseconds begin = 0;  // start of the current second
    std::size_t seen = 0;
  };
  std::map<std::string, Count> counts_;
};

}  // namespace polyarm::cell
