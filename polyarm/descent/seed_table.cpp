#include "polyarm/descent/seed_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <vector>

#include "polyarm/kinematics/random.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPlaceWeight = 1.5;  // of lengths relative to directions
constexpr std::size_t kRounds = 12;   // of sixteen states each from the table; then random states
constexpr double kWidth = 2 * kPi;    // range of joints without limits, rad; for sliding ones in lengths

double find_golden(std::size_t dimensions) {
  double root = 2;
  for (int i = 0; i < 40; ++i) {
    const double next = std::pow(1 + root, 1.0 / static_cast<double>(dimensions + 1));
    if (next == root) break;
    root = next;
  }
  return root;
}

double generalized_golden(std::size_t dimensions) {
  // Cached for few dimensions: computing it takes a tenth of the table's time.
  static const std::array<double, 9> kFew = [] {
    std::array<double, 9> out{};
    for (std::size_t d = 1; d < out.size(); ++d) out[d] = find_golden(d);
    return out;
  }();
  return dimensions < kFew.size() ? kFew[dimensions] : find_golden(dimensions);
}

/// The point of axis `last` nearest to the previous axis, if they are not parallel.
Vec3 wrist_point(const Vec3& a, const Vec3& p, const Vec3& b, const Vec3& q) {
  const Vec3 n = cross(a, b), way = q - p;
  const double scale = dot(n, n);
  if (scale < 1e-6) return q;
  return q + (dot(way, cross(a, n)) / scale) * b;
}

/// The angle of the point (x, y), to 2e-5 rad, which is enough for a start and takes a fifth of the time of
/// std::atan2. Computes atan on [0, 1] by the odd polynomial of degree 9 of Abramowitz and Stegun, 4.4.47.
double rough_angle(double y, double x) noexcept {
  const double ax = std::abs(x), ay = std::abs(y);
  const double large = std::max(ax, ay), small = std::min(ax, ay);
  const double m = large > 0 ? small / large : 0.0, z = m * m;
  double angle = m * (0.9998660 + z * (-0.3302995 + z * (0.1801410 + z * (-0.0851330 + z * 0.0208351))));
  angle = ay > ax ? kPi / 2 - angle : angle;
  angle = x < 0 ? kPi - angle : angle;
  return std::copysign(angle, y);
}

/// Input: an angle between -2 pi and 2 pi.
double within_a_turn(double angle) {
  return angle - (angle > kPi ? 2 * kPi : angle < -kPi ? -2 * kPi : 0.0);
}

double angle_about(const Vec3& axis, const Vec3& from, const Vec3& to) {
  return rough_angle(dot(axis, cross(from, to)), dot(from, to));
}

}  // namespace

SeedTable::SeedTable(const DescentArm& arm, std::size_t size) : arm_(arm) {
  find_symmetry();
  fill((size + kNearGroups - 1) / kNearGroups * kNearGroups);
}

void SeedTable::find_symmetry() {
  point_in_end_ = {};
  if (arm_.axes.empty()) return;
  const auto alone = [&](const DescentArm::Axis& axis) {
    const auto uses = std::count_if(arm_.axes.begin(), arm_.axes.end(),
                                    [&](const DescentArm::Axis& other) { return other.joint == axis.joint; });
    return !axis.slides && std::abs(axis.ratio) == 1 && uses == 1;
  };
  const DescentArm::Axis &first = arm_.axes.front(), &last = arm_.axes.back();
  first_turns_ = alone(first);
  last_turns_ = arm_.axes.size() > 1 && alone(last);
  first_joint_ = first.joint, last_joint_ = last.joint;
  first_ratio_ = first.ratio, last_ratio_ = last.ratio;
  if (!last_turns_) return;
  // Behind the last axis it is z, through -step from the TCP. As the last axis may have any angle, only the
  // position of the previous axis along the last one counts.
  point_in_end_ = -last.step;
  const DescentArm::Axis& before = arm_.axes[arm_.axes.size() - 2];
  // In the frame behind the previous axis, the last axis is turned by its bend about x and begins at
  // before.step.
  const Vec3 direction{0, -last.bend_sin, last.bend_cos};
  const Vec3 point = wrist_point({0, 0, 1}, {}, direction, before.step);
  point_in_end_ = point_in_end_ + Vec3{0, 0, dot(point - before.step, direction)};
}

