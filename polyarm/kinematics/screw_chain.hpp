#pragma once
/// A chain of axes compiled for speed: product of exponentials that evaluates the sines and cosines of all
/// joints at once, for one joint state or for many. Chain uses it; use it directly for batches. SI units:
/// metres, radians; poses in the world frame.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/simd/instruction_set.hpp"
#include "polyarm/kinematics/screw_model.hpp"

namespace polyarm::kinematics {

/// The frame of a Jacobian; the first three rows are linear velocity, the last three angular velocity, per
/// joint velocity. local_world_aligned: velocity of the TCP's origin in world axes. body: the same in the
/// axes of the TCP. space: velocity of the point at the world's origin, in world axes (the spatial twist).
enum class JacobianFrame { local_world_aligned, body, space };

/// Memory layout of a batch. joint_after_joint: the value of joint j in state s is q[j * states + s];
/// fastest. state_after_state: it is q[s * joints + j].
enum class BatchLayout { joint_after_joint, state_after_state };

/// One moving joint at zero joint values, in the world. Its value is ratio * q[joint].
struct ScrewAxis {
  std::size_t joint = 0;
  bool slides = false;
  double ratio = 1;
  Vec3 direction;  ///< unit
  Vec3 point;      ///< any point on the axis
};

/// Thread: const and without hidden state, so any thread. Only the constructor allocates or throws; all other
/// functions may run in the control cycle. Precondition: spans have the sizes stated. A batch gives the same
/// bits as single calls; instruction sets differ in the last digits.
class ScrewChain {
 public:
  ScrewChain() = default;
  /// `axes` are ordered from the base outwards; a joint state has `joints` (at most 32) values; T_world_tcp
  /// is the TCP's pose at zero. Positions lose digits with their distance from `base`, so choose a point near
  /// the arm.
  ScrewChain(std::span<const ScrewAxis> axes, std::size_t joints, const Pose& T_world_tcp, const Vec3& base,
             InstructionSet set = fastest_instructions());

  std::size_t joints() const noexcept { return model_.joints; }
  InstructionSet instructions() const noexcept { return set_; }

  /// The pose of the TCP.
  Pose forward(std::span<const double> q) const noexcept;
  /// Writes 6 rows by joints() columns, row-major, into `J`. Returns the pose of the TCP.
  Pose jacobian(std::span<const double> q, std::span<double> J,
                JacobianFrame frame = JacobianFrame::local_world_aligned) const noexcept;

  /// Computes one pose for each of `out.size()` states.
  void forward_batch(std::span<const double> q, BatchLayout layout, std::span<Pose> out) const noexcept;
  /// J[(row * joints() + joint) * out.size() + state], in the local_world_aligned frame.
  void jacobian_batch(std::span<const double> q, BatchLayout layout, std::span<double> J,
                      std::span<Pose> out) const noexcept;

 private:
  struct Steps {
    std::vector<ScrewStep> step;
    std::vector<ScrewBlock> block;
  };
  StateBatch batch_of(std::span<const double> q, BatchLayout layout, std::size_t count) const noexcept;

  ScrewModel model_;
  std::shared_ptr<const Steps> steps_;  ///< data that model_ points to; copies share it and never change it
  InstructionSet set_ = InstructionSet::portable;
  const ScrewKernels* kernels_ = nullptr;
};

}  // namespace polyarm::kinematics
