/// How long is the cycle of six servos at 1 Mbit/s? The whole of the component's read and write, over a pty
/// whose far side keeps the time that the bytes take on a wire (10 bits each), and the servos' return delay
/// before each answer. It cannot prove what a USB adapter adds (up to a frame of 1 ms each way at full
/// speed), nor that servos keep the delay they are set to.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "drivers/dynamixel/dynamixel.hpp"
#include "drivers/feetech/feetech.hpp"
#include "drivers/servo_bus/fake_bus.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm {
namespace {

using servo_bus::FakeBus;
using servo_bus::Wire;

constexpr int kJoints = 6, kCycles = 3000, kWarmUp = 100, kBitRate = 1'000'000;

struct Case {
  const char* name;
  Wire wire;
  bool fast;
  Nanoseconds return_delay;
};
constexpr Case kCases[] = {{"feetech, return delay 0", Wire::feetech, false, 0},
                           {"feetech, return delay 500 us", Wire::feetech, false, 500'000},
                           {"dynamixel, return delay 0", Wire::dynamixel, false, 0},
                           {"dynamixel, return delay 500 us", Wire::dynamixel, false, 500'000},
                           {"dynamixel fast, return delay 0", Wire::dynamixel, true, 0},
                           {"dynamixel fast, return delay 500 us", Wire::dynamixel, true, 500'000}};

hardware::ComponentContext six_joints(const std::string& port, bool fast) {
  hardware::ComponentContext out;
  out.name = "bus";
  out.period = 10'000'000;
  out.parameters = {{"port", port}, {"baud", std::to_string(kBitRate)}, {"answer_timeout_ms", "200"}};
  if (fast) out.parameters["fast_sync_read"] = "true";
  description::HardwareInfo block;
  for (int id = 1; id <= kJoints; ++id) {
    description::ComponentInfo joint;
    joint.name = "joint" + std::to_string(id);
    joint.kind = "joint";
    joint.parameters["id"] = std::to_string(id);
    joint.command_interfaces.push_back({"position"});
    for (const char* state : {"position", "velocity", "effort", "temperature", "voltage"})
      joint.state_interfaces.push_back({state});
    block.components.push_back(joint);
  }
  hardware::RobotInstance robot;
  robot.name = "arm";
  robot.hardware.push_back(block);
  out.robots.push_back(robot);
  return out;
}

/// What the machine itself adds: as many plain sleeps of that length, and the slowest percent of them, ms.
double sleep_p99(double length_ms) {
  std::vector<Nanoseconds> times;
  for (int k = 0; k < kCycles / 4; ++k) {
    const Nanoseconds start = realtime::monotonic_now(),
                      end = start + static_cast<Nanoseconds>(length_ms * 1e6);
    const timespec until{static_cast<time_t>(end / 1'000'000'000), static_cast<long>(end % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {
    }
    times.push_back(realtime::monotonic_now() - start);
  }
  std::sort(times.begin(), times.end());
  return static_cast<double>(times[times.size() * 99 / 100]) * 1e-6;
}

bool measure(const Case& c) {
  FakeBus fake(c.wire, {1, 2, 3, 4, 5, 6});
  std::unique_ptr<servo_bus::ServoComponent> component;
  if (c.wire == Wire::feetech)
    component = std::make_unique<feetech::FeetechComponent>();
  else
    component = std::make_unique<dynamixel::DynamixelComponent>();
  component->on_init(six_joints(fake.path(), c.fast));
  if (component->on_configure() != hardware::CallbackReturn::success ||
      component->on_activate() != hardware::CallbackReturn::success) {
    std::fprintf(stderr, "%s: %s\n", c.name, component->reason().c_str());
    return false;
  }
  fake.set_bit_rate(kBitRate, c.return_delay);
  std::vector<double> states(component->state_interfaces().size()), commands(kJoints, 0.1);
  hardware::Cycle cycle{0, 10'000'000, 0};
  std::vector<Nanoseconds> times;
  servo_bus::Traffic before, after;
  for (int k = 0; k < kWarmUp + kCycles; ++k, ++cycle.index) {
    if (k == kWarmUp) before = fake.traffic();
    const Nanoseconds start = realtime::monotonic_now();
    const bool fine = component->read(cycle, states) == hardware::ReturnType::ok &&
                      component->write(cycle, commands) == hardware::ReturnType::ok;
    if (k >= kWarmUp) times.push_back(realtime::monotonic_now() - start);
    if (!fine) {
      std::fprintf(stderr, "%s: %s\n", c.name, component->reason().c_str());
      return false;
    }
  }
  component->read(cycle, states);  // the last write is on the wire before this is answered
  after = fake.traffic();
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return static_cast<double>(times[static_cast<std::size_t>(share * (kCycles - 1))]) * 1e-6;
  };
  // The extra read is in the difference; a cycle more or less does not show.
  const double out = static_cast<double>(after.instructions - before.instructions) / (kCycles + 0.5);
  const double in = static_cast<double>(after.answers - before.answers) / (kCycles + 1);
  const double answers = c.fast ? 1 : kJoints;
  const double wire = (out + in) * 10e3 / kBitRate + answers * static_cast<double>(c.return_delay) * 1e-6;
  std::printf("%-37s %5.0f %5.0f %8.2f %8.2f %8.2f %8.2f %8.2f %6.0f   %llu\n", c.name, out, in, wire,
              at(0.5), at(0.99), at(1), sleep_p99(wire), 1e3 / at(0.99),
              static_cast<unsigned long long>(component->counters().lost));
  return true;
}
}  // namespace
}  // namespace polyarm

int main() {
  using namespace polyarm;
  std::printf("six servos, read and write, %d cycles each, 1 Mbit/s\n", kCycles);
  std::printf("%-37s %5s %5s %8s %8s %8s %8s %8s %6s   lost\n", "", "B out", "B in", "wire ms", "p50 ms",
              "p99 ms", "max ms", "sleep99", "Hz");
  bool fine = true;
  for (const Case& c : kCases) fine = measure(c) && fine;
  return fine ? EXIT_SUCCESS : EXIT_FAILURE;
}
