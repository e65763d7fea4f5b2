#include "polyarm/ik/self_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polyarm::ik {

namespace {

constexpr int kDescentSteps = 4;  // need not converge
constexpr int kPatientSteps = 8;
constexpr double kSettled2 = 1e-10;                   // squared error: the rest is left to the polish
constexpr double kSpread = 0.15;                      // rad: distance between states spread over the curves
constexpr double kOnCurve2 = 1e-6;                    // squared error of a state on a curve
constexpr double kApart = 0.1;                        // rad: starts nearer to another one are dropped
constexpr double kNearCurve2 = 0.1;                   // squared error below which slides may begin
constexpr double kExact = 1e-11;                      // lengths and rad
constexpr double kShort = 1e-3;                       // rad: a shorter stride gains nothing
constexpr double kSame = 1e-3;                        // rad
constexpr double kHere = 0.15;                        // rad: no other is nearer than one this near
constexpr double kTimeout = 14, kLongTimeout = 40;  // steps of a slide
constexpr double kDoubtful = 0.3;  // fraction of all slides: if so many fail, the arm is near a singularity
constexpr double kFar = 1e4;       // rad: for seeds farther out sines lose digits
constexpr int kMostSteps = 400;
constexpr double kAsDeep =
    2;  // starts up to this multiple of the best start's squared distance are worth a slide
constexpr std::size_t kJoints = Slides::kJoints;
constexpr std::size_t kMostStarts = 448;

/// For limits that allow a whole turn.
double nearest_turn(double value, double near, double lower, double upper) noexcept {
  constexpr double kTurn = 2 * std::numbers::pi, kShift = 6755399441055744.0;  // as rounded() of lanes.hpp
  value += kTurn * (((near - value) * (1 / kTurn) + kShift) - kShift);
  while (value < lower) value += kTurn;
  while (value > upper) value -= kTurn;
  return value;
}

}  // namespace

struct SelfMotion::Question {
  NumericQuestion numeric;
  SeedTable::Search search;
  std::array<double, kJoints> seed;
};
struct SelfMotion::Start {
  std::array<double, kJoints> x;
  double cost;
  double size2 = 0;  ///< of the error

  double far_from(const Start& other) const noexcept {
    double most = 0;
    for (std::size_t k = 0; k < kJoints; ++k) most = std::max(most, std::abs(x[k] - other.x[k]));
    return most;
  }
};
struct SelfMotion::States {
  std::array<Start, kStateGroups> all;
  std::array<std::uint8_t, kStateGroups> order;  ///< best first
};
struct SelfMotion::Starts {
  std::array<Start, kMostStarts> all;
  std::array<const Start*, kMostStarts> order;
  std::size_t count = 0;

  void drop_off_curve(double size2) noexcept {
    const auto off = [&](const Start& one) { return one.size2 > size2; };
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(count);
    count = static_cast<std::size_t>(std::remove_if(all.begin(), end, off) - all.begin());
  }
  /// The nearest to the seed, each at a distance from the previous ones.
  std::span<const Start* const> apart(double distance, std::size_t most) noexcept {
    for (std::size_t k = 0; k < count; ++k) order[k] = &all[k];
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
              [](const Start* a, const Start* b) { return a->cost < b->cost; });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < count && kept < most; ++k) {
      const Start& one = *order[k];
      const auto beside = [&](const Start* other) { return one.far_from(*other) < distance; };
      if (std::none_of(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), beside))
        order[kept++] = &one;
    }
    return {order.data(), kept};
  }
};
struct SelfMotion::Found {
  std::array<Start, kMost> all;
  std::size_t count = 0;
  std::size_t lost = 0;                               ///< slides that failed
  std::array<const Start*, 2 * kDescents> lost_from;  ///< where the first failed slides began

  /// Nearest first, without duplicates.
  void take(const Start& one) noexcept {
    for (std::size_t k = 0; k < count; ++k)
      if (one.far_from(all[k]) < kSame) return;
    if (count == kMost && one.cost >= all[kMost - 1].cost) return;
    std::size_t at = count < kMost ? count++ : kMost - 1;
    for (; at > 0 && one.cost < all[at - 1].cost; --at) all[at] = all[at - 1];
    all[at] = one;
  }
};