SeedTable::Range SeedTable::range(std::size_t k) const noexcept {
  double low = arm_.lower[k], high = arm_.upper[k];
  if (low < -1e8 && high > 1e8) {
    low = -kWidth / 2, high = kWidth / 2;
  } else if (low < -1e8) {
    low = high - kWidth;
  } else if (high > 1e8) {
    high = low + kWidth;
  }
  return {low, high - low};
}

namespace {

/// Points that fill a cube of this many dimensions evenly, in blocks of kDescents: one dimension of all
/// points, then the next. Each is an additive sequence (the R-sequence: powers of the root of x^(d+1) = x +
/// 1; Roberts 2018).
void write_points(std::size_t dimensions, std::size_t count, double* to) {
  std::array<double, Chain::kMostMoving> step{}, unit;
  unit.fill(0.5);
  const double root = generalized_golden(std::max<std::size_t>(1, dimensions));
  double power = 1;
  for (std::size_t k = 0; k < dimensions; ++k) step[k] = power /= root;
  for (std::size_t row = 0; row < count; row += kDescents, to += dimensions * kDescents)
    // Joints in parallel, because each joint's next number waits for its previous one.
    for (std::size_t lane = 0; lane < kDescents; ++lane)
      for (std::size_t k = 0; k < dimensions; ++k) {
        double at = unit[k] + step[k];
        at -= at >= 1 ? 1.0 : 0.0;
        to[k * kDescents + lane] = unit[k] = at;
      }
}

constexpr std::size_t kKept = 512;  // points; as many as the default of NumericSettings

template <std::size_t kDimensions>
const double* kept_points() {
  static const std::array<double, kKept* kDimensions> kPoints = [] {
    std::array<double, kKept * kDimensions> out;
    write_points(kDimensions, kKept, out.data());
    return out;
  }();
  return kPoints.data();
}

/// The same points for two to six dimensions, independent of the arm, computed once. Null for other
/// dimensions.
const double* kept_points(std::size_t dimensions) {
  switch (dimensions) {
    case 2:
      return kept_points<2>();
    case 3:
      return kept_points<3>();
    case 4:
      return kept_points<4>();
    case 5:
      return kept_points<5>();
    case 6:
      return kept_points<6>();
    default:
      return nullptr;
  }
}

}  // namespace

void SeedTable::fill(std::size_t size) {
  const std::size_t m = arm_.joints;
  table_.count = size;
  table_.used = (first_turns_ ? 2 : 3) + 3 + (last_turns_ ? 0 : 3);
  // Every number is written before it is read.
  table_.rows = std::make_unique_for_overwrite<float[]>(size * table_.used);
  numbers_ = std::make_unique_for_overwrite<double[]>(size * (m + 4));
  double *const states = numbers_.get(), *const turn = states + size * m, *const beside = turn + size;
  states_ = states, turn_ = turn, beside_ = beside;
  std::array<bool, Chain::kMostMoving> still{};
  std::array<Range, Chain::kMostMoving> wide{};
  std::size_t dimensions = 0;
  for (std::size_t k = 0; k < m; ++k) {
    still[k] = (first_turns_ && k == first_joint_) || (last_turns_ && k == last_joint_);
    if (!still[k]) wide[k] = range(k), ++dimensions;
  }
  const double* points = size <= kKept ? kept_points(dimensions) : nullptr;
  std::vector<double> drawn;
  if (!points) {
    drawn.resize(size * dimensions);
    write_points(dimensions, size, drawn.data());
    points = drawn.data();
  }
  double* to = states;
  for (std::size_t row = 0; row < size; row += kDescents)
    for (std::size_t k = 0; k < m; ++k, to += kDescents) {
      if (still[k]) {
        std::fill_n(to, kDescents, 0.0);
        continue;
      }
      for (std::size_t lane = 0; lane < kDescents; ++lane)
        to[lane] = wide[k].low + points[lane] * wide[k].width;
      points += kDescents;
    }
  see_ends(arm_, {{point_in_end_, first_turns_, last_turns_, transposed(arm_.first_turn), arm_.first_point},
                  size,
                  states,
                  still.data(),
                  kPlaceWeight,
                  table_.rows.get(),
                  turn,
                  beside});
}

