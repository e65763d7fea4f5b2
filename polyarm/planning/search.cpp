#include "polyarm/planning/search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polyarm::planning {

namespace {

/// A state whose edges were blocked takes only targets nearer than this, in ranges; a little less after each
/// failure.
constexpr double kFirstDomain = 4, kDomainShrinks = 1e-4, kLeastDomain = 1;
constexpr double kWideTurn =
    std::numbers::pi;                   // samples of joints with many turns: so far beyond start and goals
constexpr double kUnlimitedSlide = 1;   // m
constexpr std::size_t kStopEvery = 32;  // samples between questions to `stop`
constexpr double kArrived = 1e-9;

}  // namespace

SearchTree::SearchTree(const collision::Checker& checker, std::span<const double> weights)
    : width_(checker.variables()), set_(checker, weights) {}

std::size_t SearchTree::add(std::span<const double> q, std::size_t parent) {
  set_.add(q);
  states_.insert(states_.end(), q.begin(), q.end());
  parents_.push_back(parent);
  domains_.push_back(INFINITY);
  return parents_.size() - 1;
}

std::vector<JointState> SearchTree::way_to_root(std::size_t i) const {
  std::vector<JointState> out;
  for (; i != kRoot; i = parents_[i]) out.emplace_back(state(i).begin(), state(i).end());
  return out;
}

std::size_t SearchTree::root_of(std::size_t i) const {
  while (parents_[i] != kRoot) i = parents_[i];
  return i;
}

Search::Search(collision::Probe& probe, const PlanQuery& query, const PlanOptions& options, bool exact)
    : probe_(probe),
      query_(query),
      options_(options),
      exact_(exact),
      weights_(options.weights),
      random_(options.seed),
      next_(query.start.size()) {
  if (weights_.empty()) weights_.assign(query.start.size(), 1);
}

double Search::length(std::span<const double> a, std::span<const double> b) const noexcept {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) {
    const double d = weights_[j] * (b[j] - a[j]);
    sum += d * d;
  }
  return std::sqrt(sum);
}

double Search::length(const std::vector<JointState>& path) const noexcept {
  double out = 0;
  for (std::size_t i = 1; i < path.size(); ++i) out += length(path[i - 1], path[i]);
  return out;
}

bool Search::free(std::span<const double> from, std::span<const double> to) {
  ++edges_;
  collision::EdgeOptions options;
  options.exact = exact_;
  return probe_.edge(from, to, options).verdict == collision::EdgeVerdict::free;
}

/// Straight to the nearest goals first.
bool Search::straight(std::span<const std::size_t> goals, Plan& out) {
  std::vector<std::size_t> order(goals.begin(), goals.end());
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return length(query_.start, query_.goals[a]) < length(query_.start, query_.goals[b]);
  });
  for (const std::size_t goal : order)
    if (free(query_.start, query_.goals[goal])) {
      out.goal = goal;
      out.waypoints = {query_.start, query_.goals[goal]};
      return true;
    }
  return false;
}

void Search::find_box(std::span<const std::size_t> goals) {
  low_ = high_ = query_.start;
  for (const std::size_t goal : goals)
    for (std::size_t j = 0; j < low_.size(); ++j) {
      low_[j] = std::min(low_[j], query_.goals[goal][j]);
      high_[j] = std::max(high_[j], query_.goals[goal][j]);
    }
  std::vector<bool> slides(low_.size(), false);
  for (const collision::JointFrame& frame : probe_.checker().robot().frames())
    if (frame.slides) slides[frame.variable] = true;
  for (std::size_t j = 0; j < low_.size(); ++j) {
    const double beyond = slides[j] ? kUnlimitedSlide : kWideTurn;
    const bool wide = !(query_.upper[j] - query_.lower[j] <= 2 * kWideTurn);
    low_[j] = wide ? std::max(query_.lower[j], low_[j] - beyond) : query_.lower[j];
    high_[j] = wide ? std::min(query_.upper[j], high_[j] + beyond) : query_.upper[j];
  }
}

void Search::draw(JointState& q) {
  for (std::size_t j = 0; j < q.size(); ++j) q[j] = random_.between(low_[j], high_[j]);
}

std::optional<std::size_t> Search::extend(SearchTree& tree, std::span<const double> target) {
  const std::size_t near = tree.nearest(target);
  const std::span<const double> from = tree.state(near);
  const double way = length(from, target);
  if (way > tree.domain(near) * options_.range || way < kArrived) return std::nullopt;
  const double part = std::min(1.0, options_.range / way);
  for (std::size_t j = 0; j < next_.size(); ++j)
    next_[j] = part < 1 ? from[j] + part * (target[j] - from[j]) : target[j];
  if (!free(from, next_)) {
    double& domain = tree.domain(near);
    domain = std::isinf(domain) ? kFirstDomain : std::max(kLeastDomain, domain * (1 - kDomainShrinks));
    return std::nullopt;
  }
  return tree.add(next_, near);
}

