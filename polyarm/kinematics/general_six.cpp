#include "polyarm/kinematics/general_six.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace polyarm::kinematics {

namespace {

using Matrix6x9 = Eigen::Matrix<double, 6, 9>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix16 = Eigen::Matrix<double, 16, 16>;
using Matrix14x27 = Eigen::Matrix<double, 14, 27>;
using Matrix24x16 = Eigen::Matrix<double, 24, 16>;

constexpr double kThird = 2 * std::numbers::pi / 3;
/// Where half-angle tangents of angles 4 and 5 are infinite is turned off the values that poses like.
constexpr double kOffset4 = 0.7345, kOffset5 = -1.1931;
constexpr double kNearlyReal = 0.1;  // rad off the real axis: polish tells whether there is a solution

/// Values at 0, 120 and 240 degrees to (1, sin, cos) of what is of first degree in both.
constexpr double kRoot3 = 1.7320508075688772;
constexpr double kToTrig[3][3] = {
    {1.0 / 3, 1.0 / 3, 1.0 / 3}, {0, kRoot3 / 3, -kRoot3 / 3}, {2.0 / 3, -1.0 / 3, -1.0 / 3}};
/// The same to powers 0, 1, 2 of the half-angle's tangent, all times 1 + tan^2.
constexpr double kToHalf[3][3] = {
    {1, 0, 0}, {0, 2 * kRoot3 / 3, -2 * kRoot3 / 3}, {-1.0 / 3, 2.0 / 3, 2.0 / 3}};

std::array<double, 14> features_of(const Vec3& p, const Vec3& l) noexcept {
  const double pp = dot(p, p), pl = dot(p, l);
  const Vec3 across = cross(p, l), mirrored = pp * l - (2 * pl) * p;
  return {p.x, p.y,      p.z,      l.x,      l.y,        l.z,        pp,
          pl,  across.x, across.y, across.z, mirrored.x, mirrored.y, mirrored.z};
}

/// Not inlined: all that it is called with is constant, and would become a hundred thousand lines.
[[gnu::noinline]] void add(double part, const std::array<double, 14>& what, double* to) noexcept {
  if (part == 0) return;
  for (std::size_t f = 0; f < what.size(); ++f) to[f] += part * what[f];
}

double angle_between_about(const Vec3& from, const Vec3& to, const Vec3& h) noexcept {
  const Vec3 a = cross(h, from), b = cross(h, to);
  return std::atan2(dot(h, cross(a, b)), dot(a, b));
}

}  // namespace

/// What the target adds, lengths in parts of the arm's size.
struct GeneralSix::Ends {
  Vec3 place, axis, beside;  ///< of axis 6, seen from the point of axis 1; and what is beside axis 6
};

/// What is left when angles 1 and 2 are eliminated.
struct GeneralSix::Elimination {
  Matrix6x9 one, sine, cosine;  ///< of angle 3, on powers of half-angle tangents of 4 and 5
  Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 14, 8>> right;
  Eigen::Matrix<double, 14, 1> constant;
};

