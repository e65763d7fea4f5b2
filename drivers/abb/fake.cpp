#include "drivers/abb/fake.hpp"

#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::abb {

using hardware::CallbackReturn;

namespace {

constexpr Nanoseconds kAnswer = 50'000'000;
constexpr std::uint64_t kServices = 12;  // cycles between two exchanges of signals: about 20 a second

std::pair<std::string, std::string> wire_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw Error("bad-value", "'" + text + "' in `wires` is not OUTPUT=INPUT",
                "names of signals, for example doVacuum=diHolds");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

MachineOptions machine_of(const hardware::RobotInstance& robot, Nanoseconds period) {
  MachineOptions out;
  if (robot.model) out.facts = facts_of(*robot.model);
  out.start = wire::start_position(robot, out.start, wire::kDegrees);
  const double ms = seconds(period) * 1000;
  out.rapid.sampling_ms = static_cast<int>(std::lround(ms));
  if (out.rapid.sampling_ms < 4 || out.rapid.sampling_ms % 4 != 0 ||
      std::abs(out.rapid.sampling_ms - ms) > 1e-6)
    throw Error("bad-value", "EGM has a cycle of 4 ms or a multiple of it",
                "write `rate: 250` or `rate: 125` into the cell");
  return out;
}

}  // namespace

CallbackReturn FakeAbb::on_init(const hardware::ComponentContext& context) {
  if (context.robots.size() != 1) return AbbComponent::on_init(context);
  const auto given = [&](const char* name) { return wire::given(context, name); };
  FarSideOptions options;
  options.machine = machine_of(context.robots.front(), context.period);
  if (const auto speed = parse_number(given("max_speed"))) options.machine.rapid.max_speed = *speed;
  options.rws = options.egm = options.moves = 0;
  if (given("motion") == "forward") options.machine.modules = {kMovesModule};
  options.rws_version = given("rws") == "1" ? 1 : 2;
  if (options.rws_version == 1) options.machine.software = "6.16.02.00";
  // A driver that falls behind would answer many packets at once.
  options.patience = kAnswer;
  for (const char* list : {"digital_in", "digital_out"})
    for (const std::string& name : split_words(given(list), " ,;"))
      options.machine.signals[name.substr(name.rfind('/') + 1)] = false;
  far_ = std::make_unique<FarSide>(options);
  take_parameters(context, wire_of);
  hardware::ComponentContext own = wire::beside_its_controller(context);
  own.parameters["rws_port"] = std::to_string(far_->rws_port());
  own.parameters["egm_port"] = "0";
  own.parameters["sampling_ms"] = std::to_string(options.machine.rapid.sampling_ms);
  own.parameters["pace"] = "false";
  own.parameters.erase("password_file");  // the simulated one has the maker's default
  own.parameters.erase("user");
  own.parameters["moves_port"] = std::to_string(far_->moves_port());
  own.parameters.try_emplace("answer_ms", "20000");
  own.parameters.try_emplace("watchdog_ms", "5000");
  return SimulatedComponent::on_init(own);
}

CallbackReturn FakeAbb::on_configure() {
  const CallbackReturn done = SimulatedComponent::on_configure();
  if (done == CallbackReturn::success && link()) far_->send_egm_to("127.0.0.1", link()->egm_port());
  return done;
}

hardware::ReturnType FakeAbb::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward())
    step_asked(seconds(cycle.period), *forward());
  else
    step(seconds(cycle.period));
  if (is_due(kServices)) forward() ? forward()->serve_services() : link()->serve_services();
  return SimulatedComponent::read(cycle, states);
}

std::string FakeAbb::summary() const {
  return "simulated controller, port " + std::to_string(far_->rws_port()) + ": " + AbbComponent::summary();
}

}  // namespace polyarm::abb
