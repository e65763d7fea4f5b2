// The part of the search along axis 4 that all instruction sets share (search_kernels.inc).
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/branch_kernels.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kOffset = 0.0123;  // rad: avoids samples at a right angle

SearchSamples all_round() {
  SearchSamples out;
  out.cell = kTurn / kSearchSamples;
  for (std::size_t i = 0; i < kSearchSamples; ++i) {
    const double at = -std::numbers::pi + kOffset + static_cast<double>(i) * out.cell;
    out.s[i] = std::sin(at);
    out.c[i] = std::cos(at);
  }
  return out;
}

}  // namespace

const SearchSamples kSearchAllRound = all_round();

void search_closer(const SearchSamples& of, const bool* marked, SearchSamples& out) noexcept {
  std::size_t cells[kSearchSamples], count = 0;
  for (std::size_t i = 0; i < kSearchSamples; ++i)
    if (marked[i]) cells[count++] = i;
  const double part = static_cast<double>(count) / kSearchSamples;
  out.cell = of.cell * part;
  for (std::size_t i = 0; i < kSearchSamples; ++i) {
    const double at = (static_cast<double>(i) + 0.5) * part;
    const auto cell = static_cast<std::size_t>(at);
    const double x = (at - static_cast<double>(cell) - 0.5) * of.cell, x2 = x * x;
    const double s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42))),
                 c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56)));
    const double s0 = of.s[cells[cell]], c0 = of.c[cells[cell]];
    out.s[i] = s0 * c + c0 * s;
    out.c[i] = c0 * c - s0 * s;
  }
}

}  // namespace polyarm::kinematics