std::optional<SelfMotion> SelfMotion::of(const NumericCore& core, const ArmGeometry& arm,
                                         const LaneLimits& limits, bool thorough, bool only_slides) {
  if (arm.count != kJoints || core.arm.joints != kJoints || !core.arm.single.possible ||
      core.arm.single.slides || core.table.size() % kStateGroups != 0)
    return std::nullopt;
  SelfMotion out;
  out.core_ = &core;
  if (thorough) {
    out.factors_ = {3, 20};
    out.descents_ = 64;
    out.slides_ = 48;
  } else {
    out.factors_ = {8};
    out.descents_ = 39;
    out.slides_ = 20;
  }
  for (std::size_t k = 0; k < kJoints; ++k) {
    if (core.arm.chain_joint[k] != arm.axes[k].joint) return std::nullopt;
    out.lower_[k] = std::max(-1e9, limits.lower[k]);
    out.upper_[k] = std::min(1e9, limits.upper[k]);
    out.weight_[k] = limits.weight[k];
    out.turns_[k] = out.upper_[k] - out.lower_[k] >= 2 * std::numbers::pi;
  }
  if (only_slides) return out;
  const std::size_t size = core.table.size();
  out.values_ = std::make_unique_for_overwrite<float[]>(kJoints * size);
  for (std::size_t row = 0; row < size; row += kDescents)
    for (std::size_t k = 0; k < kJoints; ++k) {
      const double* const from = core.table.eight_values(row, k);
      for (std::size_t lane = 0; lane < kDescents; ++lane)
        out.values_[k * size + row + lane] = static_cast<float>(from[lane]);
    }
  return out;
}

bool SelfMotion::read(const Pose& target, std::span<const double> seed, Question& out) const noexcept {
  if (!core_->read(target, nullptr, seed, out.numeric)) return false;
  for (std::size_t k = 0; k < kJoints; ++k) {
    out.seed[k] = seed[core_->arm.chain_joint[k]];
    if (std::abs(out.seed[k]) > kFar) return false;
  }
  return true;
}

double SelfMotion::distance2(const Question& question, const double* x) const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < kJoints; ++k) {
    const double away = x[k] - question.seed[k];
    sum += weight_[k] * away * away;
  }
  return sum;
}

/// Moves each joint to the turn within limits that is nearest to the seed.
void SelfMotion::unwind(const Question& question, double* x) const noexcept {
  for (std::size_t k = 0; k < kJoints; ++k) {
    if (turns_[k]) x[k] = nearest_turn(x[k], question.seed[k], lower_[k], upper_[k]);
    x[k] = std::clamp(x[k], lower_[k], upper_[k]);
  }
}

/// Does some steps from the states in `all`; states that come near a curve become starts.
void SelfMotion::descend_from(const Question& question, int steps, Descents& all,
                              Starts& out) const noexcept {
  DescentRules rules = core_->rules;
  rules.steps = steps;
  rules.patience = 1e9;
  rules.position2 = rules.orientation2 = -1;
  descend(core_->arm, rules, nullptr, all);
  for (std::size_t lane = 0; lane < kDescents && out.count < kMostStarts; ++lane) {
    if (!(all.position2[lane] + all.orientation2[lane] < kNearCurve2)) continue;
    Start& one = out.all[out.count++];
    for (std::size_t k = 0; k < kJoints; ++k) one.x[k] = all.x[k][lane];
    unwind(question, one.x.data());
    one.cost = distance2(question, one.x.data());
    one.size2 = all.position2[lane] + all.orientation2[lane];
  }
}

/// The table states nearest to the seed, considering the distance of their ends from the target.
void SelfMotion::find_near(const Question& question, const StatesWanted& wanted, std::size_t most,
                           States& out) const noexcept {
  StatesNear near;
  find_states(core_->table.places(), values_.get(), wanted, near);
  for (std::size_t i = 0; i < kStateGroups; ++i) {
    std::array<double, Chain::kMaxJoints> x;
    core_->table.read(question.search, static_cast<std::size_t>(near.row[i]), x.data());
    unwind(question, x.data());
    std::copy_n(x.begin(), kJoints, out.all[i].x.begin());
    out.all[i].cost = near.cost[i];
    // The pose determines the first and the last joint.
    for (const std::size_t k : {std::size_t{0}, kJoints - 1})
      if (k < wanted.first || k >= wanted.first + wanted.joints)
        out.all[i].cost += weight_[k] * (x[k] - question.seed[k]) * (x[k] - question.seed[k]);
    out.order[i] = static_cast<std::uint8_t>(i);
  }
  std::nth_element(out.order.begin(), out.order.begin() + static_cast<std::ptrdiff_t>(most) - 1,
                   out.order.end(), [&](auto a, auto b) { return out.all[a].cost < out.all[b].cost; });
}

