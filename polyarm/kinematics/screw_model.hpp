#pragma once
/// Constants of a chain in the layout of its kernels, and the table of kernels. Private to this room.
#include <cstddef>
#include <cstdint>

#include "polyarm/base/pose.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

inline constexpr std::size_t kScrewBlock = 8;
inline constexpr std::size_t kMostVariables = 128;

/// The reference axis that a step turns about: one of three, any other direction, or none (it slides).
enum class Turn { x, y, z, any, none };

/// One moving joint. Vectors are in the reference axes, where all joint values are zero.
struct ScrewStep {
  Turn turn = Turn::none;
  unsigned along = 0;  ///< bit mask of the components of p that are not zero
  std::size_t joint = 0;
  double ratio = 1;         ///< its value is ratio * q[joint]
  double h[3] = {0, 0, 0};  ///< unit vector along the axis
  double p[3] = {0, 0, 0};  ///< from a point of the previous axis (at first: the base) to a point of this one
};

/// Eight steps side by side; unused entries of the last block have ratio 0.
struct alignas(64) ScrewBlock {
  double ratio[kScrewBlock] = {};
  double h[3][kScrewBlock] = {};
  double turns[kScrewBlock] = {};  ///< 1, or 0 for a sliding step
  std::uint32_t joint[kScrewBlock] = {};
  bool any = false;     ///< at least one step turns about Turn::any
  bool slides = false;  ///< at least one step slides
};

struct ScrewModel {
  const ScrewStep* step = nullptr;
  const ScrewBlock* block = nullptr;
  std::size_t steps = 0, joints = 0;
  double start[9] = {};        ///< columns of the rotation from reference axes to the world
  double base[3] = {};         ///< in the world; a sweep counts positions from here
  double tool[9] = {};         ///< columns of the TCP's rotation in the reference axes, at zero
  double tool_offset[3] = {};  ///< from the last axis's point to the TCP, in the reference axes, at zero
  Turn tool_axis[3] = {Turn::any, Turn::any, Turn::any};  ///< the reference axis of each of its columns
  unsigned tool_along = 0;  ///< bit mask of the components of tool_offset that are not zero
  bool distinct = false;    ///< no joint moves two steps
  bool packed = false;      ///< distinct, and step k belongs to joint k
};

/// The layout of a batch of joint states: the value of joint j in state s is q[j * joint_stride + s *
/// state_stride].
struct StateBatch {
  const double* q = nullptr;
  std::size_t count = 0, joint_stride = 1, state_stride = 1;
};

struct ScrewKernels {
  void (*forward)(const ScrewModel&, const double* q, Pose& out) noexcept;
  /// J: 6 rows of `joints`, world axes at the TCP.
  void (*jacobian)(const ScrewModel&, const double* q, double* J, Pose& out) noexcept;
  void (*forward_batch)(const ScrewModel&, const StateBatch&, Pose* out) noexcept;
  /// J[(row * joints + joint) * count + state].
  void (*jacobian_batch)(const ScrewModel&, const StateBatch&, double* J, Pose* out) noexcept;
};

namespace portable {
extern const ScrewKernels kScrewKernels;
}
namespace avx2 {
extern const ScrewKernels kScrewKernels;
}
namespace avx512 {
extern const ScrewKernels kScrewKernels;
}
const ScrewKernels& screw_kernels(InstructionSet set) noexcept;

}  // namespace polyarm::kinematics
