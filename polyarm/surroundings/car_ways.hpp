#pragma once
/// Shortest ways of a car in the plane, without obstacles: arcs of its smallest radius and straight lines,
/// ahead and backwards. Source: Reeds and Shepp, Optimal paths for a car that goes both forwards and
/// backwards (1990), sections 8.1 to 8.11. Metres, radians. Any thread.
#include <array>
#include <cstddef>
#include <vector>

#include "polyarm/surroundings/base_ways.hpp"

namespace polyarm::surroundings {

struct CarPiece {
  double curvature = 0;  ///< 1/m, positive to the left
  double length = 0;     ///< m, negative backwards
};

/// At most five pieces.
struct CarWay {
  std::array<CarPiece, 5> pieces{};
  std::size_t count = 0;
  double length() const;
};

/// All ways of the known kinds that end at `to`, within 1e-6 of the radius. The shortest way is among them;
/// there is always one.
std::vector<CarWay> car_ways(const BasePlace& from, const BasePlace& to, double radius);

/// The length of the shortest one.
double shortest_car_way(const BasePlace& from, const BasePlace& to, double radius);

}  // namespace polyarm::surroundings
