#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/descent/unwind.hpp"
#include "polyarm/ik/moves.hpp"

namespace polyarm::ik {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kLooks = 48;        // descents for each possible reason
constexpr int kSettleSteps = 40;  // steps to the minimum, for the nearest state

std::string meters(double length) {
  return length < 1e5 ? fmt::format("{:.2f} m", length) : fmt::format("{:.3g} m", length);
}

/// The same question with another weight of orientation, rad per rad or length.
NumericQuestion weighed(const NumericQuestion& question, double weight) {
  NumericQuestion out = question;
  if (!out.task) out.task.emplace();
  for (const std::size_t row : {3, 4, 5}) out.task->weight[row] = weight;
  return out;
}

bool all_turns_free(const NumericQuestion& question) {
  bool out = question.task.has_value();
  for (std::size_t i = 3; out && i < 6; ++i)
    out = question.task->low[i] < -1e8 && question.task->high[i] > 1e8;
  return out;
}

/// The best of many descents, followed to its minimum. `size2` rates a place.
template <typename Size>
NumericPlace best_of(const NumericCore& core, const NumericQuestion& question, const Size& size2) {
  NumericCore::Places found;
  for (NumericPlace& one : found) one.x = question.seed;
  std::size_t seen = 0;
  core.find_obstacles(question, kLooks, [&](const NumericPlace& at) {
    NumericPlace& slot = found[seen++ % found.size()];
    if (size2(at) < size2(slot)) slot = at;
  });
  core.settle(question, kSettleSteps, found);
  return *std::min_element(found.begin(), found.end(),
                           [&](const NumericPlace& a, const NumericPlace& b) { return size2(a) < size2(b); });
}

/// The joint that is furthest outside its limits, as a sentence.
std::string limit_sentence(const Chain& chain, const IkSolution& at) {
  std::size_t worst = 0;
  const auto over = [&](std::size_t i) { return chain.moves_tcp(i) ? excess(chain, i, at.q[i]) : 0.0; };
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (over(i) > over(worst)) worst = i;
  const bool upper = at.q[worst] > chain.upper()[worst];
  const double limit = upper ? chain.upper()[worst] : chain.lower()[worst];
  return fmt::format("only with {} {:.3g} {} beyond its {} limit {:.4g}", chain.names()[worst], over(worst),
                     chain.slides(worst) ? "m" : "rad", upper ? "upper" : "lower", limit);
}

/// True if the pose is reachable without limits; `sentence` then names the joint that blocks the best
/// attempt.
bool blame_limits(const NumericCore& core, NumericQuestion question, std::span<const double> seed,
                  std::string& sentence) {
  double least = 1e300;
  question.walls = false;
  core.find_obstacles(question, kLooks, [&](NumericPlace at) {
    if (!core.good(at)) return;
    core.polish(question, at);
    IkSolution one;
    core.write(at, seed, one);
    double sum = 0;
    for (std::size_t i = 0; i < core.chain.joints(); ++i)
      if (core.chain.moves_tcp(i)) sum += excess(core.chain, i, one.q[i]);
    if (sum >= least || sum <= 0) return;
    least = sum;
    sentence = limit_sentence(core.chain, one);
  });
  return least < 1e300;
}

/// True if the position alone is reachable; `sentence` then gives the smallest orientation error.
bool blame_orientation(const NumericCore& core, const NumericQuestion& question, std::string& sentence) {
  constexpr double kLightly = 0.03, kSamePlace = 1e-3;
  double least = 1e300;
  const auto look = [&](double weight) {
    const NumericPlace best = best_of(core, weighed(question, weight), [&](const NumericPlace& at) {
      return at.position2 + kLightly * kLightly * at.orientation2;
    });
    if (core.arm.length * std::sqrt(best.position2) < kSamePlace)
      least = 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(best.orientation2)));
  };
  look(kLightly);
  if (least > 1e299) look(0);
  sentence =
      fmt::format("the orientation cannot be reached at that place: {:.1f} deg off at the nearest found",
                  kDegrees * least);
  return least < 1e299;
}

/// The nearest joint state; a radian counts like a metre.
IkSolution find_nearest(const NumericCore& core, const DescentQuestion& question, bool orientation_free) {
  const double weight = orientation_free ? 0.0 : 1.0;
  const NumericPlace best =
      best_of(core, weighed(question.inner, weight / core.arm.length), [&](const NumericPlace& at) {
        return core.arm.length * core.arm.length * at.position2 + weight * weight * at.orientation2;
      });
  IkSolution out;
  core.write(best, question.seed(), out);
  if (question.inner.task && !orientation_free) return out;
  const Pose there = core.chain.forward({out.q.data(), question.joints});
  out.position_error = norm(question.target.position - there.position);
  out.orientation_error = orientation_free ? 0.0 : angle_between(there.rotation, question.target.rotation);
  return out;
}

}  // namespace

IkExplanation explain_failure(const NumericCore& core, const DescentQuestion& question) {
  const Chain& chain = core.chain;
  const bool turn_is_free = all_turns_free(question.inner);
  IkExplanation out;
  out.outcome = IkOutcome::unreachable;
  out.nearest = find_nearest(core, question, place_is_fixed(question.inner) && turn_is_free);
  const IkSolution& at = out.nearest;
  const double away = norm(question.target.position - chain.reach_center());
  if (place_is_fixed(question.inner) && away > chain.reach() + core.settings.position_tolerance) {
    out.reason = fmt::format("the TCP would have to be {} from the base, this robot reaches {}", meters(away),
                             meters(chain.reach()));
    return out;
  }
  if (blame_limits(core, question.inner, question.seed(), out.reason)) {
    out.outcome = IkOutcome::limits;
    return out;
  }
  if (at.position_error < 1e-3 && at.orientation_error < 1e-3) {
    out.reason = fmt::format("the search came within {:.3g} mm and {:.3g} deg and no nearer",
                             1e3 * at.position_error, kDegrees * at.orientation_error);
    return out;
  }
  if (!turn_is_free && blame_orientation(core, question.inner, out.reason)) return out;
  const bool place_is_free = at.position_error == 0 && question.inner.task;
  out.reason =
      place_is_free
          ? fmt::format(
                "no joint state within limits turns the tool nearer than {:.1f} deg to that direction",
                kDegrees * at.orientation_error)
          : fmt::format("no joint state within limits brings the TCP nearer than {:.1f} mm to that place",
                        1e3 * at.position_error);
  return out;
}

}  // namespace polyarm::ik
