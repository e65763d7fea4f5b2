#pragma once
/// Checks how close a profile on a path comes to its limits, at every place. Part of timing.hpp; not for the
/// control cycle.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "polyarm/timing/rows.hpp"
#include "polyarm/timing/timed_path.hpp"

namespace polyarm::timing {

/// The result of a check.
struct Check {
  std::vector<PieceUse> use;        // of each piece
  std::vector<ActiveLimit> active;  // the limiting rows along the path
  double stretch = 0;               // the factor of time that brings the highest row to its limit
  double peak[3] = {0, 0, 0};       // the highest value for each kind
  PathMotion worst;                 // the motion where that row is highest
  Ratios worst_ratio;
  std::size_t worst_kind = 0;

  /// The highest excess of any row over its limit, at `factor` times the duration.
  double excess(double factor) const {
    return std::max({peak[0] / factor, peak[1] / (factor * factor), peak[2] / (factor * factor * factor)}) -
           1;
  }
};

/// Samples a profile on its path: every piece, split at breaks, at `samples` times including both ends.
class Checker {
 public:
  explicit Checker(PathRows& rows) : rows_(rows) {}

  /// `only`: the pieces to check, ascending; empty: all.
  void look(const SpeedProfile& profile, std::size_t samples, Check& out,
            std::span<const std::size_t> only = {}) {
    out = {};
    clear();
    const auto pieces = profile.pieces();
    out.use.resize(pieces.size());
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
        stretch(pieces[i].motion, i, {from, at}, from_s, breaks[next], samples);
        from = at, from_s = breaks[next];
      }
      if (from < end) stretch(pieces[i].motion, i, {from, end}, from_s, end_s, samples);
      if (motion_.size() >= kAtOnce) sum_up(out);
    }
    sum_up(out);
    if (!out.active.empty()) out.active.front().from = 0, out.active.back().to = rows_.path().length();
  }

 private:
  static constexpr std::size_t kAtOnce = 256;  // samples; they fit into the L1 cache
  struct Times {
    double from, to;
  };
  void clear() { s_.clear(), motion_.clear(), ends_.clear(), of_.clear(); }
  void stretch(const PathMotion& m, std::size_t piece, const Times& t, double from_s, double to_s,
               std::size_t samples) {
    const double inside = 1e-9 * (to_s - from_s);
    for (std::size_t k = 0; k < samples; ++k) {
      const double x = t.from + (t.to - t.from) * double(k) / double(samples - 1);
      PathMotion at = after(m, x);
      at.s = k == 0 ? from_s : k + 1 == samples ? to_s - inside : std::clamp(at.s, from_s, to_s - inside);
      motion_.push_back(at), s_.push_back(at.s);
    }
    ends_.push_back(motion_.size()), of_.push_back(piece);
  }
  void sum_up(Check& out) {
    rows_.look(s_);
    ratios(rows_, motion_, ratio_);
    std::size_t begin = 0;
    for (std::size_t n = 0; n < ends_.size(); begin = ends_[n++]) {
      for (std::size_t i = begin; i < ends_[n]; ++i) {
        for (std::size_t kind = 0; kind < 3; ++kind)
          note(of_[n], kind, i, i > begin && i + 1 < ends_[n], out);
        note_active(motion_[i].s, ratio_[i], out);
      }
    }
    clear();
  }
  void note(std::size_t piece, std::size_t kind, std::size_t i, bool between, Check& out) {
    const double power[3] = {out.stretch, out.stretch * out.stretch, out.stretch * out.stretch * out.stretch};
    double peak = ratio_[i].value[kind];
    if (between) {  // the peak of the parabola through three samples, if it lies between them
      const double before = ratio_[i - 1].value[kind], after = ratio_[i + 1].value[kind];
      const double bend = 2 * peak - before - after, slope = after - before;
      if (std::abs(slope) <= 2 * bend && bend > 0) peak += slope * slope / (8 * bend);
    }
    double& most = out.use[piece].most[ratio_[i].row[kind] >= rows_.joints()][kind];
    most = std::max(most, peak), out.peak[kind] = std::max(out.peak[kind], peak);
    if (peak <= power[kind]) return;
    out.stretch = kind == 0 ? peak : kind == 1 ? std::sqrt(peak) : std::cbrt(peak);
    out.worst = motion_[i], out.worst_ratio = ratio_[i], out.worst_kind = kind;
  }
  void note_active(double s, const Ratios& r, Check& out) const {
    const auto kind = std::size_t(std::max_element(r.value, r.value + 3) - r.value);
    if (!out.active.empty()) {
      ActiveLimit& last = out.active.back();
      if (last.row == r.row[kind] && last.kind == LimitKind(kind)) return;
      last.to = s;
    }
    out.active.push_back({s, s, r.row[kind], LimitKind(kind)});
  }

  PathRows& rows_;
  std::vector<double> s_;
  std::vector<PathMotion> motion_;
  std::vector<Ratios> ratio_;
  std::vector<std::size_t> ends_, of_;  // for each stretch: the index after its last sample; the index of its
                                        // piece
};

}  // namespace polyarm::timing
