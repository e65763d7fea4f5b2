#include "drivers/ur/far_moves.hpp"

#include "drivers/ur/arm_kinematics.hpp"

namespace polyarm::ur {

namespace {

forward::PlayedArm arm_of(Machine& machine) {
  forward::PlayedArm out;
  out.q = [&machine]() -> const Six& { return machine.q(); };
  out.still = [&machine] { return machine.still(); };
  out.may_move = [&machine] { return machine.may_move(); };
  out.follow = [&machine](const Six& next) { machine.follow(next); };
  out.refuse = [&machine] { machine.safety(protective_stop); };
  out.ended = [&machine](int number) { machine.set_register("output_int_register_26", number); };
  out.flange = [&machine](const Six& q, std::array<double, 36>& J) {
    return flange_jacobian(machine.options().facts.arm, q, J);
  };
  return out;
}

forward::PlayedMove played(const MoveMessage& message) {
  using Kind = hardware::ForwardMove::Kind;
  forward::PlayedMove out;
  out.kind = message.work == Work::joint ? Kind::joint : message.work == Work::arc ? Kind::arc : Kind::line;
  out.number = message.number;
  out.goal = message.goal;
  out.via = message.via;
  out.acceleration = message.acceleration;
  out.speed = message.speed;
  out.time = message.time;
  out.blend = message.blend;
  return out;
}

}  // namespace

FarMoves::FarMoves(Machine& machine) : machine_(machine), player_(arm_of(machine), kMoveSlots) {}

void FarMoves::begin() {
  forget();
  player_.set_tool({});
  machine_.set_register("output_int_register_26", 0);
  machine_.set_register("output_int_register_27", 0);
}

void FarMoves::forget() {
  player_.forget();
  halting_ = 0;
}

bool FarMoves::take(const MoveMessage& message) {
  switch (message.work) {
    case Work::joint:
    case Work::line:
    case Work::arc:
      return player_.take(played(message));
    case Work::halt:
      forget();
      machine_.brake(kStop);
      halting_ = message.number;
      return true;
    case Work::tool: {
      const Six& p = message.goal;
      const Vec3 turn{p[3], p[4], p[5]};
      player_.set_tool({{p[0], p[1], p[2]}, from_axis_angle(normalized(turn), norm(turn))});
      return true;
    }
    default:
      return true;
  }
}

void FarMoves::step(double dt) {
  player_.change_pace(machine_.speed_slider(), dt);
  if (halting_ != 0) {
    if (!machine_.still()) return;
    machine_.set_register("output_int_register_27", halting_);
    halting_ = 0;
  }
  player_.step(dt);
}

}  // namespace polyarm::ur
