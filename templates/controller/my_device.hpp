#pragma once
/// A controller of your own: takes joints to the positions it is sent, each at a steady speed.
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/latest.hpp"

namespace my_device_plugin {

namespace ctl = polyarm::controllers;

class MyDevice : public ctl::Controller {
 public:
  // The cell thread: may take their time; configure and receive may throw polyarm::Error.
  ctl::CallbackReturn on_configure(ctl::ControllerContext& context) override;
  ctl::CallbackReturn on_cleanup() override;
  ctl::CallbackReturn on_error() override;
  std::vector<ctl::InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const ctl::Input& message, bool goal) override;
  std::string refuse_changes(const std::vector<ctl::ParameterChange>& changes) const override;

  // The control thread: never block, allocate, throw or log.
  ctl::CallbackReturn on_activate(const ctl::Cycle& cycle) noexcept override;
  ctl::ReturnType update(const ctl::Cycle& cycle, const ctl::Verdict& verdict) noexcept override;
  void on_deactivate(const ctl::Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  bool standing() const noexcept override { return standing_; }

 private:
  double speed_ = 0.5;  ///< rad/s; changeable
  double step_ = 0;     ///< rad in an update
  polyarm::Nanoseconds period_ = 0;
  std::vector<double> target_, commanded_;                ///< rad, per joint
  polyarm::realtime::Latest<std::vector<double>> inbox_;  ///< from the cell thread to the control thread
  bool standing_ = true;
};

}  // namespace my_device_plugin
