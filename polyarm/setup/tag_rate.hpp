#pragma once
/// How many changes of one tag are printed: a chatty far side of a link must not fill a disk.
#include <cstddef>
#include <map>
#include <string>

#include "polyarm/base/time.hpp"

namespace polyarm::cell {

/// Any one thread.
class TagRate {
 public:
  static constexpr std::size_t kMostASecond = 100;  ///< of one tag

  struct Verdict {
    bool shown;            ///< this change is printed
    std::size_t left_out;  ///< changes before it that were not, and are reported now
  };
  /// A change at this cell time, ns.
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
    Nanoseconds begin = 0;  // of the second that is counted
    std::size_t seen = 0;
  };
  std::map<std::string, Count> counts_;
};

}  // namespace polyarm::cell
