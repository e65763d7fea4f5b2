#pragma once
#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Tells any states, as ros2_control's StateInterfacesBroadcaster does: parameter `interfaces`, output
/// `values`, whose fields are the interfaces as the file names them, in its order.
class StateInterfacesBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  std::vector<std::size_t> places_;
  Output* values_ = nullptr;
};

}  // namespace polyarm::controllers
