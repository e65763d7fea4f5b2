#pragma once
/// The limit tables of a FANUC controller. Degrees and seconds. One thread; at() allocates nothing.
#include <array>
#include <cstdint>

#include "drivers/fanuc/stream.hpp"
#include "drivers/wire/shaper.hpp"

namespace polyarm::fanuc {

using wire::AxisLimits;
using wire::Shaper;
using wire::Six;

/// The tables of six axes, as the controller reports them.
class LimitTables {
 public:
  void set(const LimitTable& table) noexcept;
  bool complete() const noexcept { return missing_ == 0; }
  /// Between the tables for no load and for full load, and between their steps. Of the steps between 1/1.2
  /// and 1.2 of `speed` the smallest value counts, because the controller's own speed is not exactly known.
  /// `speed`: mm/s, Cartesian; `load`: share of the full load, from 0 to 1.
  AxisLimits at(double speed, double load) const noexcept;

 private:
  std::array<std::array<LimitTable, 3>, 6> tables_;
  std::uint32_t missing_ = (1u << 18) - 1;
};

}  // namespace polyarm::fanuc