std::optional<std::size_t> Search::connect(SearchTree& tree, std::span<const double> target) {
  std::size_t at = tree.nearest(target);
  for (;;) {
    const std::span<const double> from = tree.state(at);
    const double way = length(from, target);
    if (way < kArrived) return at;
    const double part = std::min(1.0, options_.range / way);
    for (std::size_t j = 0; j < next_.size(); ++j)
      next_[j] = part < 1 ? from[j] + part * (target[j] - from[j]) : target[j];
    if (!free(from, next_)) return std::nullopt;
    at = tree.add(next_, at);
    if (part >= 1) return at;
  }
}

void Search::join(const SearchTree& a, std::size_t i, const SearchTree& b, std::size_t k, bool a_is_start,
                  Plan& out) const {
  std::vector<JointState> first = a.way_to_root(i), second = b.way_to_root(k);
  if (!a_is_start) std::swap(first, second);
  std::reverse(first.begin(), first.end());
  first.insert(first.end(), second.begin() + 1, second.end());
  out.waypoints = std::move(first);
}

PlanOutcome Search::run(std::span<const std::size_t> goals, std::size_t most_samples, Plan& out) {
  if (straight(goals, out)) return out.edges += edges_, PlanOutcome::found;
  find_box(goals);
  SearchTree start(probe_.checker(), weights_), goal(probe_.checker(), weights_);
  start.add(query_.start, SearchTree::kRoot);
  for (const std::size_t g : goals) goal.add(query_.goals[g], SearchTree::kRoot);
  SearchTree *grows = &start, *other = &goal;
  JointState sample(query_.start.size());
  PlanOutcome outcome = PlanOutcome::out_of_samples;
  std::size_t tries = 0;
  for (; tries < most_samples && start.size() + goal.size() < options_.most_states; ++tries) {
    if (options_.stop && tries % kStopEvery == 0 && options_.stop()) {
      outcome = PlanOutcome::out_of_time;
      break;
    }
    if (grows->size() > other->size()) std::swap(grows, other);
    draw(sample);
    const auto added = extend(*grows, sample);
    if (!added) {
      std::swap(grows, other);
      continue;
    }
    const JointState target(grows->state(*added).begin(), grows->state(*added).end());
    const auto met = connect(*other, target);
    if (!met) continue;
    const bool grows_start = grows == &start;
    join(*grows, *added, *other, *met, grows_start, out);
    out.goal = goals[goal.root_of(grows_start ? *met : *added)];
    outcome = PlanOutcome::found;
    ++tries;
    break;
  }
  out.samples += tries;
  out.states += start.size() + goal.size();
  out.edges += edges_;
  return outcome;
}

/// Leaves out every corner that a straight line can pass. True if there was one.
bool Search::skip_corners(std::vector<JointState>& path) {
  bool out = false;
  for (std::size_t i = 0; i + 2 < path.size(); ++i)
    for (std::size_t k = path.size() - 1; k > i + 1; --k)
      if (free(path[i], path[k])) {
        path.erase(path.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                   path.begin() + static_cast<std::ptrdiff_t>(k));
        out = true;
        break;
      }
  return out;
}

namespace {

struct Place {
  std::size_t edge = 0;
  JointState q;
};

}  // namespace

/// Joins two random places of the path. True if it is shorter now.
bool Search::cut_between(std::vector<JointState>& path) {
  const double whole = length(path);
  const auto at = [&](double way) {
    Place out;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const double own = length(path[i], path[i + 1]);
      out.edge = i;
      if (way <= own || i + 2 == path.size()) {
        const double part = own > 0 ? std::min(1.0, way / own) : 0;
        out.q = path[i];
        for (std::size_t j = 0; j < out.q.size(); ++j) out.q[j] += part * (path[i + 1][j] - path[i][j]);
        return out;
      }
      way -= own;
    }
    return out;
  };
  double first = random_.between(0, whole), second = random_.between(0, whole);
  if (first > second) std::swap(first, second);
  const Place a = at(first), b = at(second);
  if (a.edge == b.edge || length(a.q, b.q) > (second - first) * (1 - 1e-3)) return false;
  if (!free(a.q, b.q)) return false;
  std::vector<JointState> out(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(a.edge) + 1);
  out.push_back(a.q);
  out.push_back(b.q);
  out.insert(out.end(), path.begin() + static_cast<std::ptrdiff_t>(b.edge) + 1, path.end());
  path = std::move(out);
  return true;
}

void Search::shorten(Plan& out) {
  out.length_found = length(out.waypoints);
  edges_ = 0;
  if (options_.shortcuts > 0 && out.waypoints.size() > 2) {
    skip_corners(out.waypoints);
    std::size_t failed = 0;
    for (std::size_t i = 0;
         i < options_.shortcuts && out.waypoints.size() > 2 && failed < options_.shortcuts / 3; ++i)
      failed = cut_between(out.waypoints) ? 0 : failed + 1;
    skip_corners(out.waypoints);
  }
  out.length = length(out.waypoints);
  out.edges += edges_;
}

}  // namespace polyarm::planning