GeneralSix::GeneralSix(const ArmGeometry& given, bool from_tool, bool prepared) : from_tool_(from_tool) {
  const ArmGeometry arm = from_tool ? reversed(given) : given;
  scale_ = 1 / std::max(arm.size(), 1e-9);
  // Points of neighbouring axes that are near to each other keep the numbers small.
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

/// Polynomials from values at three of each angle: all features of one coefficient side by side.
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

/// Where the half-angle tangent of angle 3 is i, the equations know of four combinations of the powers only,
/// those of the plane that axis 3 turns: what these leave free is the same for every pose.
void GeneralSix::prepare() noexcept {
  if (ready_) return;
  ready_ = true;
  using Complex = std::complex<double>;
  const Eigen::Map<const Matrix14x27> left(left_.data());
  Eigen::Matrix<Complex, kFeatures, 9> plane;
  for (int f = 0; f < plane.rows(); ++f)
    for (int j = 0; j < 9; ++j) {
      plane(f, j) = {left(f, 18 + j), left(f, 9 + j)};
    }
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<Complex, 9, kFeatures>> rows(plane.adjoint());
  const Eigen::Matrix<Complex, 9, 9> span = rows.householderQ();
  Eigen::Matrix<Complex, 12, 8> known = Eigen::Matrix<Complex, 12, 8>::Zero();
  known.topLeftCorner<9, 4>() = span.leftCols<4>();
  known.bottomRightCorner<9, 4>() = span.leftCols<4>();
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<Complex, 12, 8>> two(known);
  const Eigen::Matrix<Complex, 12, 12> all = two.householderQ();
  Eigen::Matrix<double, 24, 8> spurious;
  for (int k = 0; k < 4; ++k) {
    const auto v = all.col(8 + k);
    spurious.col(2 * k) << v.real(), -v.imag();
    spurious.col(2 * k + 1) << v.imag(), v.real();
  }
  const Eigen::HouseholderQR<Eigen::Matrix<double, 24, 8>> parted(spurious);
  const Eigen::Matrix<double, 24, 24> basis = parted.householderQ();
  Eigen::Map<Matrix24x16> wanted(wanted_.data());
  wanted = basis.rightCols<16>();
}

/// The way from axis 3 to axis 6, and the direction of that, seen from axis 3 where it stands at zero.
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

/// Fourteen equations, linear in eight products of sines and cosines of angles 1 and 2; six combinations are
/// free of them.
void GeneralSix::see_target(const Ends& ends, Elimination& e) const noexcept {
  Eigen::Matrix<double, 14, 9> right = Eigen::Matrix<double, 14, 9>::Zero();
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const Features at = right_with(ends, first_back_[a], second_back_[b]);
      for (std::size_t j = 0; j < 9; ++j)
        add(kToTrig[j / 3][a] * kToTrig[j % 3][b], at, right.data() + 14 * j);
    }
  e.constant = right.col(0);
  e.right.compute(right.rightCols<8>());
  Matrix14x27 left = Eigen::Map<const Matrix14x27>(left_.data());
  for (const int j : {0, 2, 6, 8}) left.col(j) -= e.constant;
  left.applyOnTheLeft(e.right.householderQ().adjoint());
  const Eigen::Matrix<double, 6, 27> free = left.bottomRows<6>();
  e.one = free.leftCols<9>();
  e.sine = free.middleCols<9>(9);
  e.cosine = free.rightCols<9>();
}

struct GeneralSix::Start {
  Matrix6x9 even, odd;
  Eigen::PartialPivLU<Matrix12> square;
  double turn = 0;
};

namespace {

/// Six equations, and the same times the half-angle tangent of angle 4: twelve powers.
Matrix12 doubled(const Matrix6x9& six) noexcept {
  Matrix12 out = Matrix12::Zero();
  out.topLeftCorner<6, 9>() = six;
  out.bottomRightCorner<6, 9>() = six;
  return out;
}

}  // namespace

/// What stands before the highest power of the half-angle's tangent of what angle 3 is beyond `turn`, and
/// before the others. Returns the least pivot of the former in parts of the largest.
double GeneralSix::start_at(const Elimination& e, double turn, Start& out) noexcept {
  const double s = std::sin(turn), c = std::cos(turn);
  out.even = c * e.cosine + s * e.sine;
  out.odd = c * e.sine - s * e.cosine;
  out.square.compute(doubled(e.one - out.even));
  out.turn = turn;
  const Vector12 pivots = out.square.matrixLU().diagonal().cwiseAbs();
  return pivots.minCoeff() / pivots.maxCoeff();
}

