#include "drivers/xarm/fake.hpp"

#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::xarm {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 5'000'000'000;
constexpr std::uint64_t kServices = 12;  // cycles between two exchanges: about 20 a second

MachineOptions machine_of(const hardware::RobotInstance& robot, Nanoseconds period) {
  MachineOptions out;
  if (robot.model) out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, wire::kDegrees);
  const double ms = seconds(period) * 1000;
  out.cycle_ms = static_cast<int>(std::lround(ms));
  if (out.cycle_ms < 4 || out.cycle_ms > 20 || std::abs(out.cycle_ms - ms) > 1e-3)
    throw Error("bad-value", "the simulated controller has cycles of whole milliseconds, 4 to 20",
                "write `rate: 250` into the cell");
  return out;
}

}  // namespace

CallbackReturn FakeXarm::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return SimulatedComponent::on_init(context);
  FarSideOptions options;
  options.machine = machine_of(context.robots.front(), context.period);
  options.ports = {0, 0, 0, 0};
  options.real_ms = options.machine.cycle_ms;
  far_ = std::make_unique<FarSide>(options);
  take_parameters(context, kMostSignals - 1, 0);
  hardware::ComponentContext own = wire::beside_its_controller(context);
  own.parameters["command_port"] = std::to_string(far_->ports().command);
  own.parameters["report_port"] = std::to_string(far_->ports().real);
  own.parameters.try_emplace("answer_ms", "20000");
  return SimulatedComponent::on_init(own);
}

/// One cycle of the controller, then exchanges until the driver has its report. What the loop wants reaches
/// the controller in the next one.
void FakeXarm::step_moves(double period) noexcept {
  constexpr Nanoseconds kOnlyAsk = 0;
  if (!active_) {
    forward()->exchange(kOnlyAsk);  // takes what came
    return;
  }
  faults_.step(*far_, period);
  const auto before = far_->packets();
  far_->step(0);
  const auto [packets, newest] = far_->sent();
  do forward()->exchange(kAnswer);
  while (packets != before && forward()->sample().count < newest && forward()->cause() == Cause::none);
}

/// The controller moves on when it has every command, and the loop when the driver has its report.
hardware::ReturnType FakeXarm::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward()) {
    step_moves(seconds(cycle.period));
    return SimulatedComponent::read(cycle, states);
  }
  if (active_) link()->settle(kAnswer);
  step(seconds(cycle.period));
  if (active_) link()->settle(kAnswer);
  if (is_due(kServices)) link()->serve_services();
  return SimulatedComponent::read(cycle, states);
}

std::string FakeXarm::summary() const {
  return "simulated controller, port " + std::to_string(far_->ports().command) + ": " +
         XarmComponent::summary();
}

}  // namespace polyarm::xarm