/// Starts from the seed, and from table states near the seed whose end is near the target.
void SelfMotion::start_near_seed(const Question& question, std::size_t descents, int steps,
                                 Starts& out) const noexcept {
  StatesWanted wanted;
  wanted.place = question.search.at;
  const SeedTable& table = core_->table;
  wanted.first = table.first_turns() ? 1 : 0;
  wanted.joints = kJoints - wanted.first - (table.last_turns() ? 1 : 0);
  for (std::size_t k = 0; k < kJoints; ++k) {
    wanted.seed[k] = static_cast<float>(question.seed[k]);
    wanted.weight[k] = static_cast<float>(weight_[k]);
    wanted.period[k] = turns_[k] ? static_cast<float>(2 * std::numbers::pi) : 0.0f;
    wanted.over_period[k] = turns_[k] ? static_cast<float>(0.5 / std::numbers::pi) : 0.0f;
  }
  Descents all;
  core_->set_targets(question.numeric, all);
  core_->set_state(question.numeric.seed.data(), 0, all);
  std::size_t lane = 1;
  for (const double factor : factors_) {
    wanted.place_weight = static_cast<float>(factor);
    States states;
    find_near(question, wanted, descents, states);
    for (std::size_t i = 0; i < descents; ++i) {
      core_->set_state(states.all[states.order[i]].x.data(), lane, all);
      if (++lane < kDescents) continue;
      descend_from(question, steps, all, out);
      lane = 0;
    }
  }
}

/// Starts from the states whose ends are nearest to the target, independent of the seed, with more steps.
void SelfMotion::start_anywhere(const Question& question, std::size_t enough, Starts& out) const noexcept {
  SeedTable::Search search = question.search;
  Descents all;
  core_->set_targets(question.numeric, all);
  while (out.count + kDescents <= enough && search.rounds < 12) {
    for (std::size_t lane = 0; lane < kDescents; ++lane) core_->restart(search, lane, all);
    descend_from(question, kPatientSteps, all, out);
  }
}

/// Slides from all starts, eight at work at a time.
void SelfMotion::slide_from(const Question& question, std::span<const Start* const> starts, double patience,
                            Found& out) const noexcept {
  if (starts.empty()) return;
  Slides all;
  SlideRules rules;
  rules.lower = lower_;
  rules.upper = upper_;
  rules.weight = weight_;
  rules.seed = question.seed;
  rules.size2 = kExact * kExact;
  rules.stride = kShort;
  rules.patience = patience;
  for (std::size_t i = 0; i < question.numeric.target.size(); ++i)
    std::fill_n(all.target[i], kDescents, question.numeric.target[i]);
  if (out.count > 0) rules.best = out.all[0].cost;
  std::size_t next = 0;
  all.working = 0;
  std::array<const Start*, kDescents> at{};
  const auto begin = [&](std::size_t lane) {
    const bool more = next < starts.size();
    const Start& from = *starts[more ? next : 0];
    for (std::size_t k = 0; k < kJoints; ++k) {
      all.x[k][lane] = from.x[k];
      // Any direction that is seldom perpendicular to the curve.
      all.along[k][lane] = weight_[k] * (rules.seed[k] - from.x[k]) + 1e-3 * static_cast<double>(k + 1);
    }
    at[lane] = &from;
    all.restart(lane);
    all.working = more ? all.working | 1u << lane : all.working & ~(1u << lane);
    next += more;
  };
  for (std::size_t lane = 0; lane < kDescents; ++lane) begin(lane);
  rules.steps = kMostSteps;
  while (all.working != 0 && rules.steps > 0) {
    rules.steps -= slide(core_->arm, rules, all);
    for (std::size_t lane = 0; lane < kDescents; ++lane) {
      if (!(all.done >> lane & 1)) continue;
      if ((all.settled >> lane & 1) && all.size2[lane] <= rules.size2) {
        Start one;
        for (std::size_t k = 0; k < kJoints; ++k) one.x[k] = all.x[k][lane];
        one.cost = distance2(question, one.x.data());
        out.take(one);
        rules.best = out.all[0].cost;
      } else if (all.settled >> lane & 1) {
        if (out.lost < out.lost_from.size()) out.lost_from[out.lost] = at[lane];
        ++out.lost;
      }
      begin(lane);
    }
  }
}

/// Slides fail near singularities: tries where their starts lead without sliding, if that is nearer than the
/// solutions found. Unused lanes hold the seed.
void SelfMotion::settle_lost(const Question& question, Found& out) const noexcept {
  const std::size_t count = std::min(out.lost, out.lost_from.size());
  Starts settled;
  Descents all;
  core_->set_targets(question.numeric, all);
  core_->set_states(question.numeric.seed.data(), all);
  std::size_t lane = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Start& from = *out.lost_from[i];
    if (out.count > 0 && from.cost >= out.all[0].cost) continue;
    core_->set_state(from.x.data(), lane, all);
    if (++lane < kDescents) continue;
    descend_from(question, kPatientSteps, all, settled);
    lane = 0;
  }
  if (lane > 0) descend_from(question, kPatientSteps, all, settled);
  for (std::size_t i = 0; i < settled.count; ++i)
    if (settled.all[i].size2 < kSettled2) out.take(settled.all[i]);
}

