#pragma once
/// Constants of a chain as its kernels read them, and the table of kernels. Used inside this room only.
#include <cstddef>
#include <cstdint>

#include "polyarm/base/pose.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

inline constexpr std::size_t kScrewBlock = 8;
inline constexpr std::size_t kMostVariables = 128;

/// About which axis of the reference axes a step turns: one of them, any direction, or it slides.
enum class Turn { x, y, z, any, none };

/// One moving joint. Vectors are in the reference axes, where all joint values are zero.
struct ScrewStep {
  Turn turn = Turn::none;
  unsigned along = 0;  ///< which components of p are not nothing (bits)
  std::size_t joint = 0;
  double ratio = 1;         ///< its value is ratio * q[joint]
  double h[3] = {0, 0, 0};  ///< unit vector along the axis
  double p[3] = {0, 0, 0};  ///< from a point of the axis before (at first: the base) to a point of this one
};

/// Eight steps side by side; what is left over of the last block has ratio 0.
struct alignas(64) ScrewBlock {
  double ratio[kScrewBlock] = {};
  double h[3][kScrewBlock] = {};
  double turns[kScrewBlock] = {};  ///< 1, or 0 where it slides
  std::uint32_t joint[kScrewBlock] = {};
  bool any = false;     ///< one of them turns about Turn::any
  bool slides = false;  ///< one of them slides
};

struct ScrewModel {
  const ScrewStep* step = nullptr;
  const ScrewBlock* block = nullptr;
  std::size_t steps = 0, joints = 0;
  double start[9] = {};        ///< columns of the rotation from reference axes to the world
  double base[3] = {};         ///< in the world; positions of a sweep are counted from here
  double tool[9] = {};         ///< columns of the TCP's rotation in the reference axes, at zero
  double tool_offset[3] = {};  ///< from the last axis's point to the TCP, in the reference axes, at zero
  Turn tool_axis[3] = {Turn::any, Turn::any, Turn::any};  ///< which reference axis each of its columns is
  unsigned tool_along = 0;  ///< which components of tool_offset are not nothing (bits)
  bool distinct = false;    ///< no joint moves two steps
  bool packed = false;      ///< and step k is of joint k, for all joints
};

/// Joint states as the batch reads them: value of joint j in state s at q[j * joint_stride + s *
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
