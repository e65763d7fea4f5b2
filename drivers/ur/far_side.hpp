#pragma once
/// A controller of Universal Robots, simulated down to its bytes: for tests, and for users without a robot.
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/ur/far_services.hpp"
#include "drivers/wire/orders.hpp"

namespace polyarm::ur {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int rtde = 30004, dashboard = 29999, primary = 30001, secondary = 30002;  ///< ports; 0: any
  double rate = 500;                                                        ///< Hz, of the controller
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);
  ~FarSide();
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  int rtde_port() const { return rtde_.service().port(); }
  int dashboard_port() const { return dashboard_.service().port(); }
  int primary_port() const { return primary_.primary().port(); }
  int secondary_port() const { return primary_.secondary().port(); }

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& fault);
  /// The kinds with their meaning, one a line.
  static std::string kinds();
  /// The parameter `faults` of a driver with a controller of its own. Throws Error("bad-value").
  static std::vector<wire::TimedOrder> timed_orders(const std::string& text);

  /// The controller's clock stands still; step() moves it.
  void hold_clock(bool on);
  /// One cycle. Waits until the program has the message `sequence` (0: any), at most `patience` ns; false if
  /// it did not come.
  bool step(std::int32_t sequence = 0, Nanoseconds patience = 5'000'000'000);
  /// The controller's time in the newest RTDE package that went out, s.
  double sent_time();
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    const std::lock_guard lock(mutex_);
    return use(machine_);
  }
  std::uint64_t messages();
  bool program_runs();

 private:
  void run();
  void serve();
  void cycle();
  std::vector<int> descriptors();
  void report(const std::string& text) const;
  void end_program(const std::string& why);

  FarSideOptions options_;
  std::mutex mutex_;
  std::condition_variable served_;
  Machine machine_;
  FarFaults faults_;
  FarRtde rtde_;
  FarProgram program_;
  FarPrimary primary_;
  FarDashboard dashboard_;
  std::uint64_t cycles_ = 0;
  bool held_ = false, ran_ = false;
  Descriptor wake_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace polyarm::ur
