#include "polyarm/closed_form/general_six.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/general_six_algebra.hpp"

namespace polyarm::kinematics {

namespace {

using Rows6x9 = Grid<6, 9>;

constexpr double kThird = 2 * std::numbers::pi / 3;
/// Rotates the infinity of the half-angle tangents of angles 4 and 5 away from common poses.
constexpr double kOffset4 = 0.7345, kOffset5 = -1.1931;
constexpr double kNearlyReal = 0.1;  // rad off the real axis: the polish decides whether it is a solution

/// From values at 0, 120 and 240 degrees to coefficients of (1, sin, cos).
constexpr double kRoot3 = 1.7320508075688772;
constexpr double kToTrig[3][3] = {
    {1.0 / 3, 1.0 / 3, 1.0 / 3}, {0, kRoot3 / 3, -kRoot3 / 3}, {2.0 / 3, -1.0 / 3, -1.0 / 3}};
/// From the same values to powers 0, 1, 2 of the half-angle tangent, all times 1 + tan^2.
constexpr double kToHalf[3][3] = {
    {1, 0, 0}, {0, 2 * kRoot3 / 3, -2 * kRoot3 / 3}, {-1.0 / 3, 2.0 / 3, 2.0 / 3}};

std::array<double, 14> features_of(const Vec3& p, const Vec3& l) noexcept {
  const double pp = dot(p, p), pl = dot(p, l);
  const Vec3 across = cross(p, l), mirrored = pp * l - (2 * pl) * p;
  return {p.x, p.y,      p.z,      l.x,      l.y,        l.z,        pp,
          pl,  across.x, across.y, across.z, mirrored.x, mirrored.y, mirrored.z};
}

/// Not inlined: all arguments are constant, so it would expand to a hundred thousand lines.
[[gnu::noinline]] void add(double part, const std::array<double, 14>& what, double* to) noexcept {
  if (part == 0) return;
  for (std::size_t f = 0; f < what.size(); ++f) to[f] += part * what[f];
}

/// The product of a complex vector with i.
template <std::size_t N>
std::array<double, N> times_i(const std::array<double, N>& v) noexcept {
  std::array<double, N> out;
  for (std::size_t i = 0; i < N / 2; ++i) out[i] = -v[N / 2 + i], out[N / 2 + i] = v[i];
  return out;
}

double angle_between_about(const Vec3& from, const Vec3& to, const Vec3& h) noexcept {
  const Vec3 a = cross(h, from), b = cross(h, to);
  return std::atan2(dot(h, cross(a, b)), dot(a, b));
}

}  // namespace

/// The target's part, lengths in units of the arm's size.
struct GeneralSix::Ends {
  Vec3 place, axis, beside;  ///< axis 6 relative to the point of axis 1, and its perpendicular
};

/// The equations after the elimination of angles 1 and 2.
struct GeneralSix::Elimination {
  Rows6x9 one, sine, cosine;  ///< of angle 3, on powers of the half-angle tangents of 4 and 5
  FourteenForEight right;
  Features constant;
};

GeneralSix::GeneralSix(const ArmGeometry& given, bool from_tool, bool prepared) : from_tool_(from_tool) {
  const ArmGeometry arm = from_tool ? reversed(given) : given;
  scale_ = 1 / std::max(arm.size(), 1e-9);
  // Near points of neighbouring axes keep the numbers small.
  std::array<Vec3, 6> points;
  for (std::size_t k = 0; k < 6; ++k) {
    h_[k] = arm.axes[k].direction;
    const Vec3 at = k == 0 ? arm.axes[0].point : points[k - 1];
    points[k] = arm.axes[k].point + dot(h_[k], at - arm.axes[k].point) * h_[k];
  }
  for (std::size_t k = 0; k < 5; ++k) p_[k] = scale_ * (points[k + 1] - points[k]);
  first_ = points[0];
  from_tool_rotation_ = transposed(arm.tool_rotation);
  last_in_tool_ = from_tool_rotation_ * (points[5] - arm.tool_position);
  const Vec3 any = std::abs(h_[5].z) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  beside_6_ = normalized(cross(h_[5], any));
  for (std::size_t k = 0; k < 3; ++k) {
    first_back_[k] = rotation_about(h_[0], -static_cast<double>(k) * kThird);
    second_back_[k] = rotation_about(h_[1], -static_cast<double>(k) * kThird);
  }
  see_middle();
  if (prepared) prepare();
}

/// Polynomials from values at three places of each angle; all features of one coefficient side by side.
void GeneralSix::see_middle() noexcept {
  Rotation third[3], fourth[3], fifth[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = static_cast<double>(k) * kThird;
    third[k] = rotation_about(h_[2], angle);
    fourth[k] = rotation_about(h_[3], kOffset4 + angle);
    fifth[k] = rotation_about(h_[4], kOffset5 + angle);
  }
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t c = 0; c < 3; ++c) {
        const Features at = left_with(third[a], fourth[b], fifth[c]);
        for (std::size_t k = 0; k < 27; ++k)
          add(kToTrig[k / 9][a] * kToHalf[k / 3 % 3][b] * kToHalf[k % 3][c], at, left_.data() + 14 * k);
      }
}

