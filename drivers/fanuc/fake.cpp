#include "drivers/fanuc/fake.hpp"

#include <cmath>
#include <numbers>

#include "polyarm/base/error.hpp"

namespace polyarm::fanuc {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 50'000'000;
constexpr Nanoseconds kBraking = 1'000'000'000;  // a cycle of a stop waits so long for the driver's answer

MachineOptions machine_of(const hardware::RobotInstance& robot) {
  MachineOptions out;
  if (!robot.model) return out;
  out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, 180 / std::numbers::pi);
  return out;
}

}  // namespace

FakeFanuc::FakeFanuc() {
  paced_ = false;
  follows_ = true;
  stepped_forward_ = true;
  braking_ = kBraking;
}

CallbackReturn FakeFanuc::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return FanucComponent::on_init(context);
  FarSideOptions options;
  options.machine = machine_of(context.robots.front());
  options.stream = options.rmi = options.session = 0;
  // A driver that falls behind would answer many packets at once, more than the controller buffers.
  options.patience = kAnswer;
  options.sampling_ms = static_cast<int>(std::lround(seconds(context.period) * 1000));
  if (options.sampling_ms < 1 || std::abs(options.sampling_ms - seconds(context.period) * 1000) > 1e-6)
    throw Error("bad-value", "a controller of FANUC has a whole number of milliseconds for a cycle",
                "write `rate: 125` or `rate: 250` into the cell");
  far_ = std::make_unique<FarSide>(options);
  take_parameters(context, Machine::kPorts, 1);
  hardware::ComponentContext own = context;
  own.parameters["host"] = "127.0.0.1";
  own.parameters["stream_port"] = std::to_string(far_->stream_port());
  own.parameters["rmi_port"] = std::to_string(far_->rmi_port());
  own.parameters["pace"] = "false";
  own.parameters.try_emplace("settle", "0");
  own.parameters.try_emplace("silence_ms",
                             "10000");  // the clocks of this machine say nothing about a controller
  own.parameters.try_emplace("loop_silence_ms", "10000");
  own.parameters.try_emplace("answer_ms", "10000");
  for (const char* one : {"wires", "faults"}) own.parameters.erase(one);
  return SimulatedComponent::on_init(own);
}

hardware::ReturnType FakeFanuc::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward())
    step_asked(seconds(cycle.period), *forward());
  else
    step(seconds(cycle.period));
  return SimulatedComponent::read(cycle, states);
}

std::string FakeFanuc::summary() const {
  return "simulated controller, port " + std::to_string(far_->stream_port()) + ": " +
         FanucComponent::summary();
}

}  // namespace polyarm::fanuc
