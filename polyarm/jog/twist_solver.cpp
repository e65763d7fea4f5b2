#include "polyarm/jog/twist_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/jog/jog_axis.hpp"

namespace polyarm::jog {
namespace {

/// Singular values, with lengths in units of the arm's reach: below this a direction is singular.
constexpr double kSingular = 2e-3;
/// The whole motion slows down to this share before a direction is damped.
constexpr double kSlowest = 0.2;
/// A direction with less than this share of the wish is left out if it is singular.
constexpr double kMatters = 0.02;
/// Above this a direction is far from singular.
constexpr double kFar = 0.3;
/// In a singularity: joint velocity (rad/s) per unit of the wish (reaches or radians per second).
constexpr double kEscapeGain = 2;
/// Look-ahead (rad or m) of the search for an escape motion, and the gains that count as success.
constexpr double kLook = 0.03, kProgress = 1e-4, kTurnsBetter = 1e-5;
/// Cycles until the next search for an escape motion after a failed one.
constexpr int kTimeout = 20;

double length_of(const JogValues& v, std::size_t n) {
  double out = 0;
  for (std::size_t j = 0; j < n; ++j) out += v[j] * v[j];
  return std::sqrt(out);
}

/// Eigenvalues (diagonal of `m`) and eigenvectors (columns of `u`) of a symmetric n × n matrix by cyclic
/// Jacobi rotations (Golub and Van Loan, 8.5).
template <std::size_t N>
void eigen(std::array<std::array<double, N>, N>& m, std::array<std::array<double, N>, N>& u, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) u[i][j] = i == j ? 1 : 0;
  for (int sweep = 0; sweep < 12; ++sweep) {
    double off = 0, on = 0;
    for (std::size_t i = 0; i < n; ++i) {
      on += m[i][i] * m[i][i];
      for (std::size_t j = i + 1; j < n; ++j) off += m[i][j] * m[i][j];
    }
    if (off <= 1e-32 * on) return;
    for (std::size_t p = 0; p + 1 < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (std::abs(m[p][q]) < 1e-300) continue;
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (std::size_t k = 0; k < n; ++k) {
          const double a = m[k][p], b = m[k][q];
          m[k][p] = c * a - s * b;
          m[k][q] = s * a + c * b;
        }
        for (std::size_t k = 0; k < n; ++k) {
          const double a = m[p][k], b = m[q][k];
          m[p][k] = c * a - s * b;
          m[q][k] = s * a + c * b;
        }
        for (std::size_t k = 0; k < n; ++k) {
          const double a = u[k][p], b = u[k][q];
          u[k][p] = c * a - s * b;
          u[k][q] = s * a + c * b;
        }
      }
  }
}

}  // namespace

TwistSolver::TwistSolver(const kinematics::Chain& chain)
    : arm_(chain),
      probe_(chain),
      joints_(chain.joints()),
      columns_(arm_.columns()),
      length_(std::isfinite(chain.reach()) && chain.reach() > 1e-3 ? chain.reach() : 1.0) {
  levels_ = columns_ >= kRows ? 1 : 2;
  level_[0].first = 0;
  level_[0].rows = levels_ == 1 ? 6 : 3;
  level_[1].first = 3;
  level_[1].rows = 3;
  trial_ = level_[0];
  if (columns_ <= kMostJogJoints) find_ranks(chain);
}

/// The rank of each level where the arm is well conditioned: the highest of several joint states.
void TwistSolver::find_ranks(const kinematics::Chain& chain) {
  std::vector<double> q(joints_);
  std::array<std::size_t, 2> best{};
  for (int draw = 0; draw < 8; ++draw) {
    for (std::size_t j = 0; j < joints_; ++j) {
      const double low = std::max(chain.lower()[j], -2.0), high = std::min(chain.upper()[j], 2.0);
      const double phase = 0.37 + 0.61803398875 * static_cast<double>((draw + 1) * (static_cast<int>(j) + 2));
      q[j] = low + (high - low) * (0.1 + 0.8 * (phase - std::floor(phase)));
    }
    at(q);
    for (std::size_t l = 0; l < levels_; ++l) {
      std::size_t rank = 0;
      for (std::size_t k = 0; k < level_[l].rows; ++k) rank += level_[l].sigma[k] > 5 * kSingular;
      best[l] = std::max(best[l], rank);
    }
  }
  level_[0].rank = trial_.rank = best[0];
  level_[1].rank = best[1];
}

