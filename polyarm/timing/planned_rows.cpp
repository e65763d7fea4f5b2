#include "polyarm/timing/planned_rows.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::timing {
namespace {

constexpr double kSide = 1e-9;  // s; offset at which one side of a jump is evaluated
/// Nodes are added until the rows are linear between them to this fraction of a limit, or until this many
/// halvings.
constexpr double kClose = 1e-4;
constexpr int kMostHalvings = 5;
constexpr double kNoLimit = 1e300;     // for unused entries
constexpr std::size_t kMost = 40'000;  // largest number of nodes, without those of jumps; longer plans have
                                       // larger intervals

std::vector<double> jumps_of(const TimedPath& path) {
  std::vector<double> all{0, path.duration()};
  for (const SpeedProfile::Piece& p : path.profile().pieces()) all.push_back(p.begin);
  for (const double s : path.path().breaks()) all.push_back(path.profile().time_at(s));
  std::sort(all.begin(), all.end());
  std::vector<double> out;
  for (const double t : all)
    if (out.empty() || t - out.back() > 4 * kSide) out.push_back(t);
  return out;
}

/// Makes the nodes of a table; adds nodes where the rows are curved.
class NodeMaker {
 public:
  /// The rows at a time; their values are those of the maker until clear().
  struct Look {
    double time;
    std::size_t at;
  };

  NodeMaker(const TimedPath& path, std::span<const trajectory::MotionLimits> limits)
      : path_(path), limits_(limits), q_(limits.size()) {}

  void clear() { values_.clear(); }
  Look look(double time, double at) {
    const Look out{time, values_.size()};
    values_.resize(values_.size() + 3 * limits_.size());
    path_.sample(at, q_, row(out, 0), row(out, 1), row(out, 2), hint_);
    return out;
  }
  std::span<const double> velocity(const Look& of) { return row(of, 0); }
  std::span<const double> acceleration(const Look& of) { return row(of, 1); }
  std::span<const double> jerk(const Look& of) { return row(of, 2); }

  /// Fills the interval between two nodes; `from` is already in the list, `to` is appended.
  void fill(const Look& from, const Look& to, int halvings, std::vector<Look>& out) {
    const double middle = from.time + (to.time - from.time) / 2;
    if (halvings > 0) {
      const Look between = look(middle, middle);
      if (error(from, to, between) > kClose) {
        fill(from, between, halvings - 1, out);
        fill(between, to, halvings - 1, out);
        return;
      }
    }
    out.push_back(to);
  }

 private:
  std::span<double> row(const Look& of, std::size_t which) {
    return std::span(values_).subspan(of.at + which * limits_.size(), limits_.size());
  }
  double error(const Look& from, const Look& to, const Look& between) {
    double most = 0;
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      const trajectory::MotionLimits& l = limits_[i];
      const auto off = [&](std::size_t which) {
        return std::abs((row(from, which)[i] + row(to, which)[i]) / 2 - row(between, which)[i]);
      };
      most = std::max({most, off(0) / std::min(l.max_velocity, -l.min_velocity),
                       off(1) / std::min(l.max_acceleration, -l.min_acceleration), off(2) / l.max_jerk});
    }
    return most;
  }

  const TimedPath& path_;
  std::span<const trajectory::MotionLimits> limits_;
  std::vector<double> q_, values_;
  std::size_t hint_ = 0;
};

}  // namespace

void PlannedRows::add(double time, std::span<const double> v, std::span<const double> a,
                      std::span<const double> j) {
  times_.push_back(time);
  rows_.resize(rows_.size() + blocks_, Rows{});
  for (std::size_t i = 0; i < v.size(); ++i) {
    Rows& to = rows_[rows_.size() - blocks_ + i / kWidth];
    to.velocity[i % kWidth] = v[i], to.acceleration[i % kWidth] = a[i], to.jerk[i % kWidth] = j[i];
  }
}

PlannedRows::PlannedRows(const TimedPath& path, std::span<const trajectory::MotionLimits> limits,
                         double spacing)
    : blocks_((path.joints() + kWidth - 1) / kWidth) {
  spacing = std::max(spacing, path.duration() / double(kMost));
  NodeMaker maker(path, limits);
  const std::vector<double> jumps = jumps_of(path);
  std::vector<NodeMaker::Look> nodes;
  for (std::size_t k = 0; k + 1 < jumps.size(); ++k) {
    const double begin = jumps[k], length = jumps[k + 1] - begin;
    const auto parts = std::max<std::size_t>(1, std::size_t(std::ceil(length / spacing)));
    maker.clear();
    nodes.assign(1, maker.look(begin, begin + kSide));
    for (std::size_t i = 1; i <= parts; ++i) {
      const double t = begin + length * double(i) / double(parts);
      const NodeMaker::Look from = nodes.back();
      maker.fill(from, i < parts ? maker.look(t, t) : maker.look(jumps[k + 1], jumps[k + 1] - kSide),
                 kMostHalvings, nodes);
    }
    for (const NodeMaker::Look& n : nodes)
      add(n.time, maker.velocity(n), maker.acceleration(n), maker.jerk(n));
  }
  if (times_.empty()) {
    const NodeMaker::Look only = maker.look(0, 0);
    for (int k = 0; k < 2; ++k)
      add(0, maker.velocity(only), maker.acceleration(only), maker.jerk(only));
  }
}

std::size_t PlannedRows::before(double t, std::size_t i) const noexcept {
  const std::size_t last = times_.size() - 1;
  i = std::min(i, last);
  for (int near = 0; near < 8; ++near) {
    if (times_[i] > t) {
      if (i == 0) return 0;
      --i;
    } else if (i < last && times_[i + 1] <= t) {
      ++i;
    } else {
      return i;
    }
  }
  const auto after = std::upper_bound(times_.begin(), times_.end(), t);
  return after == times_.begin() ? 0 : std::size_t(after - times_.begin()) - 1;
}

void PlannedRows::between(std::size_t node, double t, Rows* out) const noexcept {
  const std::size_t next = std::min(node + 1, times_.size() - 1);
  const double length = times_[next] - times_[node];
  const double share = length > 0 ? std::clamp((t - times_[node]) / length, 0.0, 1.0) : 0;
  const Rows *from = at(node), *to = at(next);
  // The velocity deviates this much from linear, because its acceleration is linear; the factor's second
  // derivative amplifies the deviation.
  const double bent = length * share * (1 - share) / 2;
  for (std::size_t b = 0; b < blocks_; ++b)
    for (std::size_t i = 0; i < kWidth; ++i) {
      const double more = to[b].acceleration[i] - from[b].acceleration[i];
      out[b].velocity[i] =
          from[b].velocity[i] + share * (to[b].velocity[i] - from[b].velocity[i]) - bent * more;
      out[b].acceleration[i] = from[b].acceleration[i] + share * more;
      out[b].jerk[i] = from[b].jerk[i] + share * (to[b].jerk[i] - from[b].jerk[i]);
    }
}

std::vector<PlannedRows::Limits> PlannedRows::limits_of(std::span<const trajectory::MotionLimits> limits,
                                                        double harder) {
  std::vector<Limits> out((limits.size() + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < out.size() * kWidth; ++i) {
    Limits& to = out[i / kWidth];
    const std::size_t k = i % kWidth;
    to.high[k] = to.jerk[k] = kNoLimit, to.low[k] = -kNoLimit;
    if (i >= limits.size()) continue;
    to.high[k] = harder * limits[i].max_acceleration, to.low[k] = harder * limits[i].min_acceleration;
    to.jerk[k] = harder * harder * limits[i].max_jerk;
  }
  return out;
}

}  // namespace polyarm::timing