/// If the half-angle tangent of angle 3 is i, the equations contain only four combinations of the powers,
/// those of the plane that axis 3 turns. These and their products with the half-angle tangent of angle 4 span
/// the wanted space, which is the same for every pose. Complex vectors are stored as real ones of twice the
/// length, imaginary parts last, each with its product with i.
void GeneralSix::prepare() noexcept {
  if (ready_) return;
  ready_ = true;
  std::array<std::array<double, 18>, kFeatures> plane;
  for (std::size_t f = 0; f < kFeatures; ++f)
    for (std::size_t j = 0; j < 9; ++j) {
      plane[f][j] = left_[kFeatures * (18 + j) + f];
      plane[f][9 + j] = left_[kFeatures * (9 + j) + f];
    }
  std::array<std::array<double, 18>, 8> span;
  for (std::size_t k = 0; k < span.size(); k += 2) {
    const auto longest = std::max_element(
        plane.begin(), plane.end(), [](const auto& a, const auto& b) { return inner(a, a) < inner(b, b); });
    span[k] = *longest;
    make_square_to(span, k, span[k]);
    span[k + 1] = times_i(span[k]);
    for (auto& row : plane)
      for (const std::size_t of : {k, k + 1}) add_part(-inner(span[of], row), span[of], row);
  }
  std::array<std::array<double, 24>, 16> wanted;
  for (std::size_t k = 0; k < wanted.size(); k += 2) {
    std::array<double, 24>& both = wanted[k] = {};
    const std::size_t power = k < 8 ? 0 : 3;  // of the half-angle tangent of angle 4: zero or one
    for (std::size_t j = 0; j < 9; ++j) {
      both[power + j] = span[k % 8][j];
      both[12 + power + j] = span[k % 8][9 + j];
    }
    make_square_to(wanted, k, both);
    wanted[k + 1] = times_i(both);
  }
  for (std::size_t r = 0; r < 24; ++r)
    for (std::size_t k = 0; k < 16; ++k) wanted_[r][k] = wanted[k][r];
}

/// The vector from axis 3 to axis 6 and its direction, relative to axis 3 at zero.
GeneralSix::Features GeneralSix::left_at(double third, double fourth, double fifth) const noexcept {
  return left_with(rotation_about(h_[2], third), rotation_about(h_[3], fourth), rotation_about(h_[4], fifth));
}
GeneralSix::Features GeneralSix::left_with(const Rotation& r3, const Rotation& r4,
                                           const Rotation& r5) const noexcept {
  return features_of(r3 * (p_[2] + r4 * (p_[3] + r5 * p_[4])), r3 * (r4 * (r5 * h_[5])));
}

/// The same from the other side.
GeneralSix::Features GeneralSix::right_with(const Ends& ends, const Rotation& r1,
                                            const Rotation& r2) const noexcept {
  return features_of(r2 * (r1 * ends.place - p_[0]) - p_[1], r2 * (r1 * ends.axis));
}

GeneralSix::Ends GeneralSix::ends_of(const PoseTarget& given) const noexcept {
  PoseTarget target = given;
  if (from_tool_) {
    target.rotation = transposed(target.rotation);
    target.position = -(target.rotation * target.position);
  }
  const Rotation turn = target.rotation * from_tool_rotation_;
  return {scale_ * (target.position + target.rotation * last_in_tool_ - first_), turn * h_[5],
          turn * beside_6_};
}

