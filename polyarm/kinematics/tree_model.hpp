#pragma once
/// Constants of a tree in the layout of the dynamics kernels, and the table of kernels. Private to this room.
#include <cstddef>

#include "polyarm/kinematics/screw_model.hpp"

namespace polyarm::kinematics {

/// The motion of a step. turn_*: turns about its h, which is that reference axis (any: another direction).
/// slide: moves along h. ball: turns by a quaternion; its velocity is about h. held: the second and third
/// axis of a ball; it has a velocity about h but no value of its own.
enum class Motion { turn_x, turn_y, turn_z, turn_any, slide, ball, held };

/// One degree of freedom and the body behind it. Vectors are in the reference axes at zero joint values.
struct TreeStep {
  Motion motion = Motion::turn_any;
  int parent = -1;               ///< step; -1: the world
  std::size_t position = 0;      ///< of its value (ball: of the quaternion x y z w) in q
  std::size_t velocity = 0;      ///< of its rate in v
  double ratio = 1;              ///< ratio * q[position] is its value
  double h[3] = {0, 0, 0};       ///< unit
  double p[3] = {0, 0, 0};       ///< from the parent's origin to its own
  double ball_axes[9] = {};      ///< columns: the axes of the quaternion
  double mass = 0;               ///< kg
  double moment[3] = {0, 0, 0};  ///< mass times centre of mass, from its origin
  double inertia[6] = {};        ///< about its origin: xx xy xz yy yz zz
};

struct TreeModel {
  const TreeStep* step = nullptr;
  std::size_t steps = 0, positions = 0, velocities = 0;
  double gravity[3] = {0, 0, 0};  ///< m/s^2, in the reference axes
};

/// Inputs and results of a batch in one layout: value i of state s is at i * value_stride + s * state_stride.
/// A null input counts as zeros.
struct TreeJob {
  const double *q = nullptr, *v = nullptr, *in = nullptr;  ///< in: accelerations or torques
  double* out = nullptr;
  std::size_t count = 0;
  bool state_after_state = true;
};

/// `scratch` has scratch_lanes(model) vectors of 64 bytes with 64-byte alignment.
struct TreeKernels {
  std::size_t (*scratch_lanes)(const TreeModel&) noexcept;
  void (*inverse)(const TreeModel&, double* scratch, const TreeJob&) noexcept;
  /// out: velocities * velocities values, row-major.
  void (*mass)(const TreeModel&, double* scratch, const TreeJob&) noexcept;
  /// True if the mass matrix is positive definite in all states.
  bool (*forward)(const TreeModel&, double* scratch, const TreeJob&) noexcept;
};

namespace portable {
namespace many {
extern const TreeKernels kTreeKernels;
}
namespace single {
extern const TreeKernels kTreeKernels;
}
}  // namespace portable
namespace avx2 {
namespace many {
extern const TreeKernels kTreeKernels;
}
namespace single {
extern const TreeKernels kTreeKernels;
}
}  // namespace avx2
namespace avx512 {
namespace many {
extern const TreeKernels kTreeKernels;
}
namespace single {
extern const TreeKernels kTreeKernels;
}
}  // namespace avx512

}  // namespace polyarm::kinematics
