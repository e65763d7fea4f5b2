#pragma once
/// Barriers of a jogged robot: how near its bodies are to others, as planes in joint space. The cell thread
/// renews them in each tick; the control cycle keeps the joints on the free side. Metres, radians. For the
/// control cycle: no allocation, no exceptions.
#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/twist_solver.hpp"

namespace polyarm::jog {

/// One point of a body before a plane that keeps it off another body.
struct Barrier {
  double room = 0;          ///< m left at Barriers::at; negative: nearer than it may be
  double bend = 0;          ///< m per rad²: the room falls below its tangent by at most half of this
  std::bitset<kMostJogJoints> moving =
      std::bitset<kMostJogJoints>().set();  ///< joints that change the room; the others do not count
  std::int32_t which = -1;  ///< the pair of bodies, for whoever made the barriers
  bool slides = false;      ///< a TCP that closes in on it slides along it; else it stops on its line
  JogValues gradient{};     ///< of the room, by joint
};

struct Barriers {
  static constexpr std::size_t kMost = 32;

  bool touching = false;  ///< something is nearer than it may be: move slowly
  std::size_t count = 0;
  JogValues at{};  ///< joint state for which they were made
  std::array<Barrier, kMost> all;
  /// Everything that has no barrier is at least this far from touching, m; `lever`: how far any body goes per
  /// rad or m of each joint, at most.
  double rest = std::numeric_limits<double>::infinity();
  std::int32_t rest_which = -1;
  JogValues lever{};

  /// The room of barrier `i` with the joints at `q`; `i` = count: of all that has no barrier.
  double room(std::size_t i, std::span<const double> q) const noexcept {
    double way = 0, change = 0;
    if (i == count) {
      if (!std::isfinite(rest)) return rest;
      for (std::size_t j = 0; j < q.size(); ++j) way += lever[j] * std::abs(q[j] - at[j]);
      return rest - way;
    }
    const Barrier& barrier = all[i];
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double by = q[j] - at[j];
      change += barrier.gradient[j] * by;
      way += barrier.moving[j] ? std::abs(by) : 0.0;
    }
    return barrier.room + change - barrier.bend / 2 * way * way;
  }
  /// How fast the room of barrier `i` shrinks at these joint velocities, m/s.
  double closing(std::size_t i, std::span<const double> rates) const noexcept {
    double out = 0;
    for (std::size_t j = 0; j < rates.size(); ++j) out -= all[i].gradient[j] * rates[j];
    return out;
  }
  std::int32_t which(std::size_t i) const noexcept { return i == count ? rest_which : all[i].which; }
};

}  // namespace polyarm::jog
