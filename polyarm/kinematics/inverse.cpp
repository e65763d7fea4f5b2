#include "polyarm/kinematics/inverse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "polyarm/kinematics/descent.hpp"
#include "polyarm/kinematics/inverse_kinematics.hpp"

namespace polyarm::kinematics {

namespace {

constexpr std::size_t kMostSolutions = 64;
constexpr double kSameSolution = 1e-3;  // rad or m: nearer than this is one solution

double distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

double largest_change(std::span<const double> a, std::span<const double> b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// A question in the form the descents want: a unit rotation, a seed inside limits.
struct Question {
  const Chain& chain;
  Pose target;
  std::vector<double> seed;
  const IkOptions& options;
  std::string flaw;  ///< why it cannot be asked at all

  Question(const Chain& c, const Pose& t, std::span<const double> s, const IkOptions& o)
      : chain(c), target(t), seed(s.begin(), s.end()), options(o) {
    const Quaternion& r = t.rotation;
    const double length = r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w;
    if (!std::isfinite(t.position.x + t.position.y + t.position.z + length))
      flaw = "the pose has a value that is not a finite number";
    else if (length < 1e-12)
      flaw = "the orientation is a quaternion of length zero";
    else if (c.joints() == 0)
      flaw = "the robot has no joints that move";
    else if (s.size() != c.joints())
      flaw = "the seed has " + std::to_string(s.size()) + " values, the robot " + std::to_string(c.joints()) +
             " joints";
    if (!flaw.empty()) return;
    target.rotation = normalized(r);
    for (std::size_t i = 0; i < seed.size(); ++i)
      seed[i] = std::isfinite(seed[i]) ? std::clamp(seed[i], c.lower()[i], c.upper()[i]) : resting(i);
  }
  double resting(std::size_t i) const { return std::clamp(0.0, chain.lower()[i], chain.upper()[i]); }
  double weight() const {
    return options.orientation_free ? 0.0 : std::max(1e-6, options.orientation_weight);
  }
  bool out_of_bounds() const {
    return norm(target.position - chain.reach_center()) > chain.reach_bound() + options.position_tolerance;
  }
};

IkResult flawed(const Question& question) {
  IkResult out;
  out.q = question.seed;
  out.position_error = out.orientation_error = std::numeric_limits<double>::infinity();
  out.reason = question.flaw;
  return out;
}

IkResult solved(const Question& question, std::span<const double> q) {
  IkResult out;
  out.status = IkStatus::solved;
  out.q.assign(q.begin(), q.end());
  const Pose there = question.chain.forward(q);
  out.position_error = norm(question.target.position - there.position);
  if (!question.options.orientation_free)
    out.orientation_error = angle_between(there.rotation, question.target.rotation);
  return out;
}

/// The nearest that any descent came.
struct Nearest {
  JointState q{};
  PoseError error;
  double size = 1e300;
};

/// From one seed: first free and wound back into the limits; if they are still broken, with the limits as
/// walls.
bool descend(const Question& question, JointState& q, std::span<const double> near, Nearest* nearest) {
  const JointState start = q;
  for (const bool walls : {false, true}) {
    q = start;
    Descent descent(question.chain, question.target, question.options, question.weight());
    const bool found = descent.run(q, walls);
    if (!walls && !found) continue;
    unwind(question.chain, q, near);
    if (found && inside_limits(question.chain, q)) {
      for (std::size_t i = 0; i < near.size(); ++i)
        q[i] = std::clamp(q[i], question.chain.lower()[i], question.chain.upper()[i]);
      return true;
    }
    if (walls && nearest && descent.size() < nearest->size) *nearest = {q, descent.error(), descent.size()};
  }
  return false;
}

JointState state_of(std::span<const double> values) {
  JointState q{};
  std::copy(values.begin(), values.end(), q.begin());
  return q;
}

IkResult search(const Question& question) {
  const std::size_t n = question.chain.joints();
  JointState q = state_of(question.seed);
  Nearest nearest;
  Random random(1);
  const int restarts = question.out_of_bounds() ? 0 : question.options.restarts;
  for (int k = 0; k <= restarts; ++k) {
    if (descend(question, q, question.seed, &nearest)) return solved(question, {q.data(), n});
    q = state_of(question.seed);
    scatter(question.chain, q, random);
  }
  IkResult out;
  out.q.assign(nearest.q.begin(), nearest.q.begin() + static_cast<std::ptrdiff_t>(n));
  if (nearest.size > 1e299) out.q = question.seed;
  const Pose there = question.chain.forward(out.q);
  out.position_error = norm(question.target.position - there.position);
  if (!question.options.orientation_free)
    out.orientation_error = angle_between(there.rotation, question.target.rotation);
  explain_failure(question.chain, question.target, question.seed, question.options, out);
  return out;
}

/// All branches of the arm's closed form, where it has one, nearest to the seed first.
std::vector<std::vector<double>> collect_branches(const Question& question) {
  std::vector<std::vector<double>> out;
  const InverseKinematics arm(question.chain);
  if (!arm || question.options.orientation_free) return out;
  const std::size_t n = question.chain.joints();
  const auto add = [&](const IkSolution& one) {
    const std::span<const double> q(one.q.data(), n);
    const auto same = [&](const auto& other) { return largest_change(other, q) < kSameSolution; };
    if (out.size() < kMostSolutions && std::none_of(out.begin(), out.end(), same))
      out.emplace_back(q.begin(), q.end());
  };
  IkSolution nearest;
  if (!arm.complete() && arm.solve(question.target, question.seed, nearest) == IkOutcome::solved)
    add(nearest);
  const auto found = std::make_unique<IkSolutions>();
  arm.solve_all(question.target, question.seed, *found);
  for (const IkSolution& one : *found) add(one);
  return out;
}

std::vector<std::vector<double>> collect(const Question& question) {
  std::vector<std::vector<double>> out;
  if (question.out_of_bounds()) return out;
  out = collect_branches(question);
  if (!out.empty()) return out;
  const std::size_t n = question.chain.joints();
  JointState q = state_of(question.seed);
  Random random(2);
  for (int k = 0; k <= question.options.restarts && out.size() < kMostSolutions; ++k) {
    if (descend(question, q, question.seed, nullptr)) {
      const std::span<const double> found(q.data(), n);
      const auto same = [&](const auto& other) { return largest_change(other, found) < kSameSolution; };
      if (std::none_of(out.begin(), out.end(), same)) out.emplace_back(found.begin(), found.end());
    }
    q = state_of(question.seed);
    scatter(question.chain, q, random);
  }
  std::stable_sort(out.begin(), out.end(), [&](const auto& a, const auto& b) {
    return distance(a, question.seed) < distance(b, question.seed);
  });
  return out;
}

/// Of solutions sorted by distance from `current`: away from singularities before near them, then the
/// nearest; of those as near as the nearest, the one nearest home.
const std::vector<double>& choose(const Chain& chain, const std::vector<std::vector<double>>& found,
                                  std::span<const double> current, std::span<const double> home) {
  constexpr double kTie = 1e-6;
  const auto regular = [&](const auto& q) { return smallest_singular_value(chain, q) >= kSingular; };
  auto best = std::find_if(found.begin(), found.end(), regular);
  if (best == found.end()) best = found.begin();
  const double nearest = distance(*best, current);
  for (auto other = best + 1; other != found.end() && distance(*other, current) <= nearest + kTie; ++other)
    if (distance(*other, home) < distance(*best, home)) best = other;
  return *best;
}

using Square = std::array<std::array<double, 6>, 6>;

/// One rotation of Jacobi's method: makes a[p][q] zero.
void rotate(Square& a, std::size_t p, std::size_t q) {
  if (std::abs(a[p][q]) < 1e-300) return;
  const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[k][p], y = a[k][q];
    a[k][p] = c * x - s * y;
    a[k][q] = s * x + c * y;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[p][k], y = a[q][k];
    a[p][k] = c * x - s * y;
    a[q][k] = s * x + c * y;
  }
}

/// Of a symmetric matrix, by Jacobi's cyclic method (Golub and Van Loan, Matrix Computations, section 8.5).
double smallest_eigenvalue(Square a) {
  constexpr int kSweeps = 8;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t p = 0; p < 5; ++p)
      for (std::size_t q = p + 1; q < 6; ++q) rotate(a, p, q);
  double least = a[0][0];
  for (std::size_t i = 1; i < 6; ++i) least = std::min(least, a[i][i]);
  return least;
}

}  // namespace

