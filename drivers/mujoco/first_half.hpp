#pragma once
/// The first half of a step of MuJoCo (mj_step1), without work whose results are known. Control thread.
#include <mujoco/mujoco.h>

namespace polyarm::drivers {

/// How much of `d` belongs to its present positions (qpos, mocap_pos, mocap_quat) and to the present model.
enum class Known {
  nothing,
  kinematics,  ///< poses of bodies, geometries and sites, as mj_kinematics leaves them
  positions,   ///< also contacts, constraints and all else that mj_fwdPosition leaves
};

/// Would mj_kinematics leave qpos and mocap_quat as they are? It normalizes quaternions, and the last bit of
/// a normalized one may change once more.
bool quaternions_stay(const mjModel* m, const mjData* d) noexcept;

/// Leaves the bits in `d` that mj_step1 would leave from the same `d`. Other versions of MuJoCo than 2.2
/// order the stages differently; there it is mj_step1.
void first_half_of_step(const mjModel* m, mjData* d, Known known) noexcept;

}  // namespace polyarm::drivers
