#pragma once
/// Writes the text of a large value in short pieces. One thread at a time.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The significant digits of numbers that a program shows to people.
inline constexpr int kShownDigits = 9;

/// Writes the text of a value piece by piece, so that no call takes long. The same as Value::text(), or with
/// numbers rounded to `digits` significant digits; whole numbers keep all of theirs.
class ValueWriter {
 public:
  explicit ValueWriter(Value of, int digits = 0) : value_{std::move(of)}, digits_{digits} {}
  /// Appends about `bytes` bytes to `out`; true when the text is complete.
  bool go_on(std::string& out, std::size_t bytes);

 private:
  struct Level {
    const Value* whole;
    std::size_t next;
  };
  void tell(const Value& value, std::string& out);
  void open(const Value& whole);

  Value value_;
  int digits_;  ///< 0: all
  std::vector<Level> open_;  ///< open lists and records
  bool begun_ = false;
};

}  // namespace polyarm::data
