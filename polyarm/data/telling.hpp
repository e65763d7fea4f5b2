#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// Writes a value as Value::text() does, a piece at a time.
class Telling {
 public:
  explicit Telling(Value of) : value_{std::move(of)} {}
  /// Adds to `out`, until about so many bytes have been added; true when all of it is told.
  bool go_on(std::string& out, std::size_t bytes);

 private:
  struct Level {
    const Value* whole;
    std::size_t next;
  };
  void tell(const Value& value, std::string& out);
  void open(const Value& whole);

  Value value_;
  std::vector<Level> open_;  ///< lists and records that it is in
  bool begun_ = false;
};

}  // namespace polyarm::data
