#include "drivers/kuka/fake.hpp"

#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::kuka {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 500'000'000;
constexpr std::uint64_t kServices = 12;  // cycles between two exchanges of states: about 20 a second

MachineOptions machine_of(const hardware::RobotInstance& robot, Nanoseconds period) {
  MachineOptions out;
  if (robot.model) out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, wire::kDegrees);
  const double ms = seconds(period) * 1000;
  out.identity.cycle_ms = static_cast<int>(std::lround(ms));
  if ((out.identity.cycle_ms != 4 && out.identity.cycle_ms != 12) ||
      std::abs(out.identity.cycle_ms - ms) > 1e-3)
    throw Error("bad-value", "RSI has a cycle of 4 or of 12 ms",
                "write `rate: 250` or `rate: 83.3333` into the cell");
  return out;
}

}  // namespace

CallbackReturn FakeKuka::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return KukaComponent::on_init(context);
  const auto given = [&](const char* name) { return wire::given(context, name); };
  FarSideOptions options;
  options.machine = machine_of(context.robots.front(), context.period);
  options.machine.identity.relative = given("relative") == "true";
  if (const auto limit = parse_number(given("max_correction")))
    options.machine.identity.correction_limit = *limit;
  options.eki = options.rsi = 0;
  // A driver that falls behind would answer many packets at once.
  options.patience = kAnswer;
  far_ = std::make_unique<FarSide>(options);
  take_parameters(context, static_cast<int>(kMostSignals), 1);
  hardware::ComponentContext own = wire::beside_its_controller(context);
  own.parameters["eki"] = "true";
  own.parameters["eki_port"] = std::to_string(far_->eki_port());
  own.parameters["rsi_port"] = "0";
  own.parameters["pace"] = "false";
  own.parameters.erase("rsi_host");
  own.parameters.erase("rsi_address");
  own.parameters.try_emplace("answer_ms", "20000");
  own.parameters.try_emplace("watchdog_ms", "5000");
  return SimulatedComponent::on_init(own);
}

CallbackReturn FakeKuka::on_configure() {
  const CallbackReturn done = SimulatedComponent::on_configure();
  if (done == CallbackReturn::success && link()) far_->send_rsi_to("127.0.0.1", link()->rsi_port());
  return done;
}

hardware::ReturnType FakeKuka::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward()) {
    step_asked(seconds(cycle.period), *forward());
  } else {
    step(seconds(cycle.period));
    if (is_due(kServices)) link()->serve_services();
  }
  return SimulatedComponent::read(cycle, states);
}

std::string FakeKuka::summary() const {
  return "simulated controller, port " + std::to_string(far_->eki_port()) + ": " + KukaComponent::summary();
}

}  // namespace polyarm::kuka
