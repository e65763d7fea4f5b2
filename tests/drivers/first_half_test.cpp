#ifdef POLYARM_MUJOCO

#include "drivers/mujoco/first_half.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "drivers/mujoco/mjcf.hpp"
#include "drivers/mujoco/model_set.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::drivers {
namespace {

using test::cube;
using test::Stage;

/// Two links swing and hit two cubes, which fall onto a table.
Stage busy_cell() {
  Stage out;
  out.model = test::two_links();
  out.scene = test::table();
  out.scene.parts = {cube("a", {0.3, 0, 0.3}), cube("b", {0.31, 0.01, 0.4})};
  return out;
}

/// A model with all parts awake at their places.
ModelView& start(ModelSet& set, const Stage& stage) {
  ModelView& view = set.view(set.size() - 1);
  view.place(0, {0.4, -0.3});
  for (std::size_t i = 0; i < stage.scene.parts.size(); ++i) {
    mjtNum* q = view.d()->qpos + view.slot[i].qpos;
    put(q, stage.scene.parts[i].start.position);
    put(q + 3, from_rpy(0.3, 0.2, 0.1));
    put(view.d()->mocap_pos + 3 * view.twin_mocap[i], Vec3{0, 0, -50});
  }
  return view;
}

template <typename T>
bool same(const T* a, const T* b, int count) {
  return std::memcmp(a, b, sizeof(T) * static_cast<std::size_t>(count)) == 0;
}

void expect_same(const ModelView& one, const ModelView& other) {
  const mjModel* m = one.m();
  const mjData *a = one.d(), *b = other.d();
  EXPECT_TRUE(same(a->qpos, b->qpos, m->nq));
  EXPECT_TRUE(same(a->qvel, b->qvel, m->nv));
  EXPECT_TRUE(same(a->qfrc_bias, b->qfrc_bias, m->nv));
  EXPECT_TRUE(same(a->cvel, b->cvel, 6 * m->nbody));
  EXPECT_TRUE(same(a->xpos, b->xpos, 3 * m->nbody));
  EXPECT_TRUE(same(a->geom_xmat, b->geom_xmat, 9 * m->ngeom));
  ASSERT_EQ(a->ncon, b->ncon);
  ASSERT_EQ(a->nefc, b->nefc);
  for (int i = 0; i < a->ncon; ++i) EXPECT_TRUE(same(a->contact[i].pos, b->contact[i].pos, 3));
  EXPECT_TRUE(same(a->efc_aref, b->efc_aref, a->nefc));
}

TEST(FirstHalfOfAStep, LeavesTheBitsOfMujocosOwn) {
  const Stage stage = busy_cell();
  ModelSet plain_set(stage.context(), 1e-3), quick_set(stage.context(), 1e-3);
  ModelView &plain = start(plain_set, stage), &quick = start(quick_set, stage);
  Known known = Known::nothing;
  int contacts = 0;
  for (int k = 0; k < 1500 && !testing::Test::HasFailure(); ++k) {
    mj_step1(plain.m(), plain.d());
    first_half_of_step(quick.m(), quick.d(), known);
    contacts += plain.d()->ncon;
    expect_same(plain, quick);
    for (ModelView* view : {&plain, &quick}) {
      mj_step2(view->m(), view->d());
      mj_kinematics(view->m(), view->d());
    }
    known = Known::kinematics;
  }
  EXPECT_GT(contacts, 1000);
}

TEST(FirstHalfOfAStep, LeavesTheBitsOfMujocosOwnWhereNothingMovedSince) {
  const Stage stage = busy_cell();
  ModelSet plain_set(stage.context(), 1e-3), quick_set(stage.context(), 1e-3);
  ModelView &plain = start(plain_set, stage), &quick = start(quick_set, stage);
  int known_places = 0;
  std::vector<mjtNum> before;
  for (int k = 0; k < 1500 && !testing::Test::HasFailure(); ++k) {
    mj_kinematics(plain.m(), plain.d());
    mj_step1(plain.m(), plain.d());
    const bool same_places = same(quick.d()->qpos, before.data(), static_cast<int>(before.size())) &&
                             quaternions_stay(quick.m(), quick.d());
    if (before.empty() || !same_places) mj_kinematics(quick.m(), quick.d());
    first_half_of_step(quick.m(), quick.d(),
                       !before.empty() && same_places ? Known::positions : Known::kinematics);
    expect_same(plain, quick);
    before.assign(quick.d()->qpos, quick.d()->qpos + quick.m()->nq);
    for (ModelView* view : {&plain, &quick}) {
      const bool stands = k % 10 != 0;  // velocities differ, places do not
      mj_step2(view->m(), view->d());
      if (stands) std::copy(before.begin(), before.end(), view->d()->qpos);
    }
    known_places += same_places;
  }
  EXPECT_GT(known_places, 500);
}

TEST(FirstHalfOfAStep, LeavesTheBitsOfMujocosOwnAfterAReset) {
  const Stage stage = busy_cell();
  ModelSet plain_set(stage.context(), 1e-3), quick_set(stage.context(), 1e-3);
  ModelView &plain = start(plain_set, stage), &quick = start(quick_set, stage);
  for (ModelView* view : {&plain, &quick}) {
    mj_kinematics(view->m(), view->d());
    view->d()->qvel[0] = NAN;  // MuJoCo puts everything back to its reference
  }
  mj_step1(plain.m(), plain.d());
  first_half_of_step(quick.m(), quick.d(), Known::kinematics);
  EXPECT_EQ(quick.d()->warning[mjWARN_BADQVEL].number, 1);
  expect_same(plain, quick);
}

TEST(ModelSets, GiveEachModelTheCapacityOfItsSlots) {
  Stage stage;
  stage.robot = false;
  stage.scene = test::table();
  for (int i = 0; i < 20; ++i) stage.scene.parts.push_back(cube("c" + std::to_string(i), {0.1 * i, 0, 0.02}));
  ModelSet set(stage.context(), 1e-3);
  std::vector<std::size_t> slots;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const ModelView& view = set.view(i);
    slots.push_back(view.slots);
    EXPECT_EQ(view.m()->nconmax, capacity_of(view.slots).contacts);
    EXPECT_EQ(view.m()->njmax, capacity_of(view.slots).rows);
    EXPECT_GE(capacity_of(view.slots).rows, 4 * capacity_of(view.slots).contacts);
  }
  EXPECT_EQ(slots, (std::vector<std::size_t>{0, 1, 2, 4, 8, 16, 20}));
}

#if mjVERSION_HEADER < 230
TEST(ModelSets, HoldNoMemoryForWhatOtherSolversUse) {
  const Stage stage = busy_cell();
  ModelSet set(stage.context(), 1e-3);
  ModelView& view = start(set, stage);
  for (int k = 0; k < 500; ++k) mj_step(view.m(), view.d());
  EXPECT_GT(view.d()->nefc, 0);
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto rows = static_cast<std::size_t>(view.m()->njmax);
  const std::uintptr_t from = (reinterpret_cast<std::uintptr_t>(view.d()->efc_AR) + page - 1) / page * page;
  const std::uintptr_t to = reinterpret_cast<std::uintptr_t>(view.d()->efc_AR + rows * rows) / page * page;
  std::vector<unsigned char> resident((to - from) / page);
  ASSERT_EQ(::mincore(reinterpret_cast<void*>(from), to - from, resident.data()), 0);
  for (const unsigned char one : resident) EXPECT_EQ(one & 1, 0);
  EXPECT_EQ(view.d()->efc_AR[rows * rows / 2], 0);
}
#endif

}  // namespace
}  // namespace polyarm::drivers

#endif
