#pragma once
/// What components share that stream joint positions to one robot of at most N axes.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::wire {

/// Configuring opens the link, activating starts it, and every end stops it. A derived class makes the link
/// in on_init(). `Link` is a wire::LinkBase<Cause> with open(), close(), start(), stop(), rate(),
/// command(move, joints) and sample().q; `Cause` has jump and wrong_rate.
template <class Link, class Cause, std::size_t N = 6>
class StreamComponent : public hardware::Component {
 public:
  hardware::CallbackReturn on_configure() override {
    active_ = false;
    if (!link_->open()) return hardware::CallbackReturn::failure;
    const double cell = 1 / seconds(period_);
    if (paced_ && std::abs(cell - link_->rate()) > 0.01 * link_->rate()) {
      link_->fail(Cause::wrong_rate, static_cast<int>(std::lround(link_->rate())));
      link_->close();
      return hardware::CallbackReturn::failure;
    }
    return hardware::CallbackReturn::success;
  }
  hardware::CallbackReturn on_activate() override {
    steps_.begin();
    if (!link_->start()) return hardware::CallbackReturn::failure;
    active_ = true;
    return hardware::CallbackReturn::success;
  }
  hardware::CallbackReturn on_deactivate() override {
    active_ = false;
    link_->stop();
    return hardware::CallbackReturn::success;
  }
  hardware::CallbackReturn on_cleanup() override {
    active_ = false;
    if (link_) link_->close();
    return hardware::CallbackReturn::success;
  }
  hardware::CallbackReturn on_shutdown() override { return on_cleanup(); }
  hardware::CallbackReturn on_error() override { return on_cleanup(); }
  hardware::ReturnType perform_command_mode_switch(std::span<const std::string>,
                                                   std::span<const std::string>) noexcept override {
    steps_.begin();
    return hardware::ReturnType::ok;
  }
  bool real() const noexcept override { return true; }
  bool paces() const noexcept override { return paced_; }
  bool await_cycle(Nanoseconds timeout) noexcept override { return link_ && link_->await(timeout); }
  std::string reason() const override { return link_ ? link_->reason() : std::string(); }

  /// Why it failed last; none after configuring. Any thread.
  Cause cause() const noexcept {
    return !link_ ? Cause::none : link_->cause() != Cause::none ? link_->cause() : link_->refused();
  }

 protected:
  Link* link() noexcept { return link_.get(); }
  /// Hands the positions of the joints, with which `commands` begins, to the link, unless one of them jumps.
  /// Control thread.
  hardware::ReturnType write_joints(std::span<const double> commands, std::size_t count = N) noexcept {
    std::array<double, N> joints{};
    std::copy_n(commands.begin(), count, joints.begin());
    if (std::any_of(joints.begin(), joints.end(), [](double q) { return !std::isfinite(q); })) {
      link_->command(false, {});  // without a command for one joint the whole arm holds
      steps_.begin();
      return hardware::ReturnType::ok;
    }
    if (const auto joint = steps_.jumps(joints, link_->sample().q)) {
      link_->fail(Cause::jump, *joint);
      return hardware::ReturnType::error;
    }
    link_->command(true, joints);
    return hardware::ReturnType::ok;
  }

  bool paced_ = true;
  bool follows_ = false;  ///< the loop follows the packets though it is not paced by them
  Nanoseconds period_ = 0;
  std::unique_ptr<Link> link_;
  std::atomic<bool> active_{false};  ///< the control thread's
  StepCheckOf<N> steps_;
};

}  // namespace polyarm::wire
