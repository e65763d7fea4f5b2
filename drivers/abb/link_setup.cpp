/// How a link begins and ends: options, and the program that lets EGM move the robot.
#include <algorithm>
#include <utility>

#include "drivers/abb/link.hpp"
#include "drivers/abb/rapid.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

Link::Link(LinkSettings settings)
    : StreamLink(settings, settings.stepped, settings.start_timeout),
      settings_(std::move(settings)),
      shaper_(settings_.sampling_ms / 1000.0),
      pacer_(settings_.loop_silence) {}

bool Link::check_controller() {
  if (!identity().recent()) return refuse(Cause::old_software, 0, identity().software);
  if (!identity().guided()) return refuse(Cause::no_option);
  return rws_.has_module(settings_.task, kModuleName) ? true : refuse_rws();
}

/// Only the interface that reaches the controller listens.
bool Link::bind_egm() {
  const std::string address =
      settings_.egm_address.empty() ? rws_.http().own_address() : settings_.egm_address;
  std::string why;
  egm_ = wire::bind_udp(address, settings_.egm_port, why);
  return egm_ ? true : refuse(Cause::port_taken, 0, why);
}

bool Link::open() {
  close();
  const std::lock_guard lock(rws_mutex_);
  fault_.clear();
  refused_.clear();
  current_ = {};
  began_ = realtime::monotonic_now();
  if (!(connect_services() && check_controller() && bind_egm() && read_first())) {
    rws_.close();
    egm_ = Descriptor();
    return false;
  }
  open_ = true;
  begin_session();
  run_egm();
  run_service_thread();
  return true;
}

void Link::close() {
  stop();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  egm_ = Descriptor();
  if (std::exchange(open_, false)) rws_.log_out();
  rws_.close();
}

void Link::begin_session() {
  fresh_ = true;
  steady_ = behind_ = errors_ = 0;
  sign_ = Sign::none;
  asked_ = Sign::none;
  commanded_ = late_ = false;
  current_.behind = 0;
  stop_wanted_ = false;
  unusable_ = Cause::none;
  strange_ = false;
  sequence_ = 0;
  current_.count = answered_ = current_.strangers = 0;
  heard_ = realtime::monotonic_now();
}

void Link::run_egm() {
  quit_ = false;
  thread_ = std::thread([this] { run(); });
}

void Link::halt_threads() {
  quit_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
  halt_service_thread();
}

bool Link::await_running() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                    [this] { return phase_ == Phase::streaming || fault_ || unusable_ != Cause::none; });
  if (phase_ == Phase::streaming) return true;
  lock.unlock();
  halt_threads();
  phase_ = Phase::idle;
  if (fault_) return false;
  if (unusable_ == Cause::egm_error) return refuse_why(unusable_);
  if (unusable_ != Cause::none) return refuse(unusable_, unusable_detail_);
  if (current_.count > 0) return refuse_why(Cause::not_running);
  if (current_.strangers > 0) return refuse(Cause::other_sender);
  return refuse_why(Cause::no_packets, rws_.http().own_address() + ":" + std::to_string(egm_port()));
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::silent);
  if (fault_) return false;
  refused_.clear();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  bool fine = begin_services() && check_panel();
  begin_session();
  if (fine) {
    phase_ = Phase::starting;
    run_egm();
    fine = begin_program(false) && await_running();
  }
  if (!fine) {
    const auto why = refused_.value();
    const std::string said = text();
    halt_threads();
    phase_ = Phase::idle;
    rws_.stop_program();
    refuse(why.cause, why.detail, said);
    begin_session();
    run_egm();
  }
  run_service_thread();
  return fine;
}

void Link::stop() {
  if (phase_ == Phase::idle) return;
  stop_wanted_ = true;
  wake();
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                      [this] { return phase_ == Phase::idle; });
  }
  halt_threads();
  phase_ = Phase::idle;
  {
    const std::lock_guard lock(rws_mutex_);
    rws_.stop_program();
    current_panel_.joints = current_.q;  // those of before the motion are old
    panels_.write(current_panel_);
    read_states_next();
  }
  if (fault_) return;
  begin_session();
  run_egm();
  run_service_thread();
}

}  // namespace polyarm::abb
