#include "drivers/ur/fake.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kTimeout = 5'000'000'000, kDisturbed = 20'000'000;

MachineOptions machine_of(const hardware::RobotInstance& robot) {
  MachineOptions out;
  if (!robot.model) return out;
  out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, 1);
  return out;
}

}  // namespace

FakeUr::~FakeUr() {
  on_cleanup();
}

CallbackReturn FakeUr::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return UrComponent::on_init(context);
  FarSideOptions options;
  options.machine = machine_of(context.robots.front());
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  options.rate = 1 / seconds(context.period);
  const auto given = [&](const char* name) {
    const auto found = context.parameters.find(name);
    return found == context.parameters.end() ? std::string() : found->second;
  };
  far_ = std::make_unique<FarSide>(options);
  for (const std::string& wire : split_words(given("wires"), " ,;")) {
    const auto output = parse_number(wire.substr(0, wire.find('=')));
    const auto input =
        wire.find('=') == std::string::npos ? std::nullopt : parse_number(wire.substr(wire.find('=') + 1));
    const auto fits = [](const std::optional<double>& n) { return n && *n >= 0 && *n < Outputs::kDigital; };
    if (!fits(output) || !fits(input))
      throw Error("bad-value", "'" + wire + "' in `wires` is not OUTPUT=INPUT",
                  "numbers from 0 to 17, for example 0=0");
    far_->with(
        [&](Machine& machine) { machine.wire_output(static_cast<int>(*output), static_cast<int>(*input)); });
  }
  faults_ = wire::DueOrders(FarSide::timed_orders(given("faults")));
  hardware::ComponentContext own = context;
  own.parameters["host"] = "127.0.0.1";
  own.parameters["rtde_port"] = std::to_string(far_->rtde_port());
  own.parameters["primary_port"] = std::to_string(far_->primary_port());
  own.parameters["dashboard_port"] = std::to_string(far_->dashboard_port());
  own.parameters["pace"] = "false";
  own.parameters["rate"] = format_number(std::min(500.0, options.rate));
  own.parameters.try_emplace("watchdog_ms",
                             "5000");  // the clocks of this machine say nothing about a controller
  own.parameters.try_emplace("silence_ms", "10000");
  for (const char* one : {"wires", "faults"}) own.parameters.erase(one);
  return InWorld::on_init(own);
}

CallbackReturn FakeUr::on_configure() {
  if (far_) faults_.start(*far_);
  return InWorld::on_configure();
}

CallbackReturn FakeUr::on_activate() {
  if (far_) faults_.start(*far_);
  const CallbackReturn done = InWorld::on_activate();
  if (done != CallbackReturn::success) return done;
  far_->hold_clock(true);
  disturbed_ = false;
  stepped_ = true;
  return done;
}

CallbackReturn FakeUr::on_deactivate() {
  stepped_ = false;
  if (far_) far_->hold_clock(false);
  return UrComponent::on_deactivate();
}

CallbackReturn FakeUr::on_cleanup() {
  stepped_ = false;
  if (far_) far_->hold_clock(false);
  return link() ? UrComponent::on_cleanup() : CallbackReturn::success;
}

hardware::ReturnType FakeUr::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (stepped_) {
    faults_.step(*far_, seconds(cycle.period));
    // A fault may keep the controller's package back; then a command may wait for the next one.
    const double before = far_->sent_time();
    far_->step(last_command(), disturbed_ ? kDisturbed : kTimeout);
    const double sent = far_->sent_time();
    disturbed_ = disturbed_ || sent == before || !await_package(sent);
  }
  return InWorld::read(cycle, states);
}

/// Until the newest package is that of the time `sent`: older ones may still be on their way.
bool FakeUr::await_package(double sent) noexcept {
  do {
    link()->fetch();
    if (link()->sample()[kTimestamp] >= sent) return true;
  } while (link()->await(1'000'000'000) && link()->cause() == Cause::none);
  return false;
}

std::string FakeUr::summary() const {
  return "simulated controller, port " + std::to_string(far_->rtde_port()) + ": " + UrComponent::summary();
}

}  // namespace polyarm::ur
