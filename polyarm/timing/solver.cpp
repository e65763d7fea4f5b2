#include "polyarm/timing/solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/timing/solver_rows.hpp"

namespace polyarm::timing {
namespace {

constexpr double kCentre = 0.7;        // fraction of the requested gap that products approach
constexpr double kLeastSlack = 0.001;  // when continuing, relative to the width between the limits

}  // namespace

class SpeedSolver::Solver {
 public:
  Solver(const SpeedProblem& problem, NodeMotion& motion)
      : motion_(motion), pieces_(motion), step_(motion.s.size() + 4), system_(motion.s.size()) {
    rows_.emplace_back(problem.velocity, RowKind::velocity);
    for (const LimitRows* rows : {&problem.acceleration, &problem.norm_acceleration})
      rows_.emplace_back(*rows, RowKind::acceleration);
    for (const LimitRows* rows : {&problem.jerk, &problem.norm_jerk})
      rows_.emplace_back(*rows, RowKind::jerk);
    pieces_.evaluate();
  }

  void inherit(const Solver& before, const PointOrigins& origins) {
    rows_[0].inherit(before.rows_[0], origins.velocity);
    for (const std::size_t i : {1, 2}) rows_[i].inherit(before.rows_[i], origins.acceleration);
    for (const std::size_t i : {3, 4}) rows_[i].inherit(before.rows_[i], origins.jerk);
    again_ = true;
  }
  SpeedSolution run(double precision, double allowed, int most) {
    SpeedSolution out;
    std::size_t sides = 0;
    for (SolverRows& r : rows_) sides += r.sides();
    for (int i = 0; i < 9 && pieces_.worst_gap() > 1e-6; ++i) pieces_.close();
    evaluate();
    for (SolverRows& r : rows_)
      r.begin((again_ ? kCentre * precision : 0.3) * pieces_.duration() / double(sides),
              again_ ? kLeastSlack : 0.05, again_);
    const bool going_on = again_;
    again_ = true;
    double keep = 0.2, last_residual = 1e9;
    damping_ = 1, stuck_ = 0;
    for (; out.iterations < most; ++out.iterations) {
      double gap = 0, residual = 0;
      for (const SolverRows& r : rows_) r.measure(gap, residual);
      out.converged = gap < precision * pieces_.duration() && residual < allowed;
      if (out.converged && (out.iterations > 0 || !going_on)) break;
      // Repeated overshooting comes from the curvature of the rows, which the linearisation leaves out.
      if (residual > 2 * last_residual && residual > 0.1 * allowed)
        damping_ = std::max(0.25, damping_ / 2);
      else
        damping_ = std::min(1.0, 1.3 * damping_);
      last_residual = residual;
      // Stays as far from the limits as requested: within that, the optimum depends little on the scales.
      const double centre = std::max(keep * gap, kCentre * precision * pieces_.duration()) / double(sides);
      system_.clear();
      add_duration();
      for (SolverRows& r : rows_) r.assemble(centre, system_);
      system_.solve(pieces_.count() - 1, step_);
      keep = go(centre);
      if (stuck_ > 2) break;
    }
    for (int i = 0; i < 6 && pieces_.worst_gap() > 1e-13; ++i) pieces_.close();
    return out;
  }
  const JerkPieces& pieces() const { return pieces_; }