const char* name(IkStatus status) {
  switch (status) {
    case IkStatus::solved:
      return "solved";
    case IkStatus::unreachable:
      return "unreachable";
    case IkStatus::limits:
      return "limits";
    case IkStatus::no_convergence:
      return "no_convergence";
  }
  return "";
}

IkResult solve_inverse(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options) {
  const Question question(chain, target, seed, options);
  return question.flaw.empty() ? search(question) : flawed(question);
}

std::vector<std::vector<double>> find_solutions(const Chain& chain, const Pose& target,
                                                std::span<const double> rank_from, const IkOptions& options) {
  const Question question(chain, target, rank_from, options);
  return question.flaw.empty() ? collect(question) : std::vector<std::vector<double>>{};
}

IkResult solve_nearest(const Chain& chain, const Pose& target, std::span<const double> current,
                       std::span<const double> home, const IkOptions& options) {
  const Question question(chain, target, current, options);
  if (!question.flaw.empty()) return flawed(question);
  JointState q = state_of(question.seed);
  if (!question.out_of_bounds() && descend(question, q, question.seed, nullptr)) {
    const std::span<const double> direct(q.data(), chain.joints());
    const double change = largest_change(direct, question.seed);
    if (change <= kSameBranch ||
        (change <= kNearby && smallest_singular_value(chain, direct) >= kVerySingular))
      return solved(question, direct);
  }
  const std::vector<std::vector<double>> found = collect(question);
  if (found.empty()) return search(question);
  const std::span<const double> rest =
      home.size() == chain.joints() ? home : std::span<const double>(question.seed);
  return solved(question, choose(chain, found, question.seed, rest));
}

