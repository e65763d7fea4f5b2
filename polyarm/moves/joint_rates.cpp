#include "polyarm/moves/joint_rates.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace polyarm::moves {
namespace {

constexpr int kSteps = 12;          // of Newton's method; from a nearby start three are enough
constexpr double kSettled = 1e-13;  // m and rad
constexpr double kEnough = 1e-10;   // accepted if rounding stops the iteration
constexpr double kNone = 1e-9;      // relative to the largest singular value: smaller values count as zero
constexpr double kAlong = 1e-6;     // fraction of the path's direction that a singularity may block
constexpr int kMost = static_cast<int>(kinematics::Chain::kMostMoving);

using Six = Eigen::Matrix<double, 6, 1>;
using Six6 = Eigen::Matrix<double, 6, 6>;
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMost>;
using Values = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;

Eigen::Map<const Columns> matrix(std::span<const double> columns) {
  return {columns.data(), 6, static_cast<Eigen::Index>(columns.size() / 6)};
}
Six six(const Vec3& linear, const Vec3& angular) {
  return (Six() << linear.x, linear.y, linear.z, angular.x, angular.y, angular.z).finished();
}

/// Solves J x = b: exactly, with the smallest x, or by least squares, depending on the number of joints.
class Solver {
 public:
  explicit Solver(const Eigen::Map<const Columns>& J) : J_(J) {
    if (J.cols() == 6)
      square_.compute(J);
    else if (J.cols() > 6)
      wide_.compute(J * J.transpose());
    else
      tall_.emplace(J);
  }
  Values operator()(const Six& b) const {
    if (J_.cols() == 6) return square_.solve(b);
    if (J_.cols() > 6) return J_.transpose() * wide_.solve(b);
    return tall_->solve(b);
  }
  bool redundant() const { return J_.cols() > 6; }
  /// (J J^T)^-1 b, for a redundant arm.
  Six multiplier(const Six& b) const { return wide_.solve(b); }

 private:
  Eigen::Map<const Columns> J_;
  Eigen::PartialPivLU<Six6> square_;
  Eigen::LDLT<Six6> wide_;
  std::optional<Eigen::ColPivHouseholderQR<Columns>> tall_;
};

/// The derivatives of the smallest first derivative J^T l, l = (J J^T)^-1 x'.
void redundant_rates(ArmDerivatives& arm, const Solver& solve, const std::array<Six, 3>& x,
                     std::array<Values, 3>& d, const auto& span_of) {
  const auto J = matrix(arm.J()), dJ = matrix(arm.dJ()), ddJ = matrix(arm.ddJ());
  const Six l = solve.multiplier(x[0]);
  d[0] = J.transpose() * l;
  arm.move(span_of(d[0]));
  const Six dl = solve.multiplier(x[1] - dJ * d[0] - J * (dJ.transpose() * l));
  d[1] = dJ.transpose() * l + J.transpose() * dl;
  arm.move_on(span_of(d[0]), span_of(d[1]));
  const Values known = ddJ.transpose() * l + 2 * (dJ.transpose() * dl);
  d[2] = known + J.transpose() * solve.multiplier(x[2] - 2 * (dJ * d[1]) - ddJ * d[0] - J * known);
}

}  // namespace

std::array<double, 6> tcp_error(const ArmDerivatives& arm, const Pose& target) noexcept {
  const Vec3 way = target.position - arm.position();
  const std::array<Vec3, 3>& r = arm.rotation();
  const Vec3 x = target.rotation * Vec3{1, 0, 0}, y = target.rotation * Vec3{0, 1, 0}, z = cross(x, y);
  Vec3 turn = 0.5 * (cross(r[0], x) + cross(r[1], y) + cross(r[2], z));
  // Beyond a right angle the length of that sum decreases again; there it is set to 1.
  if (dot(r[0], x) + dot(r[1], y) + dot(r[2], z) < 1) turn = normalized(turn);
  return {way.x, way.y, way.z, turn.x, turn.y, turn.z};
}

bool settle(ArmDerivatives& arm, std::span<double> q, const Pose& target) {
  double before = 1e300;
  for (int step = 0; step < kSteps; ++step) {
    arm.at(q);
    const std::array<double, 6> error = tcp_error(arm, target);
    const Six e = Eigen::Map<const Six>(error.data());
    const double size = e.cwiseAbs().maxCoeff();
    if (size <= kSettled || (size <= kEnough && size > before / 2)) return true;
    if (!(size < 2) || (step > 3 && size > before / 2)) return false;
    before = size;
    const Values change = Solver(matrix(arm.J()))(e);
    if (!change.allFinite() || change.cwiseAbs().maxCoeff() > 1) return false;
    for (std::size_t k = 0; k < arm.columns(); ++k)
      q[arm.joints()[k]] += change[static_cast<Eigen::Index>(k)];
  }
  return false;
}

bool find_rates(ArmDerivatives& arm, const paths::PoseDerivatives& path, JointRates& out) {
  std::array<Six, 3> x;
  for (std::size_t n = 0; n < 3; ++n) x[n] = six(path.linear[n], path.angular[n]);
  const Solver solve(matrix(arm.J()));
  const auto span_of = [](const Values& v) {
    return std::span(v.data(), static_cast<std::size_t>(v.size()));
  };
  std::array<Values, 3> d;
  if (solve.redundant()) {
    redundant_rates(arm, solve, x, d, span_of);
  } else {
    d[0] = solve(x[0]);
    arm.move(span_of(d[0]));
    d[1] = solve(x[1] - matrix(arm.dJ()) * d[0]);
    arm.move_on(span_of(d[0]), span_of(d[1]));
    d[2] = solve(x[2] - 2 * (matrix(arm.dJ()) * d[1]) - matrix(arm.ddJ()) * d[0]);
  }
  for (std::size_t n = 0; n < 3; ++n) {
    if (!d[n].allFinite()) return false;
    std::copy(d[n].data(), d[n].data() + d[n].size(), out.d[n].begin());
  }
  return true;
}

FastestJoint fastest_joint(const ArmDerivatives& arm, const paths::PoseDerivatives& path) {
  const Eigen::MatrixXd J = matrix(arm.J());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Six x = six(path.linear[0], path.angular[0]);
  Eigen::VectorXd rates = Eigen::VectorXd::Zero(J.cols());
  FastestJoint out;
  Eigen::Index column = 0;
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i) {
    const double share = svd.matrixU().col(i).dot(x), value = svd.singularValues()[i];
    if (value > kNone * svd.singularValues()[0]) {
      rates += share / value * svd.matrixV().col(i);
    } else if (std::abs(share) > kAlong) {
      svd.matrixV().col(i).cwiseAbs().maxCoeff(&column);
      return {static_cast<std::size_t>(column), std::numeric_limits<double>::infinity()};
    }
  }
  out.rate = rates.cwiseAbs().maxCoeff(&column);
  out.column = static_cast<std::size_t>(column);
  return out;
}

}  // namespace polyarm::moves
