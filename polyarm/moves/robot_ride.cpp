/// Moves of a robot that follows a moving frame, or yields to forces.
#include "polyarm/moves/robot_motion.hpp"

namespace polyarm::moves {

void RobotMotion::begin_ride(const MovingFrame& frame, double travel, double lead) {
  riding_ = true, ride_ends_ = false;
  ride_->begin(frame, travel, planned_, lead);
}

void RobotMotion::fail_ride(const Problem& why) {
  if (!riding_) return;
  ride_ends_ = true;
  fail_rest(why);
}

/// The moves that are left fail with this problem.
void RobotMotion::fail_rest(const Problem& why) {
  const std::uint64_t first = settled_ + 1;
  const bool moves = !at_end();
  give_up_apart();
  waiting_.clear(), ready_.clear();
  job_ = nullptr;
  if (goal_ != 0) active_.ends->store(true, std::memory_order_relaxed);
  if (!moves) return;
  end_badly(first, MoveState::discarded);
  ended_badly_[first] = MoveState::failed;
  problems_[first] = why;
}

/// Lets the robot come to rest when it has arrived, and takes up where it stands.
void RobotMotion::look_at_ride() {
  if (!riding_) return;
  if (ride_ends_ && at_end()) ride_->release();
  if (!ride_->over()) return;
  riding_ = ride_ends_ = false;
  planned_.assign(ride_->joints().begin(), ride_->joints().end());
  if (!apart_) return;  // the place to which a trap would return has gone on with the frame
  apart_->held = planned_;
  give_up_apart();
}

void RobotMotion::begin_compliance(const ComplianceSettings& settings) {
  comply_->begin(settings, planned_);
  complying_ = true, compliance_ends_ = false;
}

void RobotMotion::fail_compliance(const Problem& why) {
  if (!complying_) return;
  compliance_ends_ = true;
  fail_rest(why);
}

/// Ends it when the robot has arrived, and takes up where it stands.
void RobotMotion::look_at_compliance() {
  if (!complying_) return;
  if (compliance_ends_ && at_end()) comply_->release();
  if (!comply_->over()) return;
  complying_ = compliance_ends_ = false;
  planned_.assign(comply_->joints().begin(), comply_->joints().end());
  if (!apart_) return;  // the place to which a trap would return is no longer the robot's
  apart_->held = planned_;
  give_up_apart();
}

}  // namespace polyarm::moves
