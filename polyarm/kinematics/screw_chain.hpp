#pragma once
/// A chain of axes compiled for speed: product of exponentials, with the sines and cosines of all joints in
/// one evaluation, for one joint state or many at once. Chain uses it; use it directly for batches.
/// Everything is SI: metres, radians, poses in the world.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/simd/instruction_set.hpp"
#include "polyarm/kinematics/screw_model.hpp"

namespace polyarm::kinematics {

/// What the six rows of a Jacobian mean; the first three are linear, the last three angular velocity per
/// joint velocity. local_world_aligned: of the TCP's origin, in world axes. body: of the same, in the TCP's
/// axes. space: of the point that is at the world's origin, in world axes (the spatial twist).
enum class JacobianFrame { local_world_aligned, body, space };

/// How the states of a batch lie in memory. joint_after_joint: value of joint j in state s at q[j * states +
/// s]; fastest. state_after_state: at q[s * joints + j].
enum class BatchLayout { joint_after_joint, state_after_state };

/// One moving joint as it stands where all joint values are zero, in the world. Its value is
/// ratio * q[joint].
struct ScrewAxis {
  std::size_t joint = 0;
  bool slides = false;
  double ratio = 1;
  Vec3 direction;  ///< unit
  Vec3 point;      ///< anywhere on the axis
};

/// Thread: const and without hidden state, so any thread. Nothing but the constructor allocates or throws;
/// all else may be called in the control cycle. Precondition: spans have the sizes stated. A batch and one
/// state after the other give the same bits; two instruction sets differ in the last digits.
class ScrewChain {
 public:
  ScrewChain() = default;
  /// `axes` from the base outwards; `joints` (at most 32) values make a joint state; T_world_tcp is the TCP's
  /// pose at zero. Positions lose digits with their distance from `base`, so put it near.
  ScrewChain(std::span<const ScrewAxis> axes, std::size_t joints, const Pose& T_world_tcp, const Vec3& base,
             InstructionSet set = fastest_instructions());

  std::size_t joints() const noexcept { return model_.joints; }
  InstructionSet instructions() const noexcept { return set_; }

  /// The TCP's pose.
  Pose forward(std::span<const double> q) const noexcept;
  /// 6 rows by joints() columns, row after row, into `J`. Returns the TCP's pose.
  Pose jacobian(std::span<const double> q, std::span<double> J,
                JacobianFrame frame = JacobianFrame::local_world_aligned) const noexcept;

  /// One pose for each state; `out.size()` is how many there are.
  void forward_batch(std::span<const double> q, BatchLayout layout, std::span<Pose> out) const noexcept;
  /// J[(row * joints() + joint) * out.size() + state], local and world-aligned.
  void jacobian_batch(std::span<const double> q, BatchLayout layout, std::span<double> J,
                      std::span<Pose> out) const noexcept;

 private:
  struct Steps {
    std::vector<ScrewStep> step;
    std::vector<ScrewBlock> block;
  };
  StateBatch batch_of(std::span<const double> q, BatchLayout layout, std::size_t count) const noexcept;

  ScrewModel model_;
  std::shared_ptr<const Steps> steps_;  ///< what model_ points to; shared by copies, which never change it
  InstructionSet set_ = InstructionSet::portable;
  const ScrewKernels* kernels_ = nullptr;
};

}  // namespace polyarm::kinematics