 private:
  void evaluate() {
    pieces_.find_directions();
    for (SolverRows& r : rows_) r.evaluate(motion_, pieces_);
  }
  void add_duration() {
    for (std::size_t k = 1; k <= pieces_.count(); ++k) {
      const JerkPiece& p = pieces_.piece(k);
      const Moves moves = moves_at(pieces_, k);
      const double low = pieces_.speed_by(k - 1), high = pieces_.speed_by(k);
      const double sum = pieces_.speed(k - 1) + pieces_.speed(k), bend = p.time / sum;
      // The curvature of 2Δs/(v₀ + v₁) with respect to b: that of the duration, without the changes along a
      // piece.
      const double c00 = bend * (2 * low * low / sum + 2 * low * low * low),
                   c01 = bend * 2 * low * high / sum;
      const double c11 = bend * (2 * high * high / sum + 2 * high * high * high);
      Basis right{}, one{}, two{};
      for (std::size_t i = 0; i < 3; ++i) {
        one[i] = c00 * moves[0][i] + c01 * moves[2][i], two[i] = c01 * moves[0][i] + c11 * moves[2][i];
        for (std::size_t n = 0; n < 4; ++n) right[i] -= p.time_by[n] * moves[n][i];
      }
      const auto entry = [&](std::size_t i, std::size_t j) {
        return moves[0][i] * one[j] + moves[2][i] * two[j];
      };
      system_.add(k - 1, {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)},
                  right);
    }
  }
  /// Takes the step; returns the fraction of the complementarity to keep next.
  double go(double centre) {
    SolverRows::Steps longest;
    for (SolverRows& r : rows_) r.direction(centre, step_, longest);
    double primal = longest.primal > 0.98 ? 0.98 / longest.primal : 1;
    const double dual = longest.dual > 0.98 ? 0.98 / longest.dual : 1;
    const std::size_t last = pieces_.count();
    for (std::size_t k = 1; k < last; ++k) {
      const double change = pieces_.change_of_b(k, &step_[1]) / motion_.b[k];
      if (change * primal < -0.7) primal = -0.7 / change;
      if (change * primal > 3) primal = 3 / change;
    }
    primal *= damping_;
    before_ = motion_;
    for (int tries = 0;; ++tries, primal *= 0.3) {
      for (std::size_t k = 1; k < last; ++k) {
        motion_.b[k] = before_.b[k] + primal * pieces_.change_of_b(k, &step_[1]);
        motion_.a[k] = before_.a[k] + primal * pieces_.change_of_a(k, &step_[1]);
      }
      pieces_.evaluate();
      for (int i = 0; i < 3 && pieces_.worst_gap() > 1e-6; ++i) pieces_.close();
      if (pieces_.sound()) {
        stuck_ = 0;
        break;
      }
      if (tries < 9) continue;
      ++stuck_;
      motion_ = before_, primal = 0;
      pieces_.evaluate();
      break;
    }
    for (SolverRows& r : rows_) r.go(centre, primal, dual);
    evaluate();
    const double least = std::min(primal, dual);
    return least > 0.9 ? 0.05 : least > 0.6 ? 0.15 : least > 0.3 ? 0.3 : 0.6;
  }

  NodeMotion& motion_;
  NodeMotion before_;
  JerkPieces pieces_;
  std::vector<double> step_;
  FiveDiagonals system_;
  std::vector<SolverRows> rows_;
  double damping_ = 1;  // factor of the steps
  int stuck_ = 0;       // number of steps without progress
  bool again_ = false;
};

void LimitRows::resize(std::size_t new_rows, std::size_t new_points) {
  rows = new_rows, points = new_points;
  for (auto& c : coefficient) c.assign(rows * points, 0.0);
  low.assign(rows, -1.0);
  scale.assign(points, 1.0);
}

SpeedSolver::SpeedSolver(const SpeedProblem& problem, NodeMotion& motion)
    : solver_(std::make_unique<Solver>(problem, motion)) {}
SpeedSolver::SpeedSolver(const SpeedProblem& problem, NodeMotion& motion, const SpeedSolver& before,
                         const PointOrigins& origins)
    : SpeedSolver(problem, motion) {
  solver_->inherit(*before.solver_, origins);
}
SpeedSolver::~SpeedSolver() = default;

SpeedSolution SpeedSolver::improve(double precision, double residual, int most_iterations) {
  return solver_->run(precision, residual, most_iterations);
}
const JerkPieces& SpeedSolver::pieces() const {
  return solver_->pieces();
}

}  // namespace polyarm::timing
