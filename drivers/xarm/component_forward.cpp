/// The component in forward mode: the controller interpolates.
#include <algorithm>

#include "drivers/xarm/component.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::xarm {

using hardware::ReturnType;

void XarmComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  const hardware::RobotInstance& robot = context.robots.front();
  if (joints_.size() != 6)
    throw Error("bad-value", "`motion: forward` is for arms of UFACTORY with six joints",
                "set `motion: stream`");
  wire::check_forward(robot, joints_);
  const auto joints = wire::six_revolute_joints(*robot.model, "ufactory/xarm_6");
  ForwardSettings out;
  out.host = settings_.host;
  out.command_port = settings_.command_port;
  out.report_port = settings_.report_port;
  out.clear_errors = settings_.clear_errors;
  out.signals = settings_.signals;
  out.frame = forward::frame_of(robot, joints, p.number("line_acceleration"));
  out.period = period_;
  out.silence = settings_.silence;
  out.timeout = settings_.timeout;
  out.start_timeout = settings_.start_timeout;
  out.answer = nanoseconds(p.number("answer_ms") / 1000);
  const Nanoseconds at_once = 1'000'000;  // the clock waits
  out.times = {stepped_link_, stepped_link_ ? at_once : nanoseconds(p.number("poll_ms") / 1000),
               settings_.loop_silence};
  out.watchdog_ms = stepped_link_ ? 0 : static_cast<int>(p.number("watchdog_ms"));
  p.problems().throw_if_errors();
  if (out.watchdog_ms > 0 && nanoseconds(out.watchdog_ms / 1000.0) <= out.answer)
    throw Error("bad-value", "`watchdog_ms` must be more than `answer_ms`",
                "an answer that is late would stop the robot");
  flange_ = out.frame.flange;
  readings_ = {};
  forward_ = std::make_unique<ForwardLink>(std::move(out));
}

ReturnType XarmComponent::read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  forward_->fetch();
  const ForwardSample& sample = forward_->sample();
  show_arm(sample, cycle, kStates, 0, states);
  for (std::size_t j = 0; j < joints_.size(); ++j) states[kStates * j + 2] = sample.report.torque[j];
  show_controller(sample.report, sample.panel, {}, Mode::position, states.subspan(kStates * joints_.size()));
  return forward_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

}  // namespace polyarm::xarm
