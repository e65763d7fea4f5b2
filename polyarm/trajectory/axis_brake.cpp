#include "polyarm/trajectory/axis_brake.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/trajectory/axis_reach.hpp"

namespace polyarm::trajectory {

void AxisBrake::run(double fast, double back, double up, double down) noexcept {
  const double width = fast + back, slack = kRounding * width;
  const double settles = at.v + at.a * std::abs(at.a) / 2;  // the velocity when the acceleration reaches zero
  if (at.a <= up && at.a >= -down && std::max(at.v, settles) <= fast + slack &&
      std::min(at.v, settles) >= -back - slack)
    return;
  if (at.a > up) pass(at.a - up, -1), at.a = up;
  if (at.a < -down) pass(-down - at.a, 1), at.a = -down;
  const double then = at.v + at.a * std::abs(at.a) / 2;
  const bool above = at.v > fast + slack, below = at.v < -back - slack;
  if ((above && then > -back) || (at.a > 0 && then > fast + slack))
    slow_down(1, fast, down, width);
  else if ((below && then < fast) || (at.a < 0 && then < -back - slack))
    slow_down(-1, -back, up, width);
}

/// To the velocity limit `bound`, from beyond it or from a state that will pass it. `side`: 1 for the upper
/// limit, else -1.
void AxisBrake::slow_down(double side, double bound, double deceleration, double width) noexcept {
  const double beyond = side * (at.v - bound), towards = side * at.a;
  const double turn = root(towards * towards + 2 * beyond);  // deceleration at the bound, if it is not
                                                             // clipped
  if (std::min(turn, deceleration) <= root(2 * width)) {
    if (turn <= deceleration) {
      pass(towards + turn, -side);
    } else {
      pass(towards + deceleration, -side);
      if (side * at.a < 0) pass(side * (at.v - bound) / deceleration, 0);
    }
    at.v = bound;
    return;
  }
  // There is not enough room to take that deceleration back before the other bound: it is taken back earlier,
  // so that the motion settles at the other bound.
  const double other = bound - side * width;
  const double most = root(beyond + width + towards * towards / 2);
  const double low = std::min(most, deceleration);
  pass(towards + low, -side);
  const double left = side * (at.v - other) - low * low / 2;
  if (low < most && left > 0) pass(left / low, 0);
  pass(low, side);
  at.v = other, at.a = 0;
}

void AxisBrake::pass(double t, double j) noexcept {
  if (!(t > 0)) return;
  time[count] = t;
  jerk[count++] = j;
  total += t;
  at = after(at, t, j);
}

}  // namespace polyarm::trajectory
