#pragma once
/// What components share that stream joints, or hand over moves with `motion: forward`.
#include <limits>
#include <memory>
#include <string>

#include "drivers/forward/readings.hpp"
#include "drivers/wire/forward_watch.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::forward {

/// `Stream` is a wire::StreamComponent. In forward mode the derived class makes `forward_` and `flange_` in
/// on_init(), and no link_. `Link` is a wire::LinkBase<Cause> with open(), close(), start(), stop() and
/// moves(), an object that is a hardware::ForwardMoves; `Cause` has joint_commands. Threads as of
/// hardware::Component.
template <class Stream, class Link, class Cause>
class ForwardComponent : public Stream, public hardware::TakesMoves {
 public:
  using CallbackReturn = hardware::CallbackReturn;

  CallbackReturn on_configure() override {
    if (!forward_) return Stream::on_configure();
    this->active_ = false;
    return forward_->open() ? CallbackReturn::success : CallbackReturn::failure;
  }
  CallbackReturn on_activate() override {
    if (!forward_) return Stream::on_activate();
    watch_.begin();
    if (!forward_->start()) return CallbackReturn::failure;
    this->active_ = true;
    return CallbackReturn::success;
  }
  CallbackReturn on_deactivate() override {
    if (!forward_) return Stream::on_deactivate();
    this->active_ = false;
    forward_->stop();
    return CallbackReturn::success;
  }
  CallbackReturn on_cleanup() override {
    if (!forward_) return Stream::on_cleanup();
    this->active_ = false;
    forward_->close();
    return CallbackReturn::success;
  }
  bool await_cycle(Nanoseconds timeout) noexcept override {
    return forward_ ? forward_->await(timeout) : Stream::await_cycle(timeout);
  }
  std::string reason() const override { return forward_ ? forward_->reason() : Stream::reason(); }
  hardware::ForwardMoves* forward_moves(std::uint32_t layout) noexcept override {
    return layout == hardware::kForwardLayout && forward_ ? &forward_->moves() : nullptr;
  }
  /// Why it failed last; none after configuring. Any thread.
  Cause cause() const noexcept {
    if (!forward_) return Stream::cause();
    return forward_->cause() != Cause::none ? forward_->cause() : forward_->refused();
  }

 protected:
  Link* forward() noexcept { return forward_.get(); }
  /// The first states: position and velocity of each joint, NaN for the others of its `of_joint`; then the
  /// pose of the flange, `height` m above the origin of its coordinates. NaN before the first reading.
  /// Returns how many they are. Control thread.
  template <class Sample>
  std::size_t show_arm(const Sample& sample, const hardware::Cycle& cycle, std::size_t of_joint,
                       double height, std::span<double> states) noexcept {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    const bool seen = sample.count > 0;
    const Six& q = readings_.at(sample.q, sample.count, cycle);
    std::size_t at = 0;
    for (std::size_t j = 0; j < q.size(); ++j) {
      states[at++] = seen ? q[j] : kUnknown;
      states[at++] = seen ? sample.dq[j] : kUnknown;
      for (std::size_t k = 2; k < of_joint; ++k) states[at++] = kUnknown;
    }
    const Pose flange = flange_->forward(q);
    const Vec3& p = flange.position;
    const Quaternion& r = flange.rotation;
    for (const double value : {p.x, p.y, p.z - height, r.x, r.y, r.z, r.w})
      states[at++] = seen ? value : kUnknown;
    return at;
  }
  /// An error if another controller commands the joints. Control thread.
  hardware::ReturnType judge_joints(std::span<const double> commands) noexcept {
    const auto joint = watch_.strays(commands, readings_.shown());
    if (!joint) return hardware::ReturnType::ok;
    forward_->fail(Cause::joint_commands, *joint);
    return hardware::ReturnType::error;
  }

  std::unique_ptr<Link> forward_;                    ///< instead of link_, in forward mode
  std::shared_ptr<const kinematics::Chain> flange_;  ///< in the base
  Readings readings_;                                ///< the control thread's
  wire::ForwardWatch watch_;
};

}  // namespace polyarm::forward
