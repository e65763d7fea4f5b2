#include "polyarm/timing/jerk_pieces.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::timing {
namespace {

/// Smallest root in a piece's time, relative to the mean speed of its ends. From rest at constant jerk it is
/// 1/3.
constexpr double kLeastRoot = 0.05;
constexpr double kLeastMargin = 0.01;   // smallest square of that root, for a sound motion
constexpr double kBeforeBreak = 1e-14;  // relative to the length of the path

}  // namespace

JerkPieces::JerkPieces(NodeMotion& motion)
    : motion_(motion),
      v_(motion.s.size()),
      per_v_(motion.s.size()),
      way_(motion.s.size()),
      pieces_(motion.s.size()),
      directions_(motion.s.size() + 2),
      diagonal_(motion.s.size()),
      beside_(motion.s.size()),
      share_(motion.s.size()) {
  for (std::size_t k = 1; k < motion.s.size(); ++k) way_[k] = motion.s[k] - motion.s[k - 1];
}

void JerkPieces::evaluate() {
  const std::vector<double>&b = motion_.b, &a = motion_.a;
  for (std::size_t k = 0; k < b.size(); ++k) v_[k] = std::sqrt(b[k]), per_v_[k] = v_[k] > 0 ? 0.5 / v_[k] : 0;
  for (std::size_t k = 1; k < b.size(); ++k) {
    JerkPiece& p = pieces_[k];
    const double mean = (v_[k - 1] + v_[k]) / 2, change = a[k] - a[k - 1], sum = a[k] + a[k - 1];
    const double square = mean * mean - way_[k] * change / 3, least = kLeastRoot * mean;
    const double root = square > least * least ? std::sqrt(square) : least;
    const double per_root = square > least * least ? 1 / root : 0;
    const double per = 1 / (mean + root), h = 2 * way_[k] * per, per_h = 1 / h;
    p.time = h, p.jerk = change * per_h;
    const double by_mean = -h * per * (1 + mean * per_root), by_change = h * per * way_[k] * per_root / 6;
    p.time_by = {by_mean * per_v_[k - 1] / 2, -by_change, by_mean * per_v_[k] / 2, by_change};
    const double squares = change * sum / 12, slope = h * h / 6;
    p.gap = b[k] - b[k - 1] - sum * way_[k] - h * h * squares;
    for (std::size_t i = 0; i < 4; ++i) {
      p.jerk_by[i] = -p.jerk * per_h * p.time_by[i];
      p.gap_by[i] = -2 * h * squares * p.time_by[i];
    }
    p.jerk_by[1] -= per_h, p.jerk_by[3] += per_h;
    p.gap_by[0] -= 1, p.gap_by[1] += slope * a[k - 1] - way_[k];
    p.gap_by[2] += 1, p.gap_by[3] -= slope * a[k] + way_[k];
  }
}

double JerkPieces::duration() const {
  double sum = 0;
  for (const JerkPiece& p : pieces_) sum += p.time;
  return sum;
}

double JerkPieces::worst_gap() const {
  double most = 0;
  for (std::size_t k = 1; k < pieces_.size(); ++k) {
    const double size = motion_.b[k] + motion_.b[k - 1];
    const double part = std::abs(pieces_[k].gap) / size;
    if (!(part <= most)) most = part;
  }
  return most;
}

bool JerkPieces::sound() const {
  if (!(worst_gap() < 1e-5)) return false;
  for (std::size_t k = 1; k < pieces_.size(); ++k) {
    const double mean = (v_[k - 1] + v_[k]) / 2;
    if (!(1 - way_[k] * (motion_.a[k] - motion_.a[k - 1]) / (3 * mean * mean) > kLeastMargin)) return false;
  }
  return true;
}

