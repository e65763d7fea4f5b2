#pragma once
/// How near a profile on a path comes to the limits, everywhere. Part of timing.hpp; outside the cycle.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/trajectory/path_trajectory.hpp"
#include "polyarm/trajectory/timing_rows.hpp"

namespace polyarm::trajectory {

/// What a check found.
struct Check {
  /// The highest use, at least 1, of each kind by joints and by norms; of velocity all together in [0].
  /// Velocity and jerk for each piece, acceleration for what lies between the middles of two: the interval
  /// that begins there.
  std::array<std::array<std::vector<double>, 3>, 2> most;
  struct Bent {
    std::size_t piece, kind;
    double peak;
  };
  std::vector<Bent> bent;      // where samples change much and the value is high
  double stretch = 0;          // the factor of time that brings the nearest row to its limit
  double peak[3] = {0, 0, 0};  // of each kind
  /// What asks for the stretch: kind, row, use and place.
  std::size_t worst_kind = 0, worst_row = 0;
  double worst_use = 0, worst_s = 0;
  /// All samples, where they are asked for.
  struct Seen {
    double s;
    std::array<float, 3> use;
    std::array<std::uint16_t, 3> row;
  };
  std::vector<Seen> seen;

  double excess(double factor) const {
    return std::max({peak[0] / factor, peak[1] / (factor * factor), peak[2] / (factor * factor * factor)}) -
           1;
  }
};

/// Looks at a profile on its path: every piece, cut at breaks, at `samples` times with both ends.
class Checker {
 public:
  explicit Checker(PathRows& rows) : rows_(rows) {}

  /// `only`: the pieces to look at, ascending; empty: all. `keep`: all samples.
  void look(const SpeedProfile& profile, std::size_t samples, bool keep, Check& out,
            std::span<const std::size_t> only = {}) {
    const auto pieces = profile.pieces();
    start(pieces.size(), keep, out);
    const std::span<const double> breaks = rows_.path().breaks();
    std::size_t next = 0;
    while (next < breaks.size() && breaks[next] <= 0) ++next;
    const std::size_t count = only.empty() ? pieces.size() : only.size();
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t i = only.empty() ? n : only[n];
      const double end_s = i + 1 < pieces.size() ? pieces[i + 1].motion.s : profile.length();
      const double end = (i + 1 < pieces.size() ? pieces[i + 1].begin : profile.duration()) - pieces[i].begin;
      double from = 0, from_s = pieces[i].motion.s;
      while (next < breaks.size() && breaks[next] < from_s) ++next;
      for (; next < breaks.size() && breaks[next] <= end_s && breaks[next] < profile.length(); ++next) {
        const double at = std::clamp(profile.time_at(breaks[next]) - pieces[i].begin, from, end);
        stretch(pieces[i].motion, i, {from, at, end}, from_s, breaks[next], samples);
        from = at, from_s = breaks[next];
      }
      if (from < end) stretch(pieces[i].motion, i, {from, end, end}, from_s, end_s, samples);
      if (passed_.size() >= kBlock) sum_up(keep, out);
    }
    sum_up(keep, out);
  }

 private:
  static constexpr std::size_t kBlock = 256;  // samples that are looked at together

  struct Times {
    double from, to, piece;
  };
  struct Stretch {
    std::size_t end, piece, first_late;
  };
  void start(std::size_t pieces, bool keep, Check& out) {
    for (auto& set : out.most)
      for (auto& list : set) list.assign(pieces, 1.0);
    out.bent.clear(), out.seen.clear();
    if (keep) out.seen.reserve(16 * pieces);
    out.stretch = 0, powers_ = {};
    for (double& p : out.peak) p = 0;
    passed_.clear(), stretches_.clear();
  }
  void stretch(const PathMotion& m, std::size_t piece, const Times& t, double from_s, double to_s,
               std::size_t samples) {
    const double inside = 1e-9 * (to_s - from_s), step = (t.to - t.from) / double(samples - 1);
    std::size_t first_late = passed_.size();
    for (std::size_t k = 0; k < samples; ++k) {
      const double x = t.from + step * double(k);
      PathMotion at = after(m, x);
      at.s = k == 0 ? from_s : k + 1 == samples ? to_s - inside : std::clamp(at.s, from_s, to_s - inside);
      passed_.add(at);
      if (2 * x <= t.piece) ++first_late;
    }
    stretches_.push_back({passed_.size(), piece, first_late});
  }
  void sum_up(bool keep, Check& out) {
    rows_.look(passed_.s);
    find_uses(rows_, passed_, uses_);
    std::size_t begin = 0;
    for (const Stretch& s : stretches_) {
      for (std::size_t kind = 0; kind < 3; ++kind) peaks(begin, s, kind, out);
      take_most(begin, s, out);
      begin = s.end;
    }
    for (std::size_t i = 0; keep && i < passed_.size(); ++i) {
      Check::Seen seen{passed_.s[i], {}, {}};
      for (std::size_t kind = 0; kind < 3; ++kind) {
        seen.use[kind] = float(uses_.value[kind][i]);
        seen.row[kind] = std::uint16_t(uses_.row[kind][i]);
      }
      out.seen.push_back(seen);
    }
    passed_.clear(), stretches_.clear();
  }
  void peaks(std::size_t begin, const Stretch& s, std::size_t kind, Check& out) {
    const double* use = uses_.value[kind].data();
    for (std::size_t i = begin; i < s.end; ++i) {
      double peak = use[i];
      if (i > begin && i + 1 < s.end) {  // that of the parabola through three samples, if among them
        const double bend = 2 * use[i] - use[i - 1] - use[i + 1], slope = use[i + 1] - use[i - 1];
        if (std::abs(slope) <= 2 * bend && bend > 0) peak += slope * slope / (8 * bend);
        if (std::abs(bend) > 1e-4 && peak > 0.99 * powers_[kind]) out.bent.push_back({s.piece, kind, peak});
      }
      if (peak > powers_[kind]) {
        out.stretch = kind == 0 ? peak : kind == 1 ? std::sqrt(peak) : std::cbrt(peak);
        powers_ = {out.stretch, out.stretch * out.stretch, out.stretch * out.stretch * out.stretch};
        out.worst_kind = kind, out.worst_row = std::size_t(uses_.row[kind][i]), out.worst_use = use[i];
        out.worst_s = passed_.s[i];
      }
      out.peak[kind] = std::max(out.peak[kind], peak);
    }
  }
  void take_most(std::size_t begin, const Stretch& s, Check& out) const {
    const double joints = double(rows_.joints());
    const std::size_t last = out.most[0][0].size() - 1;
    for (std::size_t kind = 0; kind < 3; ++kind)
      for (std::size_t i = begin; i < s.end; ++i) {
        const double use = uses_.value[kind][i];
        if (use <= 1) continue;
        std::size_t at = s.piece;
        if (kind == 1) at = std::min(i >= s.first_late ? at : at - (at > 0), last - (last > 0));
        double& most = out.most[kind > 0 && uses_.row[kind][i] >= joints][kind][at];
        most = std::max(most, use);
      }
  }

  PathRows& rows_;
  Passings passed_;
  Uses uses_;
  std::vector<Stretch> stretches_;
  std::array<double, 3> powers_{};  // of the stretch
};

}  // namespace polyarm::trajectory
