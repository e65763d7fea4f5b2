/// The component in forward mode: the controller interpolates.
#include <algorithm>
#include <limits>

#include "drivers/wire/six_axes.hpp"
#include "drivers/yaskawa/component.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::yaskawa {

using hardware::ReturnType;

namespace {

constexpr double kLeastPulses = 1, kLargestPulses = 1e6;  // for a degree

/// For a radian.
wire::Six pulses_in(const std::string& text) {
  const auto words = split_words(text, " ,;");
  wire::Six out{};
  bool fine = words.size() == out.size();
  for (std::size_t i = 0; fine && i < out.size(); ++i) {
    const double number = parse_number(words[i]).value_or(0);
    fine = std::abs(number) >= kLeastPulses && std::abs(number) <= kLargestPulses;
    out[i] = number / wire::kRadians;
  }
  if (!fine)
    throw Error(
        "bad-value",
        "`motion: forward` needs `pulses`, six numbers of pulses for a degree, not '" + text + "'",
        "jog each axis by 10 degrees, read its pulses before and after at the pendant, and write a tenth of "
        "the difference");
  return out;
}

}  // namespace

void YaskawaComponent::make_forward(const hardware::ComponentContext& context,
                                    hardware::DriverParameters& p) {
  const hardware::RobotInstance& robot = context.robots.front();
  if (!settings_.hses)
    throw Error("bad-value", "`motion: forward` needs the Ethernet server, and `hses: false` switches it off",
                "leave `hses` out, or set `motion: stream`");
  wire::check_forward(robot, joints_);
  const auto joints = wire::six_revolute_joints(*robot.model, "yaskawa/gp7");
  ForwardSettings out;
  out.host = settings_.host;
  out.hses_port = settings_.hses_port;
  out.servo_on = settings_.servo_on;
  out.inputs = settings_.inputs, out.outputs = settings_.outputs;
  out.frame = forward::frame_of(robot, joints, p.number("line_acceleration"));
  out.pulses = pulses_in(p.text("pulses"));
  out.base_height = p.number("base_height");
  if (!(out.base_height > 0)) out.base_height = base_height(*out.frame.flange);
  out.tool_number = static_cast<int>(p.number("tool_number"));
  out.heartbeat_byte = static_cast<int>(p.number("heartbeat_byte"));
  out.watchdog = nanoseconds(p.number("watchdog_ms") / 1000);
  out.answer = nanoseconds(p.number("answer_ms") / 1000);
  out.timeout = settings_.timeout;
  out.start_timeout = settings_.start_timeout;
  out.period = period_;
  const Nanoseconds at_once = 1'000'000;  // the clock waits
  out.times = {stepped_link_, stepped_link_ ? at_once : nanoseconds(p.number("poll_ms") / 1000),
               settings_.loop_silence};
  p.problems().throw_if_errors();
  flange_ = out.frame.flange;
  readings_ = {};
  forward_ = std::make_unique<ForwardLink>(std::move(out));
}

/// What only MotoROS says is NaN or 0.
ReturnType YaskawaComponent::read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  forward_->fetch();
  const ForwardSample& sample = forward_->sample();
  const HsesStatus& s = sample.status;
  const bool seen = sample.count > 0;
  std::size_t at = show_arm(sample, cycle, kStates, 0, states);
  const auto shows = [seen](bool on) { return !seen ? kUnknown : on ? 1.0 : 0.0; };
  const bool ready = s.servo && s.remote && !s.holds() && !s.alarm && !s.error;
  for (const double value :
       {shows(s.servo), shows(s.play), shows(s.remote), shows(s.running), shows(ready), shows(s.holds()),
        shows(s.alarm), shows(s.error), kUnknown, kUnknown, 0.0, 0.0, 0.0, 0.0})
    states[at++] = value;
  add_signals(sample.inputs, sample.outputs, states.subspan(at));
  return forward_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType YaskawaComponent::write_forward(std::span<const double> commands) noexcept {
  if (forward_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  Outputs outputs;
  std::copy_n(commands.begin() + 6, settings_.outputs.count, outputs.digital.begin());
  forward_->cycle(outputs);
  return judge_joints(commands);
}

}  // namespace polyarm::yaskawa
