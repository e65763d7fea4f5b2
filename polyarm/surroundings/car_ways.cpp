#include "polyarm/surroundings/car_ways.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "polyarm/surroundings/base_ground.hpp"

namespace polyarm::surroundings {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNear = 1e-6;     ///< of the radius: a word ends there
constexpr double kNothing = 1e-9;  ///< of the radius: pieces that are left out

/// A piece of a word: 1 left, -1 right, 0 straight; its signed length in radii.
struct Letter {
  int side = 0;
  double length = 0;
};
using Word = std::array<Letter, 5>;  // what is unused has the length 0

struct Polar {
  double radius, angle;
};
Polar polar(double x, double y) {
  return {std::hypot(x, y), std::atan2(y, x)};
}

/// The goal as seen from the start, in radii.
struct Goal {
  double x, y, turn;
};

/// The first and the last length of a way of four arcs whose middle ones have the lengths u and v.
std::array<double, 2> outer(double u, double v, double xi, double eta, double turn) {
  const double delta = wrapped(u - v);
  const double a = std::sin(u) - std::sin(delta), b = std::cos(u) - std::cos(delta) - 1;
  const double first = std::atan2(eta * a - xi * b, xi * a + eta * b);
  const double side = 2 * (std::cos(delta) - std::cos(v) - std::cos(u)) + 3;
  const double t = wrapped(side < 0 ? first + kPi : first);
  return {t, wrapped(t - u + v - turn)};
}

/// The words of one family; empty where it has none. All begin with a turn to the left.
using Family = std::optional<Word> (*)(const Goal& goal);

// 8.1: left, straight, left.
std::optional<Word> same_turns(const Goal& g) {
  const Polar p = polar(g.x - std::sin(g.turn), g.y - 1 + std::cos(g.turn));
  return Word{Letter{1, p.angle}, {0, p.radius}, {1, wrapped(g.turn - p.angle)}};
}

// 8.2: left, straight, right.
std::optional<Word> other_turn(const Goal& g) {
  const Polar p = polar(g.x + std::sin(g.turn), g.y - 1 - std::cos(g.turn));
  if (p.radius < 2) return std::nullopt;
  const double u = std::sqrt(p.radius * p.radius - 4), t = wrapped(p.angle + std::atan2(2, u));
  return Word{Letter{1, t}, {0, u}, {-1, wrapped(t - g.turn)}};
}

// 8.3, 8.4: left ahead, right backwards, left ahead or backwards.
std::optional<Word> first_cusp(const Goal& g) {
  const Polar p = polar(g.x - std::sin(g.turn), g.y - 1 + std::cos(g.turn));
  if (p.radius > 4) return std::nullopt;
  const double u = -2 * std::asin(p.radius / 4), t = wrapped(p.angle + u / 2 + kPi);
  return Word{Letter{1, t}, {-1, u}, {1, wrapped(g.turn - t + u)}};
}

// 8.4, driven from its end: left ahead, right ahead, left backwards.
std::optional<Word> last_cusp(const Goal& g) {
  const Polar p = polar(g.x - std::sin(g.turn), g.y - 1 + std::cos(g.turn));
  if (p.radius > 4 || p.radius < kNothing) return std::nullopt;
  const double u = std::acos(1 - p.radius * p.radius / 8);
  const double t = wrapped(p.angle + kPi / 2 - std::asin(std::clamp(2 * std::sin(u) / p.radius, -1.0, 1.0)));
  return Word{Letter{1, t}, {-1, u}, {1, wrapped(g.turn - t + u)}};
}

// 8.7: left ahead, right ahead, left backwards, right backwards.
std::optional<Word> cusp_between(const Goal& g) {
  const double xi = g.x + std::sin(g.turn), eta = g.y - 1 - std::cos(g.turn);
  const double rho = (2 + std::hypot(xi, eta)) / 4;
  if (rho > 1) return std::nullopt;
  const double u = std::acos(rho);
  const auto [t, v] = outer(u, -u, xi, eta, g.turn);
  return Word{Letter{1, t}, {-1, u}, {1, -u}, {-1, v}};
}

// 8.8: left ahead, right backwards, left backwards, right ahead.
std::optional<Word> cusps_outside(const Goal& g) {
  const double xi = g.x + std::sin(g.turn), eta = g.y - 1 - std::cos(g.turn);
  const double rho = (20 - xi * xi - eta * eta) / 16;
  if (rho < 0 || rho > 1) return std::nullopt;
  const double u = -std::acos(rho);
  const auto [t, v] = outer(u, u, xi, eta, g.turn);
  return Word{Letter{1, t}, {-1, u}, {1, u}, {-1, v}};
}

// 8.9: left ahead, a quarter right backwards, straight backwards, left backwards.
std::optional<Word> quarter_same(const Goal& g) {
  const Polar p = polar(g.x - std::sin(g.turn), g.y - 1 + std::cos(g.turn));
  if (p.radius < 2) return std::nullopt;
  const double r = std::sqrt(p.radius * p.radius - 4), t = wrapped(p.angle + std::atan2(r, -2.0));
  return Word{Letter{1, t}, {-1, -kPi / 2}, {0, 2 - r}, {1, wrapped(g.turn - kPi / 2 - t)}};
}

// 8.10: the same with a right turn at the end.
std::optional<Word> quarter_other(const Goal& g) {
  const Polar p = polar(-(g.y - 1 - std::cos(g.turn)), g.x + std::sin(g.turn));
  if (p.radius < 2) return std::nullopt;
  return Word{
      Letter{1, p.angle}, {-1, -kPi / 2}, {0, 2 - p.radius}, {-1, wrapped(p.angle + kPi / 2 - g.turn)}};
}

// 8.11: left, a quarter right backwards, straight, a quarter left, right ahead.
std::optional<Word> two_quarters(const Goal& g) {
  const double xi = g.x + std::sin(g.turn), eta = g.y - 1 - std::cos(g.turn);
  const double rho = std::hypot(xi, eta);
  if (rho < 2) return std::nullopt;
  const double u = 4 - std::sqrt(rho * rho - 4);
  if (u > 0) return std::nullopt;
  const double t = wrapped(std::atan2((4 - u) * xi - 2 * eta, -2 * xi + (u - 4) * eta));
  return Word{Letter{1, t}, {-1, -kPi / 2}, {0, u}, {1, -kPi / 2}, {-1, wrapped(t - g.turn)}};
}

constexpr std::array<Family, 9> kFamilies{same_turns,   other_turn,    first_cusp,
                                          last_cusp,    cusp_between,  cusps_outside,
                                          quarter_same, quarter_other, two_quarters};

Goal seen(const BasePlace& from, const BasePlace& to, double radius) {
  const double dx = (to.x - from.x) / radius, dy = (to.y - from.y) / radius;
  const double c = std::cos(from.heading), s = std::sin(from.heading);
  return {c * dx + s * dy, c * dy - s * dx, wrapped(to.heading - from.heading)};
}

bool ends_at(const Word& word, const Goal& goal) {
  BasePlace at;
  for (const Letter& letter : word)
    if (letter.length != 0) at = along(at, letter.side, letter.length);
  return std::abs(at.x - goal.x) < kNear && std::abs(at.y - goal.y) < kNear &&
         std::abs(wrapped(at.heading - goal.turn)) < kNear;
}

double length_of(const Word& word) {
  double out = 0;
  for (const Letter& letter : word) out += std::abs(letter.length);
  return out;
}

/// Calls take(word) for each word that is shorter than longest() radii and ends at the goal. The symmetries:
/// backwards in time, mirrored at the x axis, and driven from the goal to the start.
template <typename Longest, typename Take>
void each_word(const Goal& goal, const Longest& longest, const Take& take) {
  for (const Family family : kFamilies)
    for (int kind = 0; kind < 8; ++kind) {
      const bool back = kind & 1, mirrored = kind & 2, reversed = kind & 4;
      Goal g = goal;
      if (reversed)
        g = {g.x * std::cos(g.turn) + g.y * std::sin(g.turn), g.x * std::sin(g.turn) - g.y * std::cos(g.turn),
             g.turn};
      if (back) g = {-g.x, g.y, -g.turn};
      if (mirrored) g = {g.x, -g.y, -g.turn};
      std::optional<Word> word = family(g);
      if (!word || length_of(*word) >= longest()) continue;
      for (Letter& letter : *word) {
        if (back) letter.length = -letter.length;
        if (mirrored) letter.side = -letter.side;
      }
      if (reversed) std::reverse(word->begin(), word->end());
      if (ends_at(*word, goal)) take(*word);
    }
}

}  // namespace

double CarWay::length() const {
  double out = 0;
  for (std::size_t k = 0; k < count; ++k) out += std::abs(pieces[k].length);
  return out;
}

std::vector<CarWay> car_ways(const BasePlace& from, const BasePlace& to, double radius) {
  std::vector<CarWay> out;
  const auto any = [] { return std::numeric_limits<double>::infinity(); };
  each_word(seen(from, to, radius), any, [&](const Word& word) {
    CarWay way;
    for (const Letter& letter : word)
      if (std::abs(letter.length) > kNothing)
        way.pieces[way.count++] = {letter.side / radius, letter.length * radius};
    out.push_back(way);
  });
  return out;
}

double shortest_car_way(const BasePlace& from, const BasePlace& to, double radius) {
  double out = std::numeric_limits<double>::infinity();
  each_word(
      seen(from, to, radius), [&] { return out; }, [&](const Word& word) { out = length_of(word); });
  return out * radius;
}

}  // namespace polyarm::surroundings
