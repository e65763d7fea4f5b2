#include "drivers/yaskawa/point_stream.hpp"

namespace polyarm::yaskawa {

void PointStream::begin(const Six& at) {
  shaper_.begin(at);
  out_.clear();
  trim_ = 0;
  rest();
}

void PointStream::rest() {
  open_ = pending_ = false;
  still_ = 0;
}

/// The robot stands at the position of the shaper.
void PointStream::open_at_rest() {
  if (open_) return;
  open_ = true;
  last_ = before_ = shaper_.at();
  out_.push_back({0, 0, last_, {}});
  out_.push_back({1, lead_, last_, {}});
  sequence_ = 2;
  time_ = before_time_ = lead_;
  since_ = 0;
}

void PointStream::push(const Six& position) {
  const int next_time = time_ + period_ + trim_;
  if (pending_) {
    TimedPoint point{sequence_++, time_, last_, {}};
    for (std::size_t i = 0; i < 6; ++i)
      point.velocity[i] = (position[i] - before_[i]) * 1000 / (next_time - before_time_);
    out_.push_back(point);
    before_ = last_;
    before_time_ = time_;
  }
  still_ = position == last_ && last_ == before_ ? still_ + 1 : 0;
  last_ = position;
  time_ = next_time;
  pending_ = true;
}

void PointStream::take(const Six& position) {
  if (++since_ < cycles_) return;
  since_ = 0;
  push(position);
}

void PointStream::go(const Six& target, const wire::AxisLimits& limits) {
  open_at_rest();
  take(shaper_.next(target, limits));
}

void PointStream::brake(const wire::AxisLimits& limits) {
  open_at_rest();
  take(shaper_.brake(limits));
}

}  // namespace polyarm::yaskawa
