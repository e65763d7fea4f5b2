#include "polyarm/timing/timed_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "polyarm/trajectory/splines.hpp"

namespace polyarm::timing {

void SpeedProfile::append(double duration, double jerk) {
  if (!(duration > 0)) return;
  state_.jerk = jerk;
  pieces_.push_back({duration_, state_});
  state_ = after(state_, duration);
  duration_ += duration;
}

void SpeedProfile::append(double duration, double jerk, const PathMotion& end) {
  append(duration, jerk);
  state_ = {end.s, end.speed, end.acceleration, jerk};
}

PathMotion SpeedProfile::at(double t, std::size_t& hint) const noexcept {
  if (pieces_.empty()) return state_;
  if (!(t > 0)) t = 0;
  if (t >= duration_) return state_;
  const auto holds = [&](std::size_t i) {
    return i < pieces_.size() && pieces_[i].begin <= t &&
           (i + 1 == pieces_.size() || t < pieces_[i + 1].begin);
  };
  if (!holds(hint) && !holds(++hint)) {
    const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), t,
                                       [](double value, const Piece& p) { return value < p.begin; });
    hint = std::size_t(next - pieces_.begin()) - (next == pieces_.begin() ? 0 : 1);
  }
  return after(pieces_[hint].motion, t - pieces_[hint].begin);
}

double SpeedProfile::time_at(double s) const noexcept {
  if (pieces_.empty() || s <= pieces_.front().motion.s) return 0;
  if (s >= state_.s) return duration_;
  const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), s,
                                     [](double value, const Piece& p) { return value < p.motion.s; });
  const std::size_t i = std::size_t(next - pieces_.begin()) - 1;
  double low = 0, high = (i + 1 < pieces_.size() ? pieces_[i + 1].begin : duration_) - pieces_[i].begin;
  double t = high / 2;
  for (int k = 0; k < 60 && high - low > 1e-16 * duration_; ++k) {
    const PathMotion m = after(pieces_[i].motion, t);
    (m.s < s ? low : high) = t;
    const double newton = m.speed > 0 ? t + (s - m.s) / m.speed : low;
    if (newton == t) break;
    t = newton > low && newton < high ? newton : (low + high) / 2;
  }
  return pieces_[i].begin + t;
}

void SpeedProfile::stretch(double factor) noexcept {
  const auto slower = [&](PathMotion& m) {
    m.speed /= factor;
    m.acceleration /= factor * factor;
    m.jerk /= factor * factor * factor;
  };
  for (Piece& p : pieces_) p.begin *= factor, slower(p.motion);
  slower(state_);
  duration_ *= factor;
}

void SpeedProfile::fit(double length) noexcept {
  if (pieces_.empty() || !(state_.s > 0)) return;
  const double factor = length / state_.s;
  const auto further = [&](PathMotion& m) {
    m.s *= factor, m.speed *= factor, m.acceleration *= factor, m.jerk *= factor;
  };
  for (Piece& p : pieces_) further(p.motion);
  further(state_);
  state_.s = length;
}

TimedPath::TimedPath(std::shared_ptr<const paths::Path> path, SpeedProfile profile)
    : path_(std::move(path)), profile_(std::move(profile)) {}

void TimedPath::sample(double t, std::span<double> position, std::span<double> velocity,
                       std::span<double> acceleration, std::span<double> jerk,
                       std::size_t& hint) const noexcept {
  joints_on_path(*path_, profile_.at(t, hint), position, velocity, acceleration, jerk);
}

void joints_on_path(const paths::Path& path, const PathMotion& m, std::span<double> position,
                    std::span<double> velocity, std::span<double> acceleration,
                    std::span<double> jerk) noexcept {
  path.at(m.s, {position, velocity, acceleration, jerk});
  const double cube = m.speed * m.speed * m.speed;
  for (std::size_t j = 0; j < velocity.size(); ++j) {
    const double first = velocity[j];
    velocity[j] *= m.speed;
    if (acceleration.empty()) continue;
    const double second = acceleration[j];
    acceleration[j] = first * m.acceleration + second * m.speed * m.speed;
    if (!jerk.empty()) jerk[j] = first * m.jerk + 3 * second * m.speed * m.acceleration + jerk[j] * cube;
  }
}

namespace {

/// Halves a piece of time until a quintic follows it closely enough.
class Pieces {
 public:
  Pieces(const TimedPath& timed, double tolerance)
      : timed_(timed), tolerance_(tolerance), out_(timed.joints()), pieces_(timed.joints()) {
    for (auto* v : {&from_, &to_}) v->resize(3 * timed.joints());
    probe_.resize(timed.joints());
    coefficients_.resize(timed.joints() * trajectory::Trajectory::kCoefficients);
  }
  void add(double begin, double end) {
    ends(begin, from_), ends(end, to_);
    fit(end - begin);
    if (end - begin > 1e-6 && error(begin, end) > tolerance_) {
      const double middle = begin + (end - begin) / 2;
      add(begin, middle), add(middle, end);
      return;
    }
    for (std::size_t j = 0; j < timed_.joints(); ++j)
      std::copy(pieces_[j].begin(), pieces_[j].end(), coefficients_.begin() + long(j * pieces_[j].size()));
    out_.append(end - begin, coefficients_);
  }
  trajectory::Trajectory take() { return std::move(out_); }

 private:
  void ends(double t, std::vector<double>& to) {
    const std::size_t n = timed_.joints();
    const std::span<double> all(to);
    timed_.sample(t, all.first(n), all.subspan(n, n), all.subspan(2 * n), {}, hint_);
  }
  void fit(double duration) {
    const std::size_t n = timed_.joints();
    for (std::size_t j = 0; j < n; ++j)
      pieces_[j] = trajectory::spline_piece(5, {from_[j], from_[n + j], from_[2 * n + j]},
                                            {to_[j], to_[n + j], to_[2 * n + j]}, duration);
  }
  double error(double begin, double end) {
    double most = 0;
    for (int k = 1; k < 8; ++k) {
      const double t = (end - begin) * k / 8;
      timed_.sample(begin + t, probe_, {}, {}, {}, hint_);
      for (std::size_t j = 0; j < probe_.size(); ++j) {
        double q = 0;
        for (int c = trajectory::Trajectory::kDegree; c >= 0; --c) q = q * t + pieces_[j][std::size_t(c)];
        most = std::max(most, std::abs(q - probe_[j]));
      }
    }
    return most;
  }

  const TimedPath& timed_;
  double tolerance_;
  trajectory::Trajectory out_;
  std::vector<std::array<double, trajectory::Trajectory::kCoefficients>> pieces_;
  std::vector<double> from_, to_, probe_, coefficients_;
  std::size_t hint_ = 0;
};

}  // namespace

trajectory::Trajectory to_trajectory(const TimedPath& timed, double tolerance) {
  if (timed.empty()) return {};
  std::vector<double> times;
  for (const SpeedProfile::Piece& p : timed.profile().pieces()) times.push_back(p.begin);
  for (const double s : timed.path().breaks()) times.push_back(timed.profile().time_at(s));
  times.push_back(timed.duration());
  std::sort(times.begin(), times.end());
  Pieces out(timed, tolerance * 0.9);
  double begin = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool last = i + 1 == times.size();
    if (!(times[i] > begin) || (!last && times[i] - begin < 1e-7)) continue;
    out.add(begin, times[i]);
    begin = times[i];
  }
  return out.take();
}

}  // namespace polyarm::timing
