/// How a link in forward mode begins and ends.
#include <algorithm>
#include <chrono>
#include <limits>

#include "drivers/fanuc/forward_link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

ForwardSample::ForwardSample() noexcept {
  inputs.fill(std::numeric_limits<double>::quiet_NaN());
  outputs.fill(std::numeric_limits<double>::quiet_NaN());
}

ForwardLink::ForwardLink(ForwardSettings settings)
    : RmiLink("the controller at " + settings.host, settings.connect_timeout),
      settings_(std::move(settings)) {}

/// The outputs keep the states that they have.
bool ForwardLink::read_outputs() {
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto answer = command_of("FRC_ReadIOPort", RmiLine("Command", "FRC_ReadIOPort")
                                                         .text("PortType", "DO")
                                                         .number("PortNumber", settings_.outputs.first + i));
    if (!answer) return false;
    if (answer->error() != 0) return refuse(Cause::io_refused, answer->error());
    current_.outputs[static_cast<std::size_t>(i)] =
        answer->number("PortValue") != 0 || answer->text("PortValue") == "ON";
  }
  return true;
}

bool ForwardLink::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  still_ = 0;
  if (!connect_rmi(settings_.host, settings_.rmi_port, false) || !read_outputs()) {
    close();
    return false;
  }
  samples_.write(current_);
  run_thread();
  const bool stepped = settings_.stepped;
  if (stepped && !exchange(settings_.connect_timeout)) {
    refuse(Cause::rmi_silent, 0, "FRC_ReadJointAngles");
    close();
    return false;
  }
  return true;
}

void ForwardLink::close() {
  stop();
  halt_thread();
  rmi_.close(rmi_gone_ ? 0 : settings_.connect_timeout);
}

void ForwardLink::run_thread() {
  quit_ = rmi_gone_ = false;
  asked_ = Asked::nothing;
  round_ = Round::none;
  turn_ = 0;
  next_round_ = 0;
  thread_ = std::thread([this] { run(); });
}

void ForwardLink::halt_thread() {
  if (!thread_.joinable()) return;
  quit_ = true;
  wake();
  thread_.join();
}

bool ForwardLink::start() {
  if (!thread_.joinable()) return refuse(Cause::rmi_closed);
  if (fault_) return false;
  refused_.clear();
  halt_thread();
  const auto status = command_of("FRC_GetStatus");
  bool fine = status.has_value();
  if (fine && status->number("TPMode") != 0) fine = refuse(Cause::teach_mode);
  fine = fine && clear_alarms(settings_.start_timeout) && initialize();
  if (fine) {
    moves_.forget();
    sequence_ = 1;
    percent_ = 0;
    errors_ = begins_ = 0;
    begin_after_ = 0;
    refusal_ = {0, ""};
    suspected_ = configuration_known_ = false;
    aborted_ = paused_ = false;
    tool_.reset(), tool_asked_.reset();
    outputs_.fetch();  // what was wanted before counts no more
    wanted_ = Outputs();
    pace_ = 0;
    cycles_ = cycles_seen_ = 0;
    phase_ = Phase::active;
  }
  run_thread();
  return fine;
}

/// Ends what remote motion is left. The thread is halted.
void ForwardLink::end_remote_motion() {
  phase_ = Phase::idle;
  moves_.forget();
  if (rmi_ && !rmi_gone_ && !aborted_)
    rmi_.ask("Command", "FRC_Abort", {"Command", "FRC_Abort"}, settings_.connect_timeout);
}

void ForwardLink::stop() {
  if (phase_ != Phase::active) return;
  own_rounds_ = true;
  clear();
  {
    std::unique_lock lock(mutex_);
    const auto over = [this] {
      if (rmi_gone_) return true;
      return fault_ ? aborted_.load() && at_rest_.load() : at_rest_.load() && !moves_.clearing();
    };
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(settings_.connect_timeout);
    while (!over() && std::chrono::steady_clock::now() < end)
      changed_.wait_for(lock, std::chrono::milliseconds(5));
  }
  halt_thread();
  own_rounds_ = false;
  const bool gone = rmi_gone_;
  end_remote_motion();
  if (fault_ || gone) return;
  run_thread();
}

}  // namespace polyarm::fanuc