/// Fourteen equations that are linear in eight products of sines and cosines of angles 1 and 2; six
/// combinations do not contain these.
void GeneralSix::see_target(const Ends& ends, Elimination& e) const noexcept {
  std::array<Features, 9> right{};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const Features at = right_with(ends, first_back_[a], second_back_[b]);
      for (std::size_t j = 0; j < 9; ++j) add(kToTrig[j / 3][a] * kToTrig[j % 3][b], at, right[j].data());
    }
  e.constant = right[0];
  std::array<Features, 8> unknowns;
  std::copy(right.begin() + 1, right.end(), unknowns.begin());
  e.right.take(unknowns);
  Grid<kFeatures, 28> rows;  // the last column pads to whole registers
  for (std::size_t f = 0; f < kFeatures; ++f) {
    for (std::size_t k = 0; k < 27; ++k) rows[f][k] = left_[kFeatures * k + f];
    rows[f][27] = 0;
    for (const std::size_t k : {0, 2, 6, 8}) rows[f][k] -= e.constant[f];
  }
  e.right.turn(rows);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 9; ++j) {
      e.one[i][j] = rows[8 + i][j];
      e.sine[i][j] = rows[8 + i][9 + j];
      e.cosine[i][j] = rows[8 + i][18 + j];
    }
}

namespace {

/// Six equations, and the same times the half-angle tangent of angle 4: twelve powers.
Grid<12, 12> doubled(const Rows6x9& six) noexcept {
  Grid<12, 12> out{};
  for (std::size_t i = 0; i < 6; ++i) {
    std::copy(six[i].begin(), six[i].end(), out[i].begin());
    std::copy(six[i].begin(), six[i].end(), out[6 + i].begin() + 3);
  }
  return out;
}
/// a x + b y + c z
Rows6x9 mixed(double a, const Rows6x9& x, double b, const Rows6x9& y, double c, const Rows6x9& z) noexcept {
  Rows6x9 out;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 9; ++j) out[i][j] = a * x[i][j] + b * y[i][j] + c * z[i][j];
  return out;
}

}  // namespace

/// The coefficients of the powers of the half-angle tangent of (angle 3 - `turn`): the lowest, the next, and
/// the highest, which is the divisor.
struct GeneralSix::Start {
  Start(const Elimination& e, double angle) noexcept
      : lowest(mixed(1, e.one, std::cos(angle), e.cosine, std::sin(angle), e.sine)),
        next(mixed(0, e.one, -2 * std::sin(angle), e.cosine, 2 * std::cos(angle), e.sine)),
        highest(doubled(mixed(1, e.one, -std::cos(angle), e.cosine, -std::sin(angle), e.sine))),
        turn(angle) {}
  Rows6x9 lowest, next;
  TwelveEquations highest;
  double turn;
};

/// From one start; false if the roots do not converge.
bool GeneralSix::find_thirds(const Start& start, Thirds& out) const noexcept {
  Grid<12, 16> image{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 9; ++j)
      for (const std::size_t half : {0, 1}) {
        add_part(-start.lowest[i][j], wanted_[3 * half + j], image[6 * half + i]);
        add_part(-start.next[i][j], wanted_[12 + 3 * half + j], image[6 * half + i]);
      }
  start.highest.solve(image);
  Grid<16, 16> companion{};
  for (std::size_t r = 0; r < 12; ++r)
    for (std::size_t k = 0; k < 16; ++k) {
      add_part(wanted_[12 + r][k], wanted_[r], companion[k]);
      add_part(image[r][k], wanted_[12 + r], companion[k]);
    }
  using Matrix16 = Eigen::Matrix<double, 16, 16>;
  const Eigen::EigenSolver<Matrix16> roots(Eigen::Map<const Matrix16>(companion[0].data()), false);
  if (roots.info() != Eigen::Success) return false;
  out.count = 0;
  for (int k = 0; k < 16; ++k) {
    const double x = roots.eigenvalues()[k].real(), y = roots.eigenvalues()[k].imag();
    const double off = 2 * std::abs(y) / (1 + x * x - y * y > 0.1 ? 1 + x * x - y * y : 0.1);
    if (y < 0 || !(off < kNearlyReal)) continue;
    out.value[out.count++] = start.turn + 2 * std::atan(x);
  }
  return true;
}

