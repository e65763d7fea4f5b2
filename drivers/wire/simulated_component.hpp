#pragma once
/// A driver on a simulated controller of its own, whose clock waits for the loop.
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "drivers/wire/simulated.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::wire {

/// A parameter of the component, or "".
inline std::string given(const hardware::ComponentContext& context, const char* parameter) {
  const auto found = context.parameters.find(parameter);
  return found == context.parameters.end() ? std::string() : found->second;
}

/// For the driver on a controller in this process: the clocks of this machine say nothing about a controller,
/// and the parameters of the simulation are not the driver's.
inline hardware::ComponentContext beside_its_controller(hardware::ComponentContext context) {
  context.parameters["host"] = "127.0.0.1";
  for (const char* name : {"silence_ms", "loop_silence_ms"}) context.parameters.try_emplace(name, "10000");
  for (const char* name : {"start_timeout", "connect_timeout"}) context.parameters.try_emplace(name, "60");
  for (const char* name : {"wires", "faults"}) context.parameters.erase(name);
  return context;
}

/// While the component is active, the controller's clock stands still between two cycles of the loop, so that
/// a run repeats itself, as fast as the machine can. `Driver` is a wire::StreamComponent; the derived class
/// makes the far side in on_init(), and calls step() in each read().
template <class Driver, class FarSide>
class SimulatedComponent : public Driver {
 public:
  ~SimulatedComponent() override { SimulatedComponent::on_cleanup(); }
  hardware::CallbackReturn on_configure() override {
    if (far_) faults_.start(*far_);
    return Driver::on_configure();
  }
  hardware::CallbackReturn on_activate() override {
    if (far_) faults_.start(*far_);
    const hardware::CallbackReturn done = Driver::on_activate();
    if (done != hardware::CallbackReturn::success) return done;
    far_->hold_clock(true);
    stepped_ = true;
    return done;
  }
  hardware::CallbackReturn on_deactivate() override {
    if (!stepped_.exchange(false)) return Driver::on_deactivate();
    const Stepper<FarSide> stepper(*far_, kDisturbed);
    return Driver::on_deactivate();
  }
  hardware::CallbackReturn on_cleanup() override {
    if (!far_) return hardware::CallbackReturn::success;
    if (!stepped_.exchange(false)) return Driver::on_cleanup();
    const Stepper<FarSide> stepper(*far_, kDisturbed);
    return Driver::on_cleanup();
  }
  bool real() const noexcept override { return false; }
  FarSide& far_side() { return *far_; }

 protected:
  /// One cycle of the controller, until its packet is there.
  void step(double period) noexcept {
    if (!stepped_) return;
    faults_.step(*far_, period);
    const auto before = far_->packets();
    far_->step(kTimeout);
    await_packet(before);
  }
  /// The same for a driver that asks, in exchange(), and is not sent packets: what the loop wants reaches the
  /// controller before its cycle, and the loop reads what it did in it.
  template <typename Link>
  void step_asked(double period, Link& link) noexcept {
    if (!stepped_) return;
    faults_.step(*far_, period);
    link.exchange(kTimeout);
    far_->step(0);
    link.exchange(kTimeout);
  }
  /// The same with one exchange, which reads and then sends: what the loop wants reaches the controller one
  /// cycle later.
  template <typename Link>
  void step_asked_once(double period, Link& link) noexcept {
    if (!stepped_) return;
    faults_.step(*far_, period);
    far_->step(0);
    link.exchange(kTimeout);
  }
  std::unique_ptr<FarSide> far_;
  DueOrders faults_;

 private:
  static constexpr Nanoseconds kTimeout = 5'000'000'000, kDisturbed = 20'000'000;
  /// Until the newest packet is there: older ones may still be on their way.
  void await_packet(std::uint64_t before) noexcept {
    const auto [packets, sequence] = far_->sent();
    if (packets == before) {  // a fault keeps the packet back, or the stream ended
      this->link()->await(kDisturbed);
      return;
    }
    do {
      this->link()->fetch();
      if (this->link()->sample().sequence >= sequence) return;
    } while (this->link()->await(kTimeout) && this->link()->cause() == decltype(this->cause()){});
  }
  std::atomic<bool> stepped_{false};
};

}  // namespace polyarm::wire
