#include "polyarm/moves/move_joins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "polyarm/paths/hermite.hpp"
#include "polyarm/paths/polynomial_path.hpp"

namespace polyarm::moves {

using paths::Jet;
using paths::Path;
using paths::PolynomialPath;

namespace {

using Values = std::vector<double>;
constexpr int kBisections = 30;  // to find the place on a path at distance `radius` from its end
constexpr int kSamples = 32;     // places of a join at which the distance at the TCP is checked
constexpr double kLess = 0.8;    // factor for the next attempt after a join that is too wide
constexpr int kTries = 40;
constexpr double kStandsStill = 0.03;  // of the derivative at the start of a join: below it the join reverses

class Joins {
 public:
  Joins(const PlanRequest& request, std::vector<MovePlan::Warning>& warnings)
      : r_(request), warnings_(warnings) {}

  bool run(MoveDraft& draft, MovePart& b) {
    MovePart& a = draft.back();
    const MoveSpan &before = a.moves.back(), &behind = b.moves.front();
    const Move& move = r_.moves[before.move];
    const double radius = move.blend * (1 - 1.0 / (kSamples * kSamples));
    const Values corner = joints_at(*a.joints, a.to);
    const double most_a = (std::min(before.to, a.to) - std::max(before.from, a.from)) / 2;
    const double most_b = (std::min(behind.to, b.to) - behind.from) / 2;
    double da = away(a, true, radius, most_a), db = away(b, false, radius, most_b);
    bool wide = false;
    for (int k = 0;; ++k, da *= kLess, db *= kLess, wide = true) {
      if (k == kTries || !(da > 0) || !(db > 0)) {
        warn(before.move, 0, "there is no room for it");
        return false;
      }
      const Ends ends = ends_of(a, b, da, db);
      if (!std::isfinite(ends.scale) || !(ends.scale > 0)) continue;
      const auto path = joining_path(ends);
      if (!stays(*path, corner, radius)) continue;
      const double reached = std::max(r_.distance(joints_at(*a.joints, a.to - da), corner),
                                      r_.distance(joints_at(*b.joints, b.from + db), corner));
      if (reached < 0.98 * radius)
        warn(before.move, reached,
             wide ? "the curve would leave the ball of that radius" : "half of a move beside it");
      MovePart middle{path,
                      nullptr,
                      nullptr,
                      0,
                      path->length(),
                      a.scale,
                      {{0, path->length(), before.move}, {0, path->length(), behind.move}}};
      give_tcp(r_, middle, true);
      a.to -= da;
      b.from += db;
      b.scale = a.scale * ends.scale;
      middle.joins = true;
      draft.push_back(std::move(middle));
      return true;
    }
  }

 private:
  /// The length before the end, or after the start, of a part at which the distance is `radius`; at most
  /// `most`.
  double away(const MovePart& part, bool before, double radius, double most) const {
    const Values corner = joints_at(*part.joints, before ? part.to : part.from);
    const auto far = [&](double d) {
      return r_.distance(joints_at(*part.joints, before ? part.to - d : part.from + d), corner);
    };
    if (far(most) <= radius) return most;
    double low = 0, high = most;
    for (int k = 0; k < kBisections; ++k) {
      const double middle = (low + high) / 2;
      (far(middle) <= radius ? low : high) = middle;
    }
    return low;
  }

  struct Ends {
    std::vector<Jet<double>> before, behind;
    double scale, length;
  };
  Ends ends_of(const MovePart& a, const MovePart& b, double da, double db) const {
    const std::size_t n = r_.robot.chain.joints();
    const auto jets = [&](const Path& path, double s) {
      std::vector<double> q(n), first(n), second(n), third(n);
      path.at(s, {q, first, second, third});
      std::vector<Jet<double>> out(n);
      for (std::size_t j = 0; j < n; ++j) out[j] = {q[j], first[j], second[j], third[j]};
      return out;
    };
    const auto rate = [](const std::vector<Jet<double>>& of) {
      double sum = 0;
      for (const Jet<double>& jet : of) sum += jet.first * jet.first;
      return std::sqrt(sum);
    };
    Ends out{jets(*a.joints, a.to - da), jets(*b.joints, b.from + db), 1, 0};
    out.scale = rate(out.behind) / rate(out.before);
    out.length = da + db * out.scale;
    for (Jet<double>& jet : out.behind)
      jet = {jet.value, jet.first / out.scale, jet.second / (out.scale * out.scale), 0};
    return out;
  }

  std::shared_ptr<const PolynomialPath> joining_path(const Ends& ends) const {
    const std::size_t n = ends.before.size();
    constexpr std::size_t kPowers = PolynomialPath::kCoefficients;
    Values start(n), c(n * kPowers, 0.0);
    for (std::size_t j = 0; j < n; ++j) {
      start[j] = ends.before[j].value;
      const auto one = paths::hermite5(ends.before[j], ends.behind[j], ends.length);
      std::copy(one.begin(), one.end(), c.begin() + static_cast<std::ptrdiff_t>(j * kPowers));
    }
    auto path = std::make_shared<PolynomialPath>(start);
    path->append(ends.length, c);
    return path;
  }

  bool stays(const Path& path, const Values& corner, double radius) const {
    Values q(path.joints()), first(path.joints());
    path.at(0, {q, first, {}, {}});
    const double least = kStandsStill * norm_of(first);
    for (int k = 0; k <= kSamples; ++k) {
      path.at(path.length() * k / kSamples, {q, first, {}, {}});
      if (!(norm_of(first) > least)) return false;
      if (!(r_.distance(q, corner) <= radius)) return false;
      for (std::size_t j = 0; j < q.size(); ++j)
        if (q[j] < r_.robot.chain.lower()[j] || q[j] > r_.robot.chain.upper()[j]) return false;
    }
    return true;
  }

  void warn(std::size_t index, double reached, const char* why) {
    const Move& move = r_.moves[index];
    warnings_.push_back({index,
                         {"blend-shrunk",
                          {},
                          fmt::format("the blend of {:.6g} m at {} is shrunk to {:.6g} m: {}", move.blend,
                                      move.end().name, reached, why),
                          "give a smaller blend, or move the points apart",
                          Severity::warning}});
  }

  const PlanRequest& r_;
  std::vector<MovePlan::Warning>& warnings_;
};

}  // namespace

bool join_moves(const PlanRequest& request, MoveDraft& draft, MovePart& next,
                std::vector<MovePlan::Warning>& warnings) {
  return Joins(request, warnings).run(draft, next);
}

}  // namespace polyarm::moves
