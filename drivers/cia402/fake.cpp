#include "drivers/cia402/fake.hpp"

#include <algorithm>

namespace polyarm::cia402 {

using hardware::CallbackReturn;

namespace {
constexpr Nanoseconds kTimeout = 5'000'000'000;
constexpr int kMostStopCycles = 3000;

/// Joints that a user did not describe: nodes from 1 on, an encoder with 4096 counts.
void complete(hardware::ComponentContext& context) {
  const hardware::RobotInstance& robot = context.robots.front();
  std::map<std::string, const std::map<std::string, std::string>*> described;
  std::vector<std::string> names;
  for (const description::HardwareInfo& block : robot.hardware)
    for (const description::ComponentInfo& part : block.components)
      if (part.kind == "joint") {
        names.push_back(part.name);
        described[part.name] = &part.parameters;
      }
  if (names.empty() && robot.model) names = robot.model->joint_names();
  const auto give = [&](const std::string& joint, const std::string& key, const std::string& value) {
    const auto found = described.find(joint);
    if (found == described.end() || !found->second->contains(key))
      context.parameters.try_emplace(joint + "." + key, value);
  };
  for (std::size_t j = 0; j < names.size(); ++j) {
    give(names[j], "node", std::to_string(j + 1));
    give(names[j], "counts_per_turn", "4096");
  }
}
}  // namespace

std::vector<FarDriveOptions> drives_of(const Settings& settings, const hardware::RobotInstance& robot) {
  std::vector<FarDriveOptions> out;
  const std::vector<std::string> names =
      robot.model ? robot.model->joint_names() : std::vector<std::string>{};
  for (const JointSettings& joint : settings.joints) {
    FarDriveOptions drive;
    drive.node = joint.node;
    drive.counts_per_rad = joint.scale.counts_per_rad();
    drive.offset = joint.scale.offset;
    const auto place =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), joint.name) - names.begin());
    if (place < robot.initial_positions.size()) drive.start = robot.initial_positions[place];
    out.push_back(drive);
  }
  return out;
}

CallbackReturn OnFarSide::on_init(const hardware::ComponentContext& context) {
  stepped_ = false;
  hardware::ComponentContext own = context;
  own.parameters.erase("faults");
  own.parameters["bus"] = "/dev/pts/fake";
  own.parameters["pace"] = "false";
  own.parameters.try_emplace("watchdog", "off");  // the drives end with the process
  own.parameters.try_emplace("loop_silence_ms", "10000");
  own.parameters.try_emplace("answer_ms", "2000");
  // A thread answers instead of a chip.
  own.parameters.try_emplace("heartbeat_ms", "500");
  own.parameters.try_emplace("lost_cycles", "20");
  if (!own.robots.empty()) complete(own);
  const Settings settings = read_settings(own);
  FarSideOptions options;
  options.machine.tick = context.period;
  options.machine.drives = drives_of(settings, context.robots.front());
  far_ = std::make_unique<FarSide>(options);
  faults_ = wire::DueOrders(FarSide::timed_orders(wire::given(context, "faults")));
  own.parameters["bus"] = far_->path();
  return Cia402Component::on_init(own);
}

CallbackReturn OnFarSide::on_configure() {
  faults_.start(*far_);
  return Cia402Component::on_configure();
}

CallbackReturn OnFarSide::on_activate() {
  faults_.start(*far_);
  const CallbackReturn done = Cia402Component::on_activate();
  if (done != CallbackReturn::success) return done;
  link()->hold(true);
  far_->hold_clock(true);
  stepped_ = true;
  return done;
}

/// Both clocks run in steps until the drives stand; only then they follow that of this machine.
void OnFarSide::stop_in_steps() {
  if (!stepped_.exchange(false)) return;
  link()->begin_stop();
  for (int k = 0; k < kMostStopCycles && !link()->stands(); ++k) {
    far_->step();
    link()->exchange(kTimeout);
  }
  link()->hold(false);
  far_->hold_clock(false);
}

CallbackReturn OnFarSide::on_deactivate() {
  stop_in_steps();
  return Cia402Component::on_deactivate();
}

CallbackReturn OnFarSide::on_cleanup() {
  if (!far_) return CallbackReturn::success;
  stop_in_steps();
  return Cia402Component::on_cleanup();
}

CallbackReturn OnFarSide::on_shutdown() {
  if (!far_) return CallbackReturn::success;
  stop_in_steps();
  return Cia402Component::on_shutdown();
}

hardware::ReturnType OnFarSide::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (stepped_) {
    faults_.step(*far_, seconds(cycle.period));
    far_->step();
    link()->exchange(kTimeout);
  }
  return Cia402Component::read(cycle, states);
}

std::string OnFarSide::summary() const {
  return "simulated drives: " + Cia402Component::summary();
}

}  // namespace polyarm::cia402
