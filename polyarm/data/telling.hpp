#pragma once
/// Writes the text of a large value in short pieces. One thread at a time.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// Writes the text of a value, the same as Value::text(), piece by piece, so that no call takes long.
class Telling {
 public:
  explicit Telling(Value of) : value_{std::move(of)} {}
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
  std::vector<Level> open_;  ///< open lists and records
  bool begun_ = false;
};

}  // namespace polyarm::data
