#pragma once
/// A driver on a simulated controller of its own, whose clock waits for the loop.
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "drivers/wire/signals.hpp"
#include "drivers/wire/simulated.hpp"
#include "polyarm/base/text.hpp"
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

/// Of the packet that a sample of a link was made from.
template <class Sample>
std::uint64_t sequence_of(const Sample& sample) noexcept {
  return sample.sequence;
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
    cycles_ = 0;
    stepped_ = true;
    return done;
  }
  hardware::CallbackReturn on_deactivate() override {
    if (!stepped_.exchange(false)) return Driver::on_deactivate();
    const Stepper<FarSide> stepper(*far_, braking_);
    return Driver::on_deactivate();
  }
  hardware::CallbackReturn on_cleanup() override {
    if (!far_) return hardware::CallbackReturn::success;
    if (!stepped_.exchange(false)) return Driver::on_cleanup();
    const Stepper<FarSide> stepper(*far_, braking_);
    return Driver::on_cleanup();
  }
  bool real() const noexcept override { return false; }
  FarSide& far_side() { return *far_; }

 protected:
  /// Orders the parameter `faults`, and connects `wires` as `wire_of(text)` reads each of them: OUTPUT and
  /// INPUT. Throws Error("bad-value").
  template <typename WireOf>
  void take_parameters(const hardware::ComponentContext& context, WireOf wire_of) {
    for (const std::string& text : split_words(given(context, "wires"), " ,;")) {
      const auto wire = wire_of(text);
      far_->with([&](auto& machine) { machine.wire_output(wire.first, wire.second); });
    }
    faults_ = DueOrders(FarSide::timed_orders(given(context, "faults")));
  }
  /// The same for signals with numbers from `least` to `most`.
  void take_parameters(const hardware::ComponentContext& context, int most, int least) {
    take_parameters(context, [&](const std::string& text) { return signal_wire(text, most, least); });
  }
  /// True in the first cycle after activating, and in every `cycles`-th from there.
  bool is_due(std::uint64_t cycles) noexcept { return cycles_++ % cycles == 0; }
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
  Nanoseconds braking_ = kDisturbed;  ///< a cycle of a stop waits so long for the driver's answer

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
      if (sequence_of(this->link()->sample()) >= sequence) return;
    } while (this->link()->await(kTimeout) && this->link()->cause() == decltype(this->cause()){});
  }
  std::atomic<bool> stepped_{false};
  std::uint64_t cycles_ = 0;
};

}  // namespace polyarm::wire
