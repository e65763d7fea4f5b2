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

/// The point of a contact is in the middle between both surfaces. So it is outside of a box by at most half
/// the depth, and a box cannot be deeper in another than it is thick.
bool is_true(const mjModel* m, const mjData* d, const mjContact& c, int one, int other) noexcept {
  if (c.dist > 0) return true;
  constexpr mjtNum kRounding = 1e-5;  // m
  const mjtNum* a = m->geom_size + 3 * one;
  const mjtNum* b = m->geom_size + 3 * other;
  const mjtNum thinnest = std::min(*std::min_element(a, a + 3), *std::min_element(b, b + 3));
  const mjtNum most = std::min(-c.dist / 2, thinnest) + kRounding;
  return outside(m, d, one, c.pos) <= most && outside(m, d, other, c.pos) <= most;
}

int true_box_contacts(const mjModel* m, const mjData* d, mjContact* con, int one, int other,
                      mjtNum margin) noexcept {
  const int count = box_box(m, d, con, one, other, margin);
  const mjContact* end =
      std::remove_if(con, con + count, [&](const mjContact& c) { return !is_true(m, d, c, one, other); });
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
