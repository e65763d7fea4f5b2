#include "drivers/mujoco/first_half.hpp"

#include <algorithm>
#include <cstring>

namespace polyarm::drivers {

namespace {
bool stays_as_it_is(const mjtNum* quaternion) noexcept {
  mjtNum again[4];
  std::copy_n(quaternion, 4, again);
  mju_normalize4(again);
  return std::memcmp(again, quaternion, sizeof again) == 0;
}
}  // namespace

bool quaternions_stay(const mjModel* m, const mjData* d) noexcept {
  for (int i = 0; i < m->nmocap; ++i)
    if (!stays_as_it_is(d->mocap_quat + 4 * i)) return false;
  for (int i = 0; i < m->njnt; ++i) {
    const int type = m->jnt_type[i];
    if (type != mjJNT_BALL && type != mjJNT_FREE) continue;
    if (!stays_as_it_is(d->qpos + m->jnt_qposadr[i] + (type == mjJNT_FREE ? 3 : 0))) return false;
  }
  return true;
}

#if mjVERSION_HEADER >= 220 && mjVERSION_HEADER < 230

namespace {
/// mj_fwdPosition after its first line, mj_kinematics.
void rest_of_position_stage(const mjModel* m, mjData* d) noexcept {
  mj_comPos(m, d);
  mj_camlight(m, d);
  mj_tendon(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  mj_collision(m, d);
  mj_makeConstraint(m, d);
  mj_transmission(m, d);
  mj_projectConstraint(m, d);
}
}  // namespace

void first_half_of_step(const mjModel* m, mjData* d, Known known) noexcept {
  if (mjcb_control || known == Known::nothing || !quaternions_stay(m, d)) return mj_step1(m, d);
  const int resets = d->warning[mjWARN_BADQPOS].number + d->warning[mjWARN_BADQVEL].number;
  mj_checkPos(m, d);
  mj_checkVel(m, d);
  // Positions or velocities that are not finite reset the simulation.
  if (d->warning[mjWARN_BADQPOS].number + d->warning[mjWARN_BADQVEL].number != resets) {
    mj_kinematics(m, d);
    known = Known::kinematics;
  }
  if (known == Known::kinematics) rest_of_position_stage(m, d);
  mj_sensorPos(m, d);
  mj_energyPos(m, d);
  mj_fwdVelocity(m, d);
  mj_sensorVel(m, d);
  mj_energyVel(m, d);
}

#else

void first_half_of_step(const mjModel* m, mjData* d, Known) noexcept {
  mj_step1(m, d);
}

#endif

}  // namespace polyarm::drivers