/// The largest difference of any joint from the seed.
double SelfMotion::away_from(const Question& question, const Start& one) noexcept {
  double most = 0;
  for (std::size_t k = 0; k < kJoints; ++k) most = std::max(most, std::abs(one.x[k] - question.seed[k]));
  return most;
}

/// The nearest point of the nearest curve, if it is so near to the seed that no other can be nearer.
bool SelfMotion::search_from_here(const Question& question, Found& out) const noexcept {
  constexpr double kFine2 = 1e-4 * 1e-4;
  constexpr int kFewSteps = 4;
  NumericPlace at;
  if (!core_->follow_alone(question.numeric, question.numeric.seed.data(), kFine2, kFine2, kFewSteps, at))
    return false;
  Start one;
  std::copy_n(at.x.begin(), kJoints, one.x.begin());
  unwind(question, one.x.data());
  // Sliding shortens the distance of the descent only a little.
  if (away_from(question, one) > 2 * kHere) return false;
  const Start* const start = &one;
  slide_from(question, {&start, 1}, kTimeout, out);
  return out.count > 0 && away_from(question, out.all[0]) < kHere;
}

std::size_t SelfMotion::nearest(const Pose& target, std::span<const double> seed, std::span<State, kMost> out,
                                bool& doubtful) const noexcept {
  Question question;
  doubtful = false;
  if (!read(target, seed, question)) return 0;
  Found found;
  if (!search_from_here(question, found)) {
    core_->begin_search(question.numeric, question.search);
    Starts starts;
    start_near_seed(question, descents_, kDescentSteps, starts);
    found.lost = 0;
    const std::span<const Start* const> from = starts.apart(kApart, slides_);
    slide_from(question, from, kTimeout, found);
    settle_lost(question, found);
    doubtful = static_cast<double>(found.lost) >= kDoubtful * static_cast<double>(from.size());
    if (found.count == 0) {
      start_anywhere(question, kMostStarts, starts);
      slide_from(question, starts.apart(kApart, kMostStarts), kLongTimeout, found);
    }
  }
  for (std::size_t j = 0; j < found.count; ++j)
    std::copy(found.all[j].x.begin(), found.all[j].x.end(), out[j].begin());
  return found.count;
}

bool SelfMotion::nearest_here(const Pose& target, std::span<const double> seed, State& out) const noexcept {
  Question question;
  Found found;
  if (!read(target, seed, question) || !search_from_here(question, found)) return false;
  std::copy(found.all[0].x.begin(), found.all[0].x.end(), out.begin());
  return true;
}

bool SelfMotion::nearest_from(const Pose& target, std::span<const double> seed, std::span<const State> starts,
                              State& out) const noexcept {
  Question question;
  if (!read(target, seed, question)) return false;
  std::array<Start, kDescents> all;
  std::array<const Start*, kDescents> from;
  const std::size_t count = std::min(starts.size(), kDescents);
  for (std::size_t k = 0; k < count; ++k) {
    std::copy_n(starts[k].begin(), kJoints, all[k].x.begin());
    unwind(question, all[k].x.data());
    all[k].cost = distance2(question, all[k].x.data());
    from[k] = &all[k];
  }
  Found found;
  // Starts are solutions too: slides that promise no improvement end early.
  for (std::size_t k = 0; k < count; ++k) found.take(all[k]);
  std::size_t worth = 0;
  while (worth < count && all[worth].cost <= kAsDeep * all[0].cost) ++worth;
  slide_from(question, {from.data(), worth}, kTimeout, found);
  if (found.count == 0) {
    constexpr std::size_t kEnough = 8;
    core_->begin_search(question.numeric, question.search);
    Starts anywhere;
    start_anywhere(question, kEnough, anywhere);
    slide_from(question, anywhere.apart(kApart, kEnough), kLongTimeout, found);
  }
  if (found.count == 0) return false;
  std::copy(found.all[0].x.begin(), found.all[0].x.end(), out.begin());
  return true;
}

std::size_t SelfMotion::spread(const Pose& target, std::span<const double> seed,
                               std::span<State> out) const noexcept {
  Question question;
  if (!read(target, seed, question)) return 0;
  core_->begin_search(question.numeric, question.search);
  Starts starts;
  start_near_seed(question, kStateGroups - 1, kPatientSteps, starts);
  start_anywhere(question, kMostStarts, starts);
  starts.drop_off_curve(kOnCurve2);
  const std::span<const Start* const> found = starts.apart(kSpread, out.size());
  for (std::size_t j = 0; j < found.size(); ++j)
    std::copy(found[j]->x.begin(), found[j]->x.end(), out[j].begin());
  return found.size();
}

}  // namespace polyarm::ik
