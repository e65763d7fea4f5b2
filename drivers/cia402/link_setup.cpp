/// How a link begins and ends: what waits, on the thread of the caller.
#include <algorithm>
#include <chrono>

#include "drivers/cia402/link.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {

namespace {
constexpr std::chrono::seconds kFirstPositions{2}, kUntilStanding{4};
constexpr int kWatchdogAnswer = 50;  // ms
}  // namespace

Link::Link(const Settings& settings)
    : StreamLink("the drives on " + settings.bus.bus),
      settings_(settings),
      done_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

Link::~Link() {
  close();
}

bool Link::open() {
  close();
  watchdog_.stop();  // one that has not finished: this process takes over
  fault_.clear();
  refused_.clear();
  drives_.assign(settings_.joints.size(), {});
  current_ = {};
  samples_.reset(current_);
  troubled_.reset();
  silent_.reset();
  bus_lost_ = false;
  seen_all_ = false;
  try {
    bus_ = open_bus(settings_.bus);
  } catch (const Error& e) {
    return refuse(Cause::no_bus, 0, e.what());
  }
  if (!introduce_all()) {
    bus_.reset();
    return false;
  }
  phase_ = Phase::idle;
  stands_ = true;
  quit_ = false;
  thread_ = std::thread([this] { run(); });
  if (await_first_positions()) return true;
  end_thread();
  leave_drives(false);
  bus_.reset();
  return false;
}

/// All drives are prepared before the first of them is made operational.
bool Link::introduce_all() {
  needs_watchdog_ = settings_.watched == Watched::on;
  Preparation preparation(*bus_, settings_, [this](const CanFrame& frame) { take(frame); });
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    Prepared prepared;
    const std::uint64_t refused = bus_->refused();
    Refusal no = preparation.prepare(j, prepared);
    if (fault_) return false;  // another master
    if (no.cause == Cause::no_answer && bus_->refused() > refused) return refuse(Cause::bus_off);
    if (no) return refuse(no.cause, no.detail, no.text);
    drives_[j].rated_torque = prepared.rated_torque;
    needs_watchdog_ = needs_watchdog_ || (settings_.watched == Watched::automatic && !prepared.watches);
  }
  for (Drive& drive : drives_) drive.seen = false;
  for (const JointSettings& joint : settings_.joints)
    if (const BusState state = bus_->send(nmt(NmtCommand::start, joint.node)); state != BusState::ok) {
      bus_trouble(state);
      if (fault_) return false;
    }
  return true;
}

bool Link::await_first_positions() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kFirstPositions, [this] { return seen_all_ || fault_; });
  if (fault_) return false;
  if (seen_all_) return true;
  lock.unlock();
  end_thread();
  for (std::size_t j = 0; j < drives_.size(); ++j)
    if (!drives_[j].seen) return refuse(Cause::silent, 0, who(settings_.joints[j]));
  return refuse(Cause::all_silent);
}

watchdog::Names Link::watchdog_names() const {
  const std::string& bus = settings_.bus.bus;
  return {kWatchdogProgram,         "the drives on " + bus,         bus,
          "the drives are stopped", "stopped the drives on " + bus, settings_.watchdog_ms};
}

bool Link::start_watchdog() {
  if (!needs_watchdog_) return true;
  const std::lock_guard guard(watch_mutex_);
  if (!watchdog_.running() || watchdog_.listen() != watchdog::Health::fine) {
    WatchdogSettings settings{settings_.bus.bus, kWatchdogAnswer, settings_.watchdog_ms};
    for (const JointSettings& joint : settings_.joints) settings.nodes.push_back(joint.node);
    watchdog_.expect(settings_.watchdog_ms, seconds(settings_.cycle));
    const watchdog::Health health =
        watchdog_.start(settings_.watchdog, words_of(settings), bus_->descriptors());
    if (health != watchdog::Health::fine)
      return refuse(Cause::no_watchdog, 0, watchdog::sentence(health, watchdog_names()));
  }
  const watchdog::Health armed = watchdog_.arm();
  if (armed != watchdog::Health::fine)
    return refuse(Cause::no_watchdog, 0, watchdog::sentence(armed, watchdog_names()));
  armed_ = true;
  return true;
}

bool Link::start() {
  if (fault_ || !thread_.joinable()) return false;
  refused_.clear();
  if (!start_watchdog()) return false;
  std::unique_lock lock(mutex_);
  renew_ = true;
  phase_ = Phase::starting;
  changed_.wait(lock, [this] { return phase_ == Phase::streaming || phase_ == Phase::idle || fault_; });
  if (phase_ == Phase::streaming && !fault_) return true;
  lock.unlock();
  stop();
  return false;
}

void Link::begin_stop() noexcept {
  const std::lock_guard lock(mutex_);
  if (phase_ != Phase::starting && phase_ != Phase::streaming) return;
  phase_ = Phase::ending;
  stands_ = false;
}

void Link::stop() {
  if (!thread_.joinable()) return;
  begin_stop();
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kUntilStanding, [this] { return stands_.load(); });
  }
  const std::lock_guard guard(watch_mutex_);
  if (!armed_.exchange(false) || !watchdog_.running()) return;
  // Drives that were not seen to stop are left to the watchdog.
  if (!stands_ || !stood_)
    watchdog_.make_safe();
  else if (fault_)
    watchdog_.stop();
  else
    watchdog_.disarm();
}

void Link::end_thread() {
  quit_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

void Link::close(bool off) {
  if (thread_.joinable()) {
    hold(false);
    stop();
    end_thread();
    leave_drives(off);
  }
  if (stands_ && stood_)
    watchdog_.stop();
  else
    watchdog_.abandon();
  bus_.reset();
  stands_ = stood_ = true;
  phase_ = Phase::idle;
}

void Link::shut_down() {
  close(settings_.off_on_shutdown);
}

/// Drives that stand no longer wait for this computer. Those that were not seen to stop do: without
/// heartbeats they stop by themselves.
void Link::leave_drives(bool off) {
  if (!bus_ || bus_lost_ || !stands_ || !stood_) return;
  Settings settings = settings_;
  settings.answer = std::min<Nanoseconds>(settings.answer, 200'000'000);
  Preparation preparation(*bus_, settings, {});
  SdoClient sdo(*bus_, settings.answer);
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    if (lost(drives_[j]) || !drives_[j].seen) continue;
    if (off) sdo.write(settings.joints[j].node, object::kControlword, 2, control::kDisableVoltage);
    preparation.forget_heartbeat(j);
  }
}

// --- drives in this process -------------------------------------------------------------------------------

void Link::hold(bool on) noexcept {
  if (stepped_.exchange(on) == on) return;
  clock_changed_ = true;
  wake();
}

void Link::exchange(Nanoseconds timeout) noexcept {
  calm(done_.number());
  ++asked_;
  wake();
  wire::wait_readable(done_.number(), timeout);
  fetch();
}

}  // namespace polyarm::cia402
