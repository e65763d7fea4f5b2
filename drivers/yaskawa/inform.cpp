#include "drivers/yaskawa/inform.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::yaskawa {

using hardware::ForwardMove;
using wire::Six;

namespace {

constexpr int kFastest = 32767;  // of an I variable
constexpr int kFastestTurn = 1800;

/// Rounded down: a robot that is a little slower keeps the limits of the plan.
int whole(double value, int most) {
  return static_cast<int>(std::clamp(std::floor(value + 1e-6), 1.0, static_cast<double>(most)));
}

// The variables are those of SharedDoubles and SharedMove; a test compares them.
constexpr const char* kHead =
    "/JOB\n//NAME POLYARM\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///DATE 2026/11/29 12:00\n"
    "///ATTR SC,RW\n///GROUP1 RB1\n";
constexpr const char* kLoop = R"(NOP
'MOVES OF POLYARM, ONE BY ONE
SET D083 D082
SET D084 1
*WAIT
JUMP *OUTPUT IF D085<>D086
JUMP *MOVE IF D080>D081
TIMER T=0.01
JUMP *WAIT
*OUTPUT
JUMP *ON IF I087=1
DOUT OT#(I086) OFF
JUMP *SWITCHED
*ON
DOUT OT#(I086) ON
*SWITCHED
SET D086 D085
JUMP *WAIT
*MOVE
'EVEN NUMBERS IN P080, ODD IN P083
SET D087 D081
DIV D087 2
MUL D087 2
JUMP *ODD IF D087=D081
)";
/// Of the moves with even or with odd numbers. A line to where the robot is comes before an arc, because an
/// arc behind an arc would be one with it.
constexpr const char* kMoves = R"(*{0}
JUMP *{0}J IF I{1}=1
JUMP *{0}L IF I{1}=2
JUMP *{0}C IF I{1}=3
JUMP *{0}R IF I{1}=4
ABORT
*{0}J
MOVJ P{4} VJ=I{2} PL=0 ACC=I{3} DEC=I{3}
JUMP *ENDED
*{0}L
MOVL P{4} V=I{2} PL=0 ACC=I{3} DEC=I{3}
JUMP *ENDED
*{0}R
MOVL P{4} VR=I{2} PL=0 ACC=I{3} DEC=I{3}
JUMP *ENDED
*{0}C
MOVL P{6} V=I{2} PL=0
MOVC P{6} V=I{2} PL=0
MOVC P{5} V=I{2}
MOVC P{4} V=I{2} PL=0 ACC=I{3} DEC=I{3}
JUMP *ENDED
)";
constexpr const char* kTail = "*ENDED\nINC D081\nJUMP *WAIT\nEND\n";

std::string moves_of(const char* label, int odd) {
  const auto number = [](int n) { return fmt::format("{:03}", n); };
  const int place = odd * SharedMove::places, integer = odd * SharedMove::integers;
  return fmt::format(fmt::runtime(kMoves), label, number(SharedMove::kind + integer),
                     number(SharedMove::speed + integer), number(SharedMove::ramp + integer),
                     number(SharedMove::end + place), number(SharedMove::via + place),
                     number(SharedMove::begin + place));
}

}  // namespace

JobMove job_move(const forward::MoveOrder& order, const forward::MoveFrame& frame) {
  JobMove out;
  const ForwardMove& move = order.move;
  out.begin = order.from;
  out.end = forward::end_of(move);
  out.ramp = std::clamp(whole(100 * move.acceleration, 100), 20, 100);
  if (move.kind == ForwardMove::Kind::joint) {
    out.speed = whole(10'000 * move.share * order.pace, 10'000);
    return out;
  }
  const forward::CartesianWay way = forward::cartesian_way(move, order.from, frame);
  out.kind = way.arc ? JobMove::arc : way.speed > 0 ? JobMove::line : JobMove::turn;
  if (way.arc) out.via = way.via;
  const double turn = std::max(way.turn, 1e-3) / std::max(move.duration, 0.01) * wire::kDegrees;
  out.speed = out.kind == JobMove::turn ? whole(10 * turn * order.pace, kFastestTurn)
                                        : whole(10'000 * way.speed * order.pace, kFastest);
  return out;
}

std::array<std::int32_t, 8> pulses_of(const Six& q, const Six& pulses) noexcept {
  std::array<std::int32_t, 8> out{};
  for (std::size_t i = 0; i < 6; ++i) out[i] = static_cast<std::int32_t>(std::llround(q[i] * pulses[i]));
  return out;
}

Six radians_of(const std::array<std::int32_t, 8>& values, const Six& pulses) noexcept {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = values[i] / pulses[i];
  return out;
}

Pose pose_of(const HsesPosition& position) noexcept {
  const auto& v = position.values;
  const auto angle = [&](std::size_t i) { return v[i] * 1e-4 / wire::kDegrees; };
  return {{v[0] * 1e-6, v[1] * 1e-6, v[2] * 1e-6}, from_rpy(angle(3), angle(4), angle(5))};
}

double base_height(const kinematics::Chain& chain) {
  return chain.axes().at(1).point.z;
}

std::string moves_job() {
  const std::string lines = std::string(kHead) + kLoop + moves_of("EVEN", 0) + moves_of("ODD", 1) + kTail;
  std::string out;
  for (const char one : lines) out += one == '\n' ? std::string("\r\n") : std::string(1, one);
  return out;
}

}  // namespace polyarm::yaskawa