void TwistSolver::fill(Level& level, std::span<const double> J) const noexcept {
  for (std::size_t r = 0; r < level.rows; ++r)
    for (std::size_t c = 0; c < columns_; ++c)
      level.A[r * kMostJogJoints + c] = J[6 * c + level.first + r] * (is_locked_[c] ? 0.0 : weight_[c]) *
                                        (level.first + r < 3 ? 1 / length_ : 1.0);
}

void TwistSolver::lock(std::size_t joint) noexcept {
  for (std::size_t c = 0; c < columns_; ++c)
    if (arm_.joints()[c] == joint && !is_locked_[c]) {
      is_locked_[c] = true;
      ++locked_;
      prepare();
    }
}

void TwistSolver::weigh(std::size_t joint, double weight) noexcept {
  for (std::size_t c = 0; c < columns_; ++c)
    if (arm_.joints()[c] == joint) weight_[c] = weight;
}

void TwistSolver::decompose(Level& level) const noexcept {
  std::array<std::array<double, kRows>, kRows> m{};
  const std::size_t n = level.rows;
  const auto row = [&](std::size_t r) { return level.A.data() + r * kMostJogJoints; };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) {
      double sum = 0;
      for (std::size_t c = 0; c < columns_; ++c) sum += row(i)[c] * row(j)[c];
      m[i][j] = m[j][i] = sum;
    }
  std::array<std::array<double, kRows>, kRows> vectors;
  eigen<kRows>(m, vectors, n);
  for (std::size_t k = 0; k < n; ++k) {
    JogValues& v = level.v[k];
    v = {};
    for (std::size_t i = 0; i < n; ++i) {
      level.u[k][i] = vectors[i][k];
      for (std::size_t c = 0; c < columns_; ++c) v[c] += row(i)[c] * vectors[i][k];
    }
    level.sigma[k] = length_of(v, columns_);
    const double scale = level.sigma[k] > 1e-9 ? 1 / level.sigma[k] : 0.0;
    for (std::size_t c = 0; c < columns_; ++c) v[c] *= scale;
  }
}

/// The freedom that the first task leaves to the second.
void TwistSolver::project(Level& second, const Level& first) const noexcept {
  for (std::size_t k = 0; k < first.rows; ++k) {
    if (first.sigma[k] < kSingular) continue;
    for (std::size_t r = 0; r < second.rows; ++r) {
      double* row = second.A.data() + r * kMostJogJoints;
      double along = 0;
      for (std::size_t c = 0; c < columns_; ++c) along += row[c] * first.v[k][c];
      for (std::size_t c = 0; c < columns_; ++c) row[c] -= along * first.v[k][c];
    }
  }
}

void TwistSolver::at(std::span<const double> q) noexcept {
  std::copy(q.begin(), q.end(), q_.begin());
  arm_.at(q);
  is_locked_ = {};
  std::fill_n(weight_.begin(), columns_, 1.0);
  locked_ = 0;
  prepare();
}

void TwistSolver::prepare() noexcept {
  fill(level_[0], arm_.J());
  decompose(level_[0]);
  if (levels_ == 1) return;
  fill(level_[1], arm_.J());
  project(level_[1], level_[0]);
  decompose(level_[1]);
}

Quaternion TwistSolver::rotation() const noexcept {
  const auto& [x, y, z] = arm_.rotation();
  const double m[3][3] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  const double trace = m[0][0] + m[1][1] + m[2][2];
  Quaternion out;
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    out = {(m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s, s / 4};
  } else {
    std::size_t i = m[1][1] > m[0][0] ? 1 : 0;
    if (m[2][2] > m[i][i]) i = 2;
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double s = 2 * std::sqrt(std::max(1 + m[i][i] - m[j][j] - m[k][k], 1e-300));
    double v[3] = {0, 0, 0};
    v[i] = s / 4;
    v[j] = (m[j][i] + m[i][j]) / s;
    v[k] = (m[k][i] + m[i][k]) / s;
    out = {v[0], v[1], v[2], (m[k][j] - m[j][k]) / s};
  }
  return normalized(out);
}