SeedTable::Place SeedTable::place(const Rotation& rotation, const Vec3& position) const noexcept {
  Place out;
  out.point = position + rotation * point_in_end_;
  out.toward = rotation.z;
  out.beside = rotation.x;
  if (!first_turns_) return out;
  const Rotation base = transposed(arm_.first_turn);
  const Vec3 at = base * (out.point - arm_.first_point);
  const double radius = std::sqrt(at.x * at.x + at.y * at.y);
  const double c = radius > 1e-9 ? at.x / radius : 1, s = radius > 1e-9 ? at.y / radius : 0;
  out.turn = rough_angle(s, c);
  const auto unturned = [&](const Vec3& v) {
    const Vec3 u = base * v;
    return Vec3{c * u.x + s * u.y, c * u.y - s * u.x, u.z};
  };
  out.point = {radius, at.z, 0};
  out.toward = unturned(out.toward);
  out.beside = unturned(out.beside);
  return out;
}

std::array<float, FeatureTable::kFeatures> SeedTable::features(const Place& p) const noexcept {
  std::array<float, FeatureTable::kFeatures> out{};
  std::size_t at = 0;
  const auto add = [&](double v) { out[at++] = static_cast<float>(v); };
  add(kPlaceWeight * p.point.x), add(kPlaceWeight * p.point.y);
  if (!first_turns_) add(kPlaceWeight * p.point.z);
  add(p.toward.x), add(p.toward.y), add(p.toward.z);
  if (!last_turns_) add(p.beside.x), add(p.beside.y), add(p.beside.z);
  return out;
}

void SeedTable::begin(const Rotation& rotation, const Vec3& position, Search& search) const noexcept {
  const Place at = place(rotation, position);
  search.at = features(at);
  search.toward = at.toward;
  search.beside = at.beside;
  search.turn = at.turn;
  search.beyond.fill(-1.0f);
  search.next = kNearGroups;
  search.rounds = 0;
  search.drawn = 0;
}

void SeedTable::advance(Search& search) const noexcept {
  find_near(table_, search.at.data(), search.beyond.data(), search.near);
  ++search.rounds;
  search.next = 0;
  // The nearer of each pair first; sorting all of them costs more than it gains.
  constexpr std::size_t kHalf = kNearGroups / 2;
  for (std::size_t i = 0; i < kHalf; ++i) {
    const bool swapped = search.near.distance2[i + kHalf] < search.near.distance2[i];
    search.order[i] = static_cast<std::uint8_t>(swapped ? i + kHalf : i);
    search.order[i + kHalf] = static_cast<std::uint8_t>(swapped ? i : i + kHalf);
  }
  std::copy(std::begin(search.near.distance2), std::end(search.near.distance2), search.beyond.begin());
}

void SeedTable::next(Search& search, double* x) const noexcept {
  const std::size_t m = arm_.joints;
  if (search.next == kNearGroups && search.rounds < kRounds) advance(search);
  if (search.next < kNearGroups) {
    const std::size_t group = search.order[search.next++];
    read(search, static_cast<std::size_t>(search.near.index[group]), x);
  } else {
    Random random(7);
    random.skip(m * search.drawn++);
    for (std::size_t k = 0; k < m; ++k) {
      const Range wide = range(k);
      x[k] = wide.low + random.unit() * wide.width;
    }
    move_inside(x);
  }
}

void SeedTable::read(const Search& search, std::size_t row, double* x) const noexcept {
  const std::size_t block = row / kDescents, lane = row % kDescents;
  for (std::size_t k = 0; k < arm_.joints; ++k) x[k] = value(row, k);
  if (last_turns_) {
    const double* const at = beside_ + 3 * kDescents * block + lane;
    const Vec3 beside{at[0], at[kDescents], at[2 * kDescents]};
    x[last_joint_] = last_ratio_ * angle_about(search.toward, beside, search.beside);
  }
  if (first_turns_) x[first_joint_] = first_ratio_ * within_a_turn(search.turn - turn_[row]);
  move_inside(x);
}

void SeedTable::move_inside(double* x) const noexcept {
  for (const std::size_t k : {first_joint_, last_joint_}) {
    // The next turn may be inside the limits if this one is not.
    if (x[k] > arm_.upper[k] && x[k] - 2 * kPi >= arm_.lower[k]) x[k] -= 2 * kPi;
    if (x[k] < arm_.lower[k] && x[k] + 2 * kPi <= arm_.upper[k]) x[k] += 2 * kPi;
  }
  for (std::size_t k = 0; k < arm_.joints; ++k) x[k] = std::clamp(x[k], arm_.lower[k], arm_.upper[k]);
}

}  // namespace polyarm::kinematics
