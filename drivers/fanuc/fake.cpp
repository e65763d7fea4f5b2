#include "drivers/fanuc/fake.hpp"

#include <cmath>
#include <numbers>

#include "drivers/wire/signals.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::fanuc {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kTimeout = 5'000'000'000, kDisturbed = 20'000'000, kAnswer = 50'000'000;
constexpr Nanoseconds kBraking = 1'000'000'000;  // a cycle of a stop waits so long for the driver's answer

MachineOptions machine_of(const hardware::RobotInstance& robot) {
  MachineOptions out;
  if (!robot.model) return out;
  out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, 180 / std::numbers::pi);
  return out;
}

}  // namespace

FakeFanuc::~FakeFanuc() {
  on_cleanup();
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
  const auto given = [&](const char* name) {
    const auto found = context.parameters.find(name);
    return found == context.parameters.end() ? std::string() : found->second;
  };
  far_ = std::make_unique<FarSide>(options);
  for (const std::string& text : split_words(given("wires"), " ,;")) {
    const auto [output, input] = wire::signal_wire(text, Machine::kPorts);
    far_->with([&](Machine& machine) { machine.wire_output(output, input); });
  }
  faults_ = wire::DueOrders(FarSide::timed_orders(given("faults")));
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
  stepped_forward_ = true;
  for (const char* one : {"wires", "faults"}) own.parameters.erase(one);
  return InWorld::on_init(own);
}

CallbackReturn FakeFanuc::on_configure() {
  if (far_) faults_.start(*far_);
  return InWorld::on_configure();
}

CallbackReturn FakeFanuc::on_activate() {
  if (far_) faults_.start(*far_);
  const CallbackReturn done = InWorld::on_activate();
  if (done != CallbackReturn::success) return done;
  far_->hold_clock(true);
  stepped_ = true;
  return done;
}

CallbackReturn FakeFanuc::on_deactivate() {
  if (!stepped_.exchange(false)) return FanucComponent::on_deactivate();
  const wire::Stepper<FarSide> stepper(*far_, kBraking);
  return FanucComponent::on_deactivate();
}

CallbackReturn FakeFanuc::on_cleanup() {
  if (!link() && !forward()) return CallbackReturn::success;
  if (!stepped_.exchange(false)) return FanucComponent::on_cleanup();
  const wire::Stepper<FarSide> stepper(*far_, kBraking);
  return FanucComponent::on_cleanup();
}

hardware::ReturnType FakeFanuc::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (stepped_) {
    faults_.step(*far_, seconds(cycle.period));
    if (forward()) {
      forward()->exchange(
          kTimeout);  // what the last cycle asked for is there before the controller's next one
      far_->step(kTimeout);
      forward()->exchange(kTimeout);
      return InWorld::read(cycle, states);
    }
    const std::uint32_t before = far_->sent_sequence();
    far_->step(kTimeout);
    const std::uint32_t sent = far_->sent_sequence();
    if (sent != before)
      await_packet(sent);
    else
      link()->await(kDisturbed);  // a fault keeps the packet back
  }
  return InWorld::read(cycle, states);
}

/// Until the newest packet has the sequence: older ones may still be on their way.
bool FakeFanuc::await_packet(std::uint32_t sequence) noexcept {
  do {
    link()->fetch();
    if (link()->sample().status.sequence >= sequence) return true;
  } while (link()->await(1'000'000'000) && link()->cause() == Cause::none);
  return false;
}

std::string FakeFanuc::summary() const {
  return "simulated controller, port " + std::to_string(far_->stream_port()) + ": " +
         FanucComponent::summary();
}

}  // namespace polyarm::fanuc