Twist TwistSolver::twist_of(std::span<const double> rates) const noexcept {
  Twist out{};
  const std::span<const double> J = arm_.J();
  for (std::size_t c = 0; c < columns_; ++c)
    for (std::size_t r = 0; r < 6; ++r) out[r] += J[6 * c + r] * rates[arm_.joints()[c]];
  return out;
}

void TwistSolver::gradient_of(const Twist& row, JogValues& out) const noexcept {
  std::fill_n(out.begin(), joints_, 0.0);
  const std::span<const double> J = arm_.J();
  for (std::size_t c = 0; c < columns_; ++c)
    for (std::size_t r = 0; r < 6; ++r) out[arm_.joints()[c]] += J[6 * c + r] * row[r];
}

namespace {
double projection(const std::array<double, 6>& u, const std::array<double, 6>& wish, std::size_t rows) {
  double out = 0;
  for (std::size_t r = 0; r < rows; ++r) out += u[r] * wish[r];
  return out;
}
}  // namespace

/// The share of the wish that first-order motion can give.
double TwistSolver::feasible(const Level& level, const std::array<double, kRows>& wish) const noexcept {
  double out = 0;
  for (std::size_t k = 0; k < level.rows; ++k) {
    const double s = level.sigma[k] * level.sigma[k] / (kSingular * kSingular);
    const double c = projection(level.u[k], wish, level.rows);
    out += c * c * s / (1 + s);
  }
  return out;
}

/// The part of `direction` (columns) that no non-singular direction of the TCP needs, normalised; false if
/// that is zero.
bool TwistSolver::complement(const Level& level, JogValues& direction) const noexcept {
  for (int twice = 0; twice < 2; ++twice)
    for (std::size_t k = 0; k < level.rows; ++k) {
      if (level.sigma[k] < kSingular) continue;
      double along = 0;
      for (std::size_t c = 0; c < columns_; ++c) along += direction[c] * level.v[k][c];
      for (std::size_t c = 0; c < columns_; ++c) direction[c] -= along * level.v[k][c];
    }
  const double n = length_of(direction, columns_);
  if (n < 0.05) return false;
  for (std::size_t c = 0; c < columns_; ++c) direction[c] /= n;
  return true;
}

/// The null space motion that leads in the direction of the wish, or to a state where the wish is possible;
/// false if none is found. Tries a small step up and down of every joint.
bool TwistSolver::escape(const Level& level, const std::array<double, kRows>& wish,
                         const Abilities& abilities, JogValues& direction) noexcept {
  const double now = feasible(level, wish);
  double best = 0;
  bool best_moves = false;
  std::array<double, kinematics::Chain::kMaxJoints> ahead = q_;
  for (std::size_t c = 0; c < columns_; ++c)
    for (const double sign : {1.0, -1.0}) {
      JogValues n{};
      n[c] = sign;
      if (!complement(level, n)) continue;
      bool within = true;
      for (std::size_t k = 0; k < columns_; ++k) {
        const std::size_t j = arm_.joints()[k];
        ahead[j] = q_[j] + kLook * n[k];
        if (std::abs(n[k]) < 0.02) continue;
        within = within && ahead[j] <= abilities.upper[j] && ahead[j] >= abilities.lower[j];
      }
      if (!within) continue;
      probe_.at({ahead.data(), joints_});
      trial_.first = level.first;
      trial_.rows = level.rows;
      fill(trial_, probe_.J());
      double progress = 0;
      for (std::size_t r = 0; r < level.rows; ++r)
        for (std::size_t k = 0; k < columns_; ++k)
          progress += wish[r] * trial_.A[r * kMostJogJoints + k] * n[k];
      if (progress < -kProgress) continue;
      const bool moves = progress > kProgress;
      if (!moves) {
        if (best_moves) continue;
        decompose(trial_);
        progress = feasible(trial_, wish) - now;
        if (progress < kTurnsBetter) continue;
      }
      if (moves == best_moves && progress <= best) continue;
      best = progress;
      best_moves = moves;
      direction = n;
    }
  return best > 0;
}

