#include "drivers/yaskawa/fake.hpp"

#include <fmt/format.h>

#include <cmath>

#include "drivers/wire/signals.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::yaskawa {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 5'000'000'000;
constexpr Nanoseconds kPatience = 20'000'000;  // for a request, between two cycles
constexpr std::uint64_t kServices = 12;  // cycles between two exchanges: about 20 a second

MachineOptions machine_of(const hardware::RobotInstance& robot, Nanoseconds period) {
  MachineOptions out;
  if (robot.model) out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, wire::kDegrees);
  const double ms = seconds(period) * 1000;
  out.interpolation_ms = static_cast<int>(std::lround(ms));
  if (out.interpolation_ms < 1 || out.interpolation_ms > 20 || std::abs(out.interpolation_ms - ms) > 1e-3)
    throw Error("bad-value", "the simulated controller has cycles of whole milliseconds, at most 20",
                "write `rate: 250` into the cell");
  return out;
}

}  // namespace

CallbackReturn FakeYaskawa::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return SimulatedComponent::on_init(context);
  const auto given = [&](const char* name) { return wire::given(context, name); };
  FarSideOptions options;
  options.machine = machine_of(context.robots.front(), context.period);
  options.motion = options.state = options.io = options.hses = 0;
  options.state_ms = options.machine.interpolation_ms;
  if (context.robots.front().tool) options.tool = context.robots.front().tool->tcp;
  if (const auto group = parse_number(given("group"))) options.machine.group = static_cast<int>(*group);
  far_ = std::make_unique<FarSide>(options);
  for (const std::string& text : split_words(given("wires"), " ,;")) {
    const auto [output, input] = wire::signal_wire(text, kMostSignals);
    far_->with([&, output = output, input = input](Machine& machine) { machine.wire_output(output, input); });
  }
  faults_ = wire::DueOrders(FarSide::timed_orders(given("faults")));
  hardware::ComponentContext own = wire::beside_its_controller(context);
  own.parameters["motion_port"] = std::to_string(far_->motion_port());
  own.parameters["state_port"] = std::to_string(far_->state_port());
  own.parameters["io_port"] = std::to_string(far_->io_port());
  own.parameters["hses_port"] = std::to_string(far_->hses_port());
  own.parameters["interpolation_ms"] = std::to_string(options.machine.interpolation_ms);
  const wire::Six& pulses = options.machine.facts.pulses;
  own.parameters["pulses"] = fmt::format("{}", fmt::join(pulses.begin(), pulses.end(), " "));
  own.parameters.try_emplace("answer_ms", "20000");
  own.parameters.try_emplace("watchdog_ms", "5000");
  return SimulatedComponent::on_init(own);
}

/// In forward mode starting takes time of the controller, whose clock goes on from request to request.
CallbackReturn FakeYaskawa::activate_forward() {
  far_->step_by_requests(true);
  far_->hold_clock(true);
  CallbackReturn done;
  {
    const wire::Stepper<FarSide> stepper(*far_, kPatience);
    done = SimulatedComponent::on_activate();
  }
  far_->hold_clock(done == CallbackReturn::success);
  return done;
}

CallbackReturn FakeYaskawa::on_activate() {
  const CallbackReturn done = forward() ? activate_forward() : SimulatedComponent::on_activate();
  if (done == CallbackReturn::success) cycles_ = 0;
  return done;
}

/// The controller moves on when it has every command, and the loop when the driver has its state.
hardware::ReturnType FakeYaskawa::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward()) {
    step_asked_once(seconds(cycle.period), *forward());
    return SimulatedComponent::read(cycle, states);
  }
  if (active_) link()->settle(kAnswer);
  step(seconds(cycle.period));
  if (active_) link()->settle(kAnswer);
  if (cycles_++ % kServices == 0) link()->serve_services();
  return SimulatedComponent::read(cycle, states);
}

std::string FakeYaskawa::summary() const {
  return "simulated controller, port " + std::to_string(far_->motion_port()) + ": " +
         YaskawaComponent::summary();
}

}  // namespace polyarm::yaskawa
