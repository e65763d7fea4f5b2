#pragma once
/// The driver with a simulated controller of its own: `hardware: abb_fake` drives it over the real wires.
#include <memory>
#include <string>
#include <vector>

#include "drivers/abb/component.hpp"
#include "drivers/abb/far_side.hpp"
#include "drivers/wire/simulated.hpp"

namespace polyarm::abb {

/// The driver's parameters apply, except host and ports; `rws` chooses the version of Robot Web Services.
/// `wires: doA=diB` connects outputs to inputs. `faults: KIND@SECOND …` orders faults of FarSide, in seconds
/// since the first activation. While the component is active, the controller's clock stands still between two
/// cycles of the loop, and signals are exchanged every 12 cycles, so that a run repeats itself, as fast as
/// the machine can.
class FakeAbb : public AbbComponent {
 public:
  FakeAbb() {
    paced_ = false;
    follows_ = true;
    stepped_services_ = true;
  }
  ~FakeAbb() override;
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override { return on_cleanup(); }
  hardware::CallbackReturn on_error() override { return on_cleanup(); }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  bool real() const noexcept override { return false; }
  std::string summary() const override;
  FarSide& far_side() { return *far_; }

 private:
  void await_packet(std::uint64_t before) noexcept;
  std::unique_ptr<FarSide> far_;
  wire::DueOrders faults_;
  std::uint64_t cycles_ = 0;
  std::atomic<bool> stepped_{false};
};

}  // namespace polyarm::abb