/// The share of `part` at which its effect on the singular value can still be stopped before zero.
double TwistSolver::into_singularity(const Level& level, std::size_t k, const JogValues& part,
                                     const Abilities& abilities) noexcept {
  arm_.move({part.data(), columns_});
  const std::span<const double> dJ = arm_.dJ();
  double rate = 0;
  for (std::size_t r = 0; r < level.rows; ++r)
    for (std::size_t c = 0; c < columns_; ++c)
      rate += level.u[k][r] * dJ[6 * c + level.first + r] * (level.first + r < 3 ? 1 / length_ : 1.0) *
              level.v[k][c];
  if (rate >= 0) return 1;
  double a = 1e300, jerk = 1e300;
  for (std::size_t c = 0; c < columns_; ++c) {
    const double v = std::abs(part[c]);
    if (v < 1e-12) continue;
    a = std::min(a, abilities.acceleration[arm_.joints()[c]] / v);
    jerk = std::min(jerk, abilities.jerk[arm_.joints()[c]] / v);
  }
  return std::min(1.0, stopping_speed((level.sigma[k] - kSingular) / -rate, a / 4, jerk / 8));
}

void TwistSolver::solve_level(Level& level, const std::array<double, kRows>& wish, const Abilities& abilities,
                              JogValues& rates, double& share, TwistOutcome& outcome) noexcept {
  const double asked = std::sqrt(projection(wish, wish, level.rows));
  if (!(asked > 1e-12)) return;
  const auto note = [&](TwistOutcome what) { outcome = std::max(outcome, what); };
  std::array<JogValues, kRows> parts;
  std::array<double, kRows> demand{};  // of the most demanding joint, 1: its limit
  JogValues whole{};
  double lost = 0;
  for (std::size_t k = 0; k < level.rows; ++k) {
    const double c = projection(level.u[k], wish, level.rows);
    parts[k] = {};
    if (level.sigma[k] < kSingular) {
      lost += c * c;
      continue;
    }
    for (std::size_t i = 0; i < columns_; ++i) {
      parts[k][i] = level.v[k][i] * c / level.sigma[k];
      whole[i] += parts[k][i];
      demand[k] = std::max(demand[k], std::abs(parts[k][i]) / abilities.velocity[arm_.joints()[i]]);
    }
  }
  double most = 0;
  for (std::size_t i = 0; i < columns_; ++i)
    most = std::max(most, std::abs(whole[i]) / abilities.velocity[arm_.joints()[i]]);
  double slowed = std::clamp(most > 1 ? 1 / most : 1.0, kSlowest, 1.0);
  if (slowed < 1) note(TwistOutcome::slowed);
  std::array<double, kRows> left{};  // for each direction, and for all if it is a large part of the wish
  double all = 1;
  for (std::size_t k = 0; k < level.rows; ++k) {
    left[k] = slowed * demand[k] > 1 ? 1 / (slowed * demand[k]) : 1.0;
    if (left[k] < 1) note(TwistOutcome::damped);
    if (demand[k] == 0 || level.sigma[k] > kFar) continue;
    JogValues part = parts[k];
    for (double& value : part) value *= slowed * left[k];
    const double stop = into_singularity(level, k, part, abilities);
    if (stop == 1) continue;
    if (stop < 0.8) note(stop < 0.05 ? TwistOutcome::blocked : TwistOutcome::damped);
    const double much = std::abs(projection(level.u[k], wish, level.rows)) / asked;
    const double whole_too = std::clamp((much - 0.1) / 0.3, 0.0, 1.0);
    all = std::min(all, 1 - whole_too * (1 - stop));
    left[k] *= stop / (1 - whole_too * (1 - stop));
  }
  slowed *= all;
  share = std::min(share, slowed);
  for (std::size_t k = 0; k < level.rows; ++k)
    for (std::size_t i = 0; i < columns_; ++i) rates[i] += slowed * left[k] * parts[k][i];
  if (std::sqrt(lost) < kMatters * asked) {
    if (&level == &level_[0]) escaping_ = false;
    return;
  }
  const bool has_it = level.rank == level.rows || level.rows == 6;
  if (&level != &level_[0]) return note(TwistOutcome::unavailable);
  if (escaping_ && !complement(level, way_)) escaping_ = false;
  if (!escaping_ && (wait_limit_ <= 0 || --wait_limit_ <= 0)) {
    std::array<double, kRows> unit = wish;
    for (double& value : unit) value /= asked;
    escaping_ = escape(level, unit, abilities, way_);
    wait_limit_ = escaping_ ? 0 : kTimeout;
  }
  if (!escaping_) {  // no motion is better than only the remaining part of the request
    const double rest = 1 - std::clamp((std::sqrt(lost) / asked - 0.7) / 0.25, 0.0, 1.0);
    for (double& rate : rates) rate *= rest;
    share *= rest;
    return note(has_it ? TwistOutcome::blocked : TwistOutcome::unavailable);
  }
  note(TwistOutcome::joint_wise);
  for (std::size_t i = 0; i < columns_; ++i) rates[i] += kEscapeGain * std::sqrt(lost) * way_[i];
}

