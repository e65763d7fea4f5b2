#include "drivers/mujoco/box_contacts.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::drivers {

namespace {
mjfCollision box_box = nullptr;  ///< MuJoCo's own

/// How far the point is outside of the box, along the axis on which it is farthest; negative: inside.
mjtNum outside(const mjModel* m, const mjData* d, int geom, const mjtNum* point) noexcept {
  mjtNum from_middle[3], at[3];
  mju_sub3(from_middle, point, d->geom_xpos + 3 * geom);
  mju_rotVecMatT(at, from_middle, d->geom_xmat + 9 * geom);
  mjtNum most = -m->geom_size[3 * geom];
  for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(at[k]) - m->geom_size[3 * geom + k]);
  return most;
}

/// How far the boxes overlap along that axis of their faces along which they overlap least.
mjtNum overlap(const mjModel* m, const mjData* d, int one, int other) noexcept {
  mjtNum between[3], least = mjMAXVAL;
  mju_sub3(between, d->geom_xpos + 3 * other, d->geom_xpos + 3 * one);
  for (const int box : {one, other})
    for (int k = 0; k < 3; ++k) {
      const mjtNum* column = d->geom_xmat + 9 * box + k;
      const mjtNum axis[3] = {column[0], column[3], column[6]};
      mjtNum along = -std::abs(mju_dot3(axis, between));
      for (const int each : {one, other}) {
        mjtNum own[3];
        mju_rotVecMatT(own, axis, d->geom_xmat + 9 * each);
        for (int i = 0; i < 3; ++i) along += std::abs(own[i]) * m->geom_size[3 * each + i];
      }
      least = std::min(least, along);
    }
  return least;
}

/// No contact is deeper than the least overlap. Its point is between both surfaces, so it is outside of a box
/// by at most the depth: a thin part that is deep in a table is below the point in the middle.
bool is_true(const mjModel* m, const mjData* d, const mjContact& c, int one, int other,
             mjtNum deepest) noexcept {
  if (c.dist > 0) return true;
  constexpr mjtNum kRounding = 1e-5;  // m
  const mjtNum most = -c.dist + kRounding;
  return most <= deepest + 2 * kRounding && outside(m, d, one, c.pos) <= most &&
         outside(m, d, other, c.pos) <= most;
}

int true_box_contacts(const mjModel* m, const mjData* d, mjContact* con, int one, int other,
                      mjtNum margin) noexcept {
  const int count = box_box(m, d, con, one, other, margin);
  if (count == 0) return 0;
  const mjtNum deepest = overlap(m, d, one, other);
  const mjContact* end = std::remove_if(
      con, con + count, [&](const mjContact& c) { return !is_true(m, d, c, one, other, deepest); });
  return static_cast<int>(end - con);
}
}  // namespace

void keep_true_box_contacts() noexcept {
  static const bool once = [] {
    box_box = std::exchange(mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_BOX], true_box_contacts);
    return true;
  }();
  static_cast<void>(once);
}

}  // namespace polyarm::drivers