/// From one start; false where the roots do not come.
bool GeneralSix::find_thirds(const Elimination& e, const Start& start, Thirds& out) const noexcept {
  Eigen::Matrix<double, 12, 24> rest;
  rest << doubled(e.one + start.even), doubled(2 * start.odd);
  const Eigen::Map<const Matrix24x16> wanted(wanted_.data());
  Matrix24x16 image;
  image.topRows<12>() = wanted.bottomRows<12>();
  image.bottomRows<12>().noalias() = -start.square.solve(rest * wanted);
  const Matrix16 companion = wanted.transpose() * image;
  const Eigen::EigenSolver<Matrix16> roots(companion, false);
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

/// Angles 4 and 5 from what the twelve equations leave free, then 1 and 2, then 6. False where a sign of a
/// solution is missing.
bool GeneralSix::complete(const Elimination& e, const Ends& ends, double third, State& q) const noexcept {
  const Matrix6x9 six = e.one + std::sin(third) * e.sine + std::cos(third) * e.cosine;
  const Eigen::PartialPivLU<Matrix12> twelve(doubled(six));
  Vector12 v;
  for (int i = 0; i < 12; ++i) v[i] = 1 + 0.37 * (i * i % 7);
  for (int round = 0; round < 2; ++round) {
    v = twelve.solve(v);
    const double size = v.norm();
    if (!(size > 0) || !std::isfinite(size)) return false;
    v /= size;
  }
  double n4 = 0, d4 = 0, n5 = 0, d5 = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 3; ++j) {
      const double here = v[3 * i + j];
      if (i < 3) n4 += v[3 * i + 3 + j] * here, d4 += here * here;
      if (j < 2) n5 += v[3 * i + j + 1] * here, d5 += here * here;
    }
  q[2] = third;
  q[3] = kOffset4 + 2 * std::atan2(n4, d4);
  q[4] = kOffset5 + 2 * std::atan2(n5, d5);
  return std::isfinite(finish(e, ends, q));
}

/// Angles 1, 2 and 6 where 3 to 5 are known.
double GeneralSix::finish(const Elimination& e, const Ends& ends, State& q) const noexcept {
  const Features at = left_at(q[2], q[3], q[4]);
  const Eigen::Matrix<double, 14, 1> known =
      Eigen::Map<const Eigen::Matrix<double, 14, 1>>(at.data()) - e.constant;
  // s2 c2 s1 s1s2 s1c2 c1 c1s2 c1c2
  const Eigen::Matrix<double, 8, 1> x = e.right.solve(known);
  q[0] = std::atan2(x[2], x[5]);
  q[1] = std::atan2(x[0], x[1]);
  const Rotation r1 = rotation_about(h_[0], -q[0]), r2 = rotation_about(h_[1], -q[1]);
  const Rotation r3 = rotation_about(h_[2], -q[2]), r4 = rotation_about(h_[3], -q[3]),
                 r5 = rotation_about(h_[4], -q[4]);
  q[5] = angle_between_about(beside_6_, r5 * (r4 * (r3 * (r2 * (r1 * ends.beside)))), h_[5]);
  return q[0] + q[1] + q[5];
}

namespace {

constexpr double kTurns[] = {0.4137, 1.9, -1.2, 3.3};  // to start from, one after the other
constexpr double kLeastPivot = 1e-9;                   // of the largest
/// Less is rounding: the equations of an arbitrary pose are never independent, nor are those of any other.
constexpr double kNoPivot = 1e-14;

}  // namespace

/// Angles 3 of all solutions. `prepare` is called before what it prepares is needed. False where a pivot is
/// below `give_up`.
template <typename Prepare>
bool GeneralSix::find_all_thirds(const Elimination& e, double give_up, const Prepare& prepare,
                                 Thirds& out) const noexcept {
  Start start;
  out.count = 0;
  for (const double turn : kTurns) {
    const double pivot = start_at(e, turn, start);
    if (pivot < give_up) return false;
    if (!(pivot > kLeastPivot)) continue;
    prepare();
    if (find_thirds(e, start, out)) break;
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