void TwistSolver::solve(const Twist& twist, const Abilities& abilities, Solution& out) noexcept {
  out = {};
  JogValues rates{};
  for (std::size_t l = 0; l < levels_; ++l) {
    Level& level = level_[l];
    std::array<double, kRows> wish{};
    for (std::size_t r = 0; r < level.rows; ++r) {
      wish[r] = twist[level.first + r] * (level.first + r < 3 ? 1 / length_ : 1.0);
      if (l == 0) continue;
      // The rotation that the first task already causes.
      for (std::size_t c = 0; c < columns_; ++c) wish[r] -= arm_.J()[6 * c + level.first + r] * rates[c];
    }
    TwistOutcome outcome = TwistOutcome::exact;
    JogValues more{};
    solve_level(level, wish, abilities, more, out.share, outcome);
    for (std::size_t c = 0; c < columns_; ++c) rates[c] += more[c];
    // An arm with fewer joints always turns as it moves along: not reported.
    const bool turning = std::abs(twist[3]) + std::abs(twist[4]) + std::abs(twist[5]) > 0;
    if (l == 0 || turning) out.outcome = std::max(out.outcome, outcome);
  }
  for (std::size_t c = 0; c < columns_; ++c) out.rates[arm_.joints()[c]] = rates[c];
}

double TwistSolver::exact(const Twist& twist, JogValues& out) const noexcept {
  JogValues rates{};
  double lost = 0, asked = 0;
  const bool turns = std::abs(twist[3]) + std::abs(twist[4]) + std::abs(twist[5]) > 0;
  for (std::size_t l = 0; l < levels_; ++l) {
    const Level& level = level_[l];
    std::array<double, kRows> wish{};
    for (std::size_t r = 0; r < level.rows; ++r) {
      wish[r] = twist[level.first + r] * (level.first + r < 3 ? 1 / length_ : 1.0);
      if (l == 0 || turns) asked += wish[r] * wish[r];
      if (l == 0) continue;
      // The rotation that the first task already causes.
      for (std::size_t c = 0; c < columns_; ++c) wish[r] -= arm_.J()[6 * c + level.first + r] * rates[c];
    }
    JogValues more{};
    for (std::size_t k = 0; k < level.rows; ++k) {
      const double c = projection(level.u[k], wish, level.rows);
      if (level.sigma[k] < kSingular) {
        if (l == 0 || turns) lost += c * c;
        continue;
      }
      for (std::size_t i = 0; i < columns_; ++i) more[i] += level.v[k][i] * c / level.sigma[k];
    }
    for (std::size_t c = 0; c < columns_; ++c) rates[c] += weight_[c] * more[c];
  }
  std::fill_n(out.begin(), joints_, 0.0);
  for (std::size_t c = 0; c < columns_; ++c) out[arm_.joints()[c]] = rates[c];
  return asked > 0 ? std::sqrt(lost / asked) : 0;
}

void TwistSolver::reach(const Twist& twist, JogValues& out) const noexcept {
  out = {};
  for (std::size_t l = 0; l < levels_; ++l) {
    const Level& level = level_[l];
    std::array<double, kRows> wish{};
    for (std::size_t r = 0; r < level.rows; ++r)
      wish[r] = twist[level.first + r] * (level.first + r < 3 ? 1 / length_ : 1.0);
    for (std::size_t k = 0; k < level.rows; ++k) {
      const double c = projection(level.u[k], wish, level.rows);
      // Near a singularity the joints get a reduced demand.
      const double s = std::max(level.sigma[k], 0.03);
      for (std::size_t i = 0; i < columns_; ++i) out[arm_.joints()[i]] += level.v[k][i] * c / s;
    }
  }
}

}  // namespace polyarm::jog
