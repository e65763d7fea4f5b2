#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/kinematics/descent.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kLooks = 30;  // seeds tried for each possible reason

std::string meters(double length) {
  return length < 1e5 ? fmt::format("{:.2f} m", length) : fmt::format("{:.3g} m", length);
}

/// The joint that is furthest outside its limits, as a sentence.
std::string limit_sentence(const Chain& chain, const JointState& q) {
  std::size_t worst = 0;
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (chain.moves_tcp(i) && excess(chain, q, i) > excess(chain, q, worst)) worst = i;
  const bool upper = q[worst] > chain.upper()[worst];
  const double limit = upper ? chain.upper()[worst] : chain.lower()[worst];
  return fmt::format("only with {} {:.3g} {} beyond its {} limit {:.4g}", chain.names()[worst],
                     excess(chain, q, worst), chain.slides(worst) ? "m" : "rad", upper ? "upper" : "lower",
                     limit);
}

/// Tries descents from the seed and from random states; `judge` sees every state a descent ended in.
template <typename Judge>
void look_around(const Chain& chain, const Pose& target, std::span<const double> seed,
                 const IkOptions& options, double weight, bool walls, Judge&& judge) {
  Random random(3);
  JointState q{};
  std::copy(seed.begin(), seed.end(), q.begin());
  for (int look = 0; look < kLooks; ++look) {
    Descent descent(chain, target, options, weight);
    const bool found = descent.run(q, walls);
    judge(descent, q, found);
    scatter(chain, q, random);
  }
}

/// Whether the pose could be had without limits; then the sentence names the joint in the way of the best
/// try.
bool blame_limits(const Chain& chain, const Pose& target, std::span<const double> seed,
                  const IkOptions& options, std::string& sentence) {
  double least = 1e300;
  const double weight = options.orientation_free ? 0.0 : options.orientation_weight;
  look_around(chain, target, seed, options, weight, false, [&](const Descent&, JointState q, bool found) {
    if (!found) return;
    unwind(chain, q, seed);
    double sum = 0;
    for (std::size_t i = 0; i < chain.joints(); ++i)
      if (chain.moves_tcp(i)) sum += excess(chain, q, i);
    if (sum >= least || sum <= 0) return;
    least = sum;
    sentence = limit_sentence(chain, q);
  });
  return least < 1e300;
}

/// Whether the place alone can be had; then the sentence tells by how much the orientation misses at the
/// least.
bool blame_orientation(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options, std::string& sentence) {
  constexpr double kLightly = 0.02, kSamePlace = 1e-3;
  double least = 1e300;
  look_around(chain, target, seed, options, kLightly, true,
              [&](const Descent& descent, const JointState&, bool) {
                if (descent.error().position < kSamePlace)
                  least = std::min(least, descent.error().orientation);
              });
  if (least > 1e299) {
    look_around(chain, target, seed, options, 0, true,
                [&](const Descent& descent, const JointState& q, bool found) {
                  const Pose there = chain.forward({q.data(), chain.joints()});
                  if (found) least = std::min(least, angle_between(there.rotation, target.rotation));
                  (void)descent;
                });
  }
  sentence =
      fmt::format("the orientation cannot be reached at that place: {:.1f} deg off at the nearest found",
                  kDegrees * least);
  return least < 1e299;
}

}  // namespace

void explain_failure(const Chain& chain, const Pose& target, std::span<const double> seed,
                     const IkOptions& options, IkResult& result) {
  result.status = IkStatus::unreachable;
  const double away = norm(target.position - chain.reach_center());
  if (away > chain.reach() + options.position_tolerance) {
    result.reason = fmt::format("the TCP would have to be {} from the base, this robot reaches {}",
                                meters(away), meters(chain.reach()));
    return;
  }
  if (blame_limits(chain, target, seed, options, result.reason)) {
    result.status = IkStatus::limits;
    return;
  }
  if (result.position_error < 1e-3 && (options.orientation_free || result.orientation_error < 1e-3)) {
    result.status = IkStatus::no_convergence;
    result.reason = fmt::format("the search came within {:.3g} mm and {:.3g} deg and no nearer",
                                1e3 * result.position_error, kDegrees * result.orientation_error);
    return;
  }
  if (!options.orientation_free && blame_orientation(chain, target, seed, options, result.reason)) return;
  result.reason =
      fmt::format("no joint state within limits brings the TCP nearer than {:.1f} mm to that place",
                  1e3 * result.position_error);
}

}  // namespace polyarm::kinematics
