#include "drivers/franka/fake.hpp"

#include <cmath>

#include "polyarm/base/error.hpp"

namespace polyarm::franka {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 500'000'000;
constexpr std::uint64_t kHandCycles = 10;

MachineOptions machine_of(const hardware::RobotInstance& robot, Nanoseconds period) {
  MachineOptions out;
  if (robot.model) out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, 1.0);
  if (period != 1'000'000)
    throw Error("bad-value", "a robot of Franka has a cycle of 1 ms", "write `rate: 1000` into the cell");
  return out;
}

}  // namespace

CallbackReturn OnFarSide::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return FrankaComponent::on_init(context);
  FarSideOptions options;
  options.machine = machine_of(context.robots.front(), context.period);
  options.port = options.hand_port = 0;
  options.patience = kAnswer;
  far_ = std::make_unique<FarSide>(options);
  faults_ = wire::DueOrders(FarSide::timed_orders(wire::given(context, "faults")));
  hardware::ComponentContext own = wire::beside_its_controller(context);
  own.parameters["port"] = std::to_string(far_->port());
  own.parameters["hand_port"] = std::to_string(far_->hand_port());
  own.parameters["pace"] = "false";
  return FrankaComponent::on_init(own);
}

hardware::ReturnType OnFarSide::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  step(seconds(cycle.period));
  if (has_hand() && is_due(kHandCycles)) link()->serve_hand(far_->hand_state());
  return FrankaComponent::read(cycle, states);
}

std::string OnFarSide::summary() const {
  return "simulated controller, port " + std::to_string(far_->port()) + ": " + FrankaComponent::summary();
}

}  // namespace polyarm::franka
