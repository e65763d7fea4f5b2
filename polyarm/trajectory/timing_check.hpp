#pragma once
/// How near a profile on a path comes to the limits, everywhere. Part of timing.hpp; outside the cycle.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "polyarm/trajectory/path_trajectory.hpp"
#include "polyarm/trajectory/timing_rows.hpp"

namespace polyarm::trajectory {

/// What a check found: motions in order of time, where and by how much they use the limits.
struct Check {
  std::vector<PathMotion> motion;
  std::vector<std::size_t> piece;
  std::vector<char> late;  // in the later half of its piece
  std::vector<Ratios> ratio;
  struct Bent {
    std::size_t piece, kind;
    double peak;
  };
  std::vector<Bent> bent;  // where samples change much and the value is high
  double stretch = 0;      // the factor of time that brings the nearest row to its limit
  double excess = 0;
  double peak[3] = {0, 0, 0};  // of each kind
  std::size_t worst = 0, worst_kind = 0;

  /// As if the same had been found at `factor` times the time.
  void slow_down(double factor) {
    const double by[3] = {factor, factor * factor, factor * factor * factor};
    for (Ratios& r : ratio)
      for (std::size_t kind = 0; kind < 3; ++kind) r.value[kind] /= by[kind];
    excess = 0;
    for (std::size_t kind = 0; kind < 3; ++kind) excess = std::max(excess, peak[kind] / by[kind] - 1);
  }
};

/// Looks at a profile on its path: every piece, cut at breaks, at `samples` times with both ends.
class Checker {
 public:
  explicit Checker(PathRows& rows) : rows_(rows) {}

  /// `only`: the pieces to look at, ascending; empty: all.
  void look(const SpeedProfile& profile, std::size_t samples, Check& out,
            std::span<const std::size_t> only = {}) {
    out.motion.clear(), out.piece.clear(), out.late.clear(), out.bent.clear(), ends_.clear();
    const auto pieces = profile.pieces();
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
        stretch(pieces[i].motion, i, {from, at, end}, from_s, breaks[next], samples, out);
        from = at, from_s = breaks[next];
      }
      if (from < end) stretch(pieces[i].motion, i, {from, end, end}, from_s, end_s, samples, out);
    }
    std::vector<double> s(out.motion.size());
    for (std::size_t i = 0; i < s.size(); ++i) s[i] = out.motion[i].s;
    rows_.look(std::move(s));
    ratios(rows_, out.motion, out.ratio);
    sum_up(out);
  }

 private:
  struct Times {
    double from, to, piece;
  };
  void stretch(const PathMotion& m, std::size_t piece, const Times& t, double from_s, double to_s,
               std::size_t samples, Check& out) {
    const double inside = 1e-9 * (to_s - from_s);
    for (std::size_t k = 0; k < samples; ++k) {
      const double x = t.from + (t.to - t.from) * double(k) / double(samples - 1);
      PathMotion at{m.s + x * (m.speed + x * (m.acceleration / 2 + x * m.jerk / 6)),
                    m.speed + x * (m.acceleration + x * m.jerk / 2), m.acceleration + x * m.jerk, m.jerk};
      at.s = k == 0 ? from_s : k + 1 == samples ? to_s - inside : std::clamp(at.s, from_s, to_s - inside);
      out.motion.push_back(at), out.piece.push_back(piece), out.late.push_back(2 * x > t.piece);
    }
    ends_.push_back(out.motion.size());
  }
  void sum_up(Check& out) const {
    std::array<double, 3> powers{};  // of the stretch
    out.stretch = 0;
    for (double& p : out.peak) p = 0;
    std::size_t begin = 0;
    for (const std::size_t end : ends_) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t kind = 0; kind < 3; ++kind) {
          const double here = out.ratio[i].value[kind];
          double peak = here;
          if (i > begin && i + 1 < end) {  // that of the parabola through three samples, if among them
            const double before = out.ratio[i - 1].value[kind], after = out.ratio[i + 1].value[kind];
            const double bend = 2 * here - before - after, slope = after - before;
            if (std::abs(slope) <= 2 * bend && bend > 0) peak += slope * slope / (8 * bend);
            if (std::abs(bend) > 1e-4 && peak > 0.99 * powers[kind])
              out.bent.push_back({out.piece[i], kind, peak});
          }
          if (peak > powers[kind]) {
            out.stretch = kind == 0 ? peak : kind == 1 ? std::sqrt(peak) : std::cbrt(peak);
            powers = {out.stretch, out.stretch * out.stretch, out.stretch * out.stretch * out.stretch};
            out.worst = i, out.worst_kind = kind;
          }
          out.peak[kind] = std::max(out.peak[kind], peak);
        }
      begin = end;
    }
  }

  PathRows& rows_;
  std::vector<std::size_t> ends_;
};

}  // namespace polyarm::trajectory