/// Angles 4 and 5 from the null space of the twelve equations, then 1 and 2, then 6. False if there is no
/// sign of a solution.
bool GeneralSix::complete(const Elimination& e, const Ends& ends, double third, State& q) const noexcept {
  const TwelveEquations twelve(doubled(mixed(1, e.one, std::sin(third), e.sine, std::cos(third), e.cosine)));
  Grid<12, 1> v;
  for (std::size_t i = 0; i < 12; ++i) v[i][0] = 1 + 0.37 * static_cast<double>(i * i % 7);
  for (int round = 0; round < 2; ++round) {
    twelve.solve(v);
    double square = 0;
    for (const auto& value : v) square += value[0] * value[0];
    const double size = std::sqrt(square);
    if (!(size > 0) || !std::isfinite(size)) return false;
    for (auto& value : v) value[0] /= size;
  }
  double n4 = 0, d4 = 0, n5 = 0, d5 = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double here = v[3 * i + j][0];
      if (i < 3) n4 += v[3 * i + 3 + j][0] * here, d4 += here * here;
      if (j < 2) n5 += v[3 * i + j + 1][0] * here, d5 += here * here;
    }
  q[2] = third;
  q[3] = kOffset4 + 2 * std::atan2(n4, d4);
  q[4] = kOffset5 + 2 * std::atan2(n5, d5);
  return std::isfinite(finish(e, ends, q));
}

/// Angles 1, 2 and 6 from angles 3 to 5.
double GeneralSix::finish(const Elimination& e, const Ends& ends, State& q) const noexcept {
  Features known = left_at(q[2], q[3], q[4]);
  add_part(-1, e.constant, known);
  // s2 c2 s1 s1s2 s1c2 c1 c1s2 c1c2
  const std::array<double, 8> x = e.right.solve(known);
  q[0] = std::atan2(x[2], x[5]);
  q[1] = std::atan2(x[0], x[1]);
  const Rotation r1 = rotation_about(h_[0], -q[0]), r2 = rotation_about(h_[1], -q[1]);
  const Rotation r3 = rotation_about(h_[2], -q[2]), r4 = rotation_about(h_[3], -q[3]),
                 r5 = rotation_about(h_[4], -q[4]);
  q[5] = angle_between_about(beside_6_, r5 * (r4 * (r3 * (r2 * (r1 * ends.beside)))), h_[5]);
  return q[0] + q[1] + q[5];
}

namespace {

constexpr double kTurns[] = {0.4137, 1.9, -1.2, 3.3};  // starts, tried in order
constexpr double kLeastPivot = 1e-9;                   // of the largest
/// Below this a pivot is rounding: the equations of an arbitrary pose are then never independent, and neither
/// are those of any other.
constexpr double kNoPivot = 1e-14;

}  // namespace

/// Angles 3 of all solutions. Calls `prepare` before it needs the prepared data. False if a pivot is below
/// `give_up`.
template <typename Prepare>
bool GeneralSix::find_all_thirds(const Elimination& e, double give_up, const Prepare& prepare,
                                 Thirds& out) const noexcept {
  out.count = 0;
  for (const double turn : kTurns) {
    const Start start(e, turn);
    const double pivot = start.highest.least_pivot();
    if (pivot < give_up) return false;
    if (!(pivot > kLeastPivot)) continue;
    prepare();
    if (find_thirds(start, out)) break;
  }
  return true;
}

std::size_t GeneralSix::solve(const PoseTarget& target, std::span<State, kMost> out) const noexcept {
  const Ends ends = ends_of(target);
  Elimination e;
  see_target(ends, e);
  Thirds thirds;
  std::size_t count = 0;
  const auto ready = [] {};
  find_all_thirds(e, 0, ready, thirds);
  for (std::size_t k = 0; k < thirds.count; ++k) {
    State& q = out[count];
    if (!complete(e, ends, thirds.value[k], q)) continue;
    if (from_tool_) std::reverse(q.begin(), q.end());
    ++count;
  }
  return count;
}

GeneralSix::Finds GeneralSix::finds(const State& q, const PoseTarget& target, double tolerance) noexcept {
  const auto off = [](double a, double b) { return std::abs(std::remainder(a - b, 2 * std::numbers::pi)); };
  const Ends ends = ends_of(target);
  Elimination e;
  see_target(ends, e);
  Thirds thirds;
  const auto make_ready = [this] { prepare(); };
  if (!find_all_thirds(e, kNoPivot, make_ready, thirds)) return Finds::nothing_ever;
  const double third = from_tool_ ? q[3] : q[2];
  for (std::size_t k = 0; k < thirds.count; ++k) {
    State other;
    if (!(off(thirds.value[k], third) < tolerance) || !complete(e, ends, thirds.value[k], other)) continue;
    if (from_tool_) std::reverse(other.begin(), other.end());
    double worst = 0;
    for (std::size_t i = 0; i < q.size(); ++i) worst = std::max(worst, off(other[i], q[i]));
    if (worst < tolerance) return Finds::it;
  }
  return Finds::not_this;
}

}  // namespace polyarm::kinematics
