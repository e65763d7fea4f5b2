#include <utility>

#include "drivers/ur/far_services.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

namespace {

/// A part of the robot state.
void part(wire::Writer& out, std::uint8_t type, const wire::Writer& body) {
  out.u32(body.bytes().size() + 5).u8(type).append(body.bytes());
}

void six(wire::Writer& out, const Six& values) {
  for (const double value : values) out.f64(value);
}

}  // namespace

void FarPrimary::send(const std::vector<std::uint8_t>& package) {
  for (const auto& client : primary_.clients())
    if (!wire::send_frame(client->socket.number(), package)) client->gone = true;
}

void FarPrimary::program_ended() {
  send(key_message(time(), "PROGRAM_XXX_STOPPED", program_.name()));
}

bool FarPrimary::take_script(Client& client, const std::string& text) {
  const bool power = text.starts_with("power") || text.starts_with("set ");
  if (!machine_.remote() && !power) {
    const auto refusal =
        error_message(time(), kReadOnly, 0, 3, "the port is read-only: the robot is not in remote control");
    return wire::send_frame(client.socket.number(), refusal);
  }
  if (text == "stop program") {
    if (!program_.runs()) return true;
    program_.stop();
    program_ended();
  } else if (text == "power on") {
    machine_.switch_on();
  } else if (text == "power off") {
    machine_.switch_off();
  } else if (text == "set robotmode run") {
    machine_.release_brakes();
  } else if (text == "set unlock protective stop") {
    machine_.unlock();
  } else if (text.starts_with("def ")) {
    if (program_.runs()) {
      program_.stop();
      program_ended();
    }
    if (!machine_.may_move()) return true;
    const std::string exception = program_.start(text);
    send(key_message(time(), "PROGRAM_XXX_STARTED", program_.name()));
    if (!exception.empty()) send(exception_message(time(), 1, 1, exception));
  }
  return true;
}

/// A program ends with a line "end" at the margin; any other line is a command of its own.
bool FarPrimary::take(Client& client, Bytes bytes) {
  client.text.append(bytes.begin(), bytes.end());
  if (client.text.size() > bounds::kFarSideScriptBytes) return false;
  for (;;) {
    const bool program = client.text.starts_with("def ") || client.text.starts_with("sec ");
    const std::size_t end = client.text.find(program ? "\nend\n" : "\n");
    if (end == std::string::npos) return true;
    const std::size_t size = end + (program ? 5 : 1);
    const std::string script = client.text.substr(0, size);
    client.text.erase(0, size);
    if (!take_script(client, program ? script : std::string(trim(script)))) return false;
  }
}

std::vector<std::uint8_t> FarPrimary::state() const {
  const MachineFacts& facts = machine_.options().facts;
  const Six &q = machine_.q(), &qd = machine_.qd(), zero{};
  const bool plays = machine_.program() == Machine::Program::playing;
  wire::Writer out, mode, joints, tool, board, pose, kinematics, setup, force, additional;
  mode.u64(time())
      .u8(1)
      .u8(1)
      .u8(machine_.robot_mode() >= idle)
      .u8(machine_.safety_mode() == robot_emergency);
  mode.u8(machine_.safety_mode() == protective_stop)
      .u8(plays)
      .u8(machine_.program() == Machine::Program::paused);
  mode.u8(static_cast<std::uint64_t>(machine_.robot_mode())).u8(0);
  mode.f64(machine_.speed_slider()).f64(machine_.speed_slider()).f64(1).u8(0);
  for (std::size_t i = 0; i < 6; ++i)
    joints.f64(q[i]).f64(q[i]).f64(qd[i]).f32(0).f32(48).f32(25).f32(0).u8(253);
  tool.u8(0).u8(0).f64(0).f64(0).f32(48).u8(0).f32(0).f32(25).u8(253);
  board.u32(static_cast<std::uint64_t>(machine_.value("actual_digital_input_bits").front()));
  board.u32(static_cast<std::uint64_t>(machine_.value("actual_digital_output_bits").front()));
  board.u8(0).u8(0).f64(0).f64(0).u8(0).u8(0).f64(0).f64(0).f32(25).f32(48).f32(1).f32(0);
  board.u8(static_cast<std::uint64_t>(machine_.safety_mode())).u8(0).u8(0).u32(0).u8(0).u8(0).u8(0);
  six(pose, flange_pose(facts.arm, q));
  six(pose, zero);
  for (std::uint64_t i = 1; i <= 6; ++i) kinematics.u32(0x9E3779B9u * i);
  for (const Six* one : {&facts.arm.theta, &facts.arm.a, &facts.arm.d, &facts.arm.alpha})
    six(kinematics, *one);
  kinematics.u32(0);
  for (std::size_t i = 0; i < 6; ++i) setup.f64(facts.lower[i]).f64(facts.upper[i]);
  for (std::size_t i = 0; i < 6; ++i) setup.f64(facts.velocity[i]).f64(40);
  for (const double value : {1.05, 1.4, 0.25, 1.2, 0.0}) setup.f64(value);
  six(setup, facts.kinematics.a);
  six(setup, facts.kinematics.d);
  six(setup, facts.kinematics.alpha);
  six(setup, facts.kinematics.theta);
  setup.i32(0).i32(machine_.options().major >= 5 ? 3 : 2).i32(facts.type).i32(0);
  six(force, zero);
  force.f64(0);
  additional.u8(0).u8(0).u8(1).u8(0);
  const std::pair<std::uint8_t, const wire::Writer*> parts[] = {
      {0, &mode}, {1, &joints}, {4, &pose},  {5, &kinematics}, {3, &board},
      {2, &tool}, {6, &setup},  {7, &force}, {8, &additional}};
  for (const auto& [type, body] : parts) part(out, type, *body);
  return primary_package(kRobotState, out.bytes());
}

void FarPrimary::send_state() {
  const auto package = state();
  for (Service<Client>* service : {&primary_, &secondary_})
    for (const auto& client : service->clients())
      if (!wire::send_frame(client->socket.number(), package)) client->gone = true;
}

void FarPrimary::serve() {
  const MachineOptions& o = machine_.options();
  const auto arrived = [&](Client& client) {
    client.gone |=
        !wire::send_frame(client.socket.number(), version_message(time(), o.major, o.minor, o.bugfix));
    client.gone |= !wire::send_frame(client.socket.number(), state());
  };
  const auto taken = [this](Client& client, Bytes bytes) { return take(client, bytes); };
  primary_.serve(arrived, taken);
  secondary_.serve(arrived, taken);
}

}  // namespace polyarm::ur