double smallest_singular_value(const Chain& chain, std::span<const double> q) {
  const std::size_t n = chain.joints();
  std::array<double, 6 * Chain::kMaxJoints> jacobian;
  chain.jacobian(q, {jacobian.data(), 6 * n});
  const double length = std::isfinite(chain.reach()) && chain.reach() > 0 ? chain.reach() : 1.0;
  for (std::size_t k = 0; k < 3 * n; ++k) jacobian[k] /= length;
  std::array<std::size_t, Chain::kMaxJoints> columns;
  std::size_t used = 0;
  for (std::size_t k = 0; k < n; ++k)
    if (chain.moves_tcp(k)) columns[used++] = k;
  // The smaller of the two squares; of fewer than six joints filled up with values that are never the
  // smallest.
  Square square{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      double& cell = square[i][j];
      if (used >= 6) {
        for (std::size_t k = 0; k < used; ++k)
          cell += jacobian[i * n + columns[k]] * jacobian[j * n + columns[k]];
      } else if (i < used && j < used) {
        for (std::size_t k = 0; k < 6; ++k)
          cell += jacobian[k * n + columns[i]] * jacobian[k * n + columns[j]];
      } else if (i == j) {
        cell = 1e6;
      }
    }
  return used == 0 ? 0.0 : std::sqrt(std::max(0.0, smallest_eigenvalue(square)));
}

}  // namespace polyarm::kinematics