void JerkPieces::close() {
  // min Σ db²/σ² + (Δ² da²)/σ²: these weights almost decouple neighbouring equations.
  const std::size_t last = count();
  const auto weight = [&](std::size_t node) {
    return node == 0 || node == last ? 0 : 1 / (way_[node] * way_[node + 1]);
  };
  for (std::size_t k = 1; k <= last; ++k) {
    const ByNodes& g = pieces_[k].gap_by;
    const double before = weight(k - 1), behind = weight(k);
    diagonal_[k] = (before > 0 ? g[0] * g[0] + g[1] * g[1] * before : 0) +
                   (behind > 0 ? g[2] * g[2] + g[3] * g[3] * behind : 0);
    if (k < last) {
      const ByNodes& next = pieces_[k + 1].gap_by;
      beside_[k] = g[2] * next[0] + g[3] * next[1] * behind;
    }
    share_[k] = -pieces_[k].gap;
  }
  for (std::size_t k = 1; k < last; ++k) {
    const double l = beside_[k] / diagonal_[k];
    diagonal_[k + 1] -= l * beside_[k], share_[k + 1] -= l * share_[k];
  }
  for (std::size_t k = last; k >= 1; --k)
    share_[k] = (share_[k] - (k < last ? beside_[k] * share_[k + 1] : 0)) / diagonal_[k];
  for (std::size_t k = 1; k < last; ++k) {
    const ByNodes &g = pieces_[k].gap_by, &next = pieces_[k + 1].gap_by;
    const double change = share_[k] * g[2] + share_[k + 1] * next[0];
    motion_.b[k] = std::max(motion_.b[k] + change, 0.3 * motion_.b[k]);
    motion_.a[k] += weight(k) * (share_[k] * g[3] + share_[k + 1] * next[1]);
  }
  evaluate();
}

void JerkPieces::find_directions() {
  const std::size_t last = count();
  for (std::size_t i = 1; i + 1 < last; ++i) {
    const ByNodes &before = pieces_[i].gap_by, &own = pieces_[i + 1].gap_by, &behind = pieces_[i + 2].gap_by;
    // Along (-∂a, ∂b) of the previous piece and of the next one, so the piece between keeps its gap as well.
    const double left = own[0] * -before[3] + own[1] * before[2];
    const double right = own[2] * behind[1] - own[3] * behind[0];
    const double p = 1 / left, q = -1 / right;
    directions_[i] = {-before[3] * p, before[2] * p, behind[1] * q, -behind[0] * q};
  }
}

NodeMotion halved(const NodeMotion& m, const JerkPieces& pieces, const std::vector<char>& which) {
  NodeMotion out{{m.s[0]}, {m.b[0]}, {m.a[0]}};
  for (std::size_t k = 1; k < m.s.size(); ++k) {
    if (which[k]) {
      const double way = (m.s[k] - m.s[k - 1]) / 2, v = pieces.speed(k - 1), a = m.a[k - 1];
      const PathMotion middle = after_way({0, v, a, pieces.piece(k).jerk}, way, pieces.piece(k).time);
      out.s.push_back(m.s[k - 1] + way), out.b.push_back(middle.speed * middle.speed);
      out.a.push_back(middle.acceleration);
    }
    out.s.push_back(m.s[k]), out.b.push_back(m.b[k]), out.a.push_back(m.a[k]);
  }
  return out;
}

PathMotion after_way(const PathMotion& m, double way, double end, double begin) {
  double low = begin, high = end, t = (low + high) / 2;
  for (int n = 0; n < 6; ++n) {
    const double speed = m.speed + t * (m.acceleration + t * m.jerk / 2);
    const double over = t * (m.speed + t * (m.acceleration / 2 + t * m.jerk / 6)) - way;
    (over > 0 ? high : low) = t;
    const double newton = speed > 0 ? t - over / speed : low;
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - t) < 1e-13 * end) break;
    t = next;
  }
  return {m.s + way, m.speed + t * (m.acceleration + t * m.jerk / 2), m.acceleration + t * m.jerk, m.jerk};
}

SpeedProfile profile_of(NodeMotion& m, std::span<const double> breaks) {
  JerkPieces pieces(m);
  pieces.evaluate();
  SpeedProfile out({0, std::sqrt(m.b.front()), m.a.front(), 0});
  std::size_t next = 0;
  for (std::size_t k = 1; k < m.s.size(); ++k) {
    while (next < breaks.size() && breaks[next] < m.s[k]) ++next;
    const double speed = std::sqrt(m.b[k]);
    double time = pieces.piece(k).time;
    // Ends the piece just before a break, so that its last moment is always computed on this side of the
    // break.
    if (next < breaks.size() && breaks[next] == m.s[k] && k + 1 < m.s.size())
      time -= std::min(kBeforeBreak * m.s.back() / speed, 1e-9 * time);
    const double jerk = (m.a[k] - m.a[k - 1]) / time;
    out.append(time, jerk, {m.s[k], speed, m.a[k], jerk});
  }
  return out;
}

}  // namespace polyarm::timing
