#pragma once
/// The compiled models of one world, and the indices of all objects in them. SI units. Only construction
/// allocates; control thread afterwards.
#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// The owner of a geom.
struct Owner {
  enum class Kind { nothing, floor, fixture, mover, link, tool, finger, held, part };
  Kind kind = Kind::nothing;
  int index = -1;  ///< robot, fixture, or part; for a mover's fixture: the mover
  int name = -1;   ///< index into the names of the world
  bool stands = false;  ///< a link that may touch the floor, because its robot stands or rolls on it
};

/// One compiled model with its data. Slots and twins are numbered as in the MJCF.
struct ModelView {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
  std::size_t slots = 0;
  struct Robot {
    std::vector<int> qpos, dof;  ///< of the actuated joints
    int base_qpos = -1, base_dof = -1, base_body = -1;  ///< of a free-standing robot; else -1
    struct Follower {            ///< a mimic joint
      int qpos = -1, dof = -1;
      std::size_t source = 0;  ///< index among the actuated joints
      double multiplier = 1, offset = 0;
    };
    std::vector<Follower> followers;
    int tool_body = -1, held_body = -1, held_geom = -1;
    std::array<int, 2> finger_qpos{-1, -1}, finger_dof{-1, -1};
  };
  std::vector<Robot> robots;
  struct Slot {
    int body = -1, geom = -1, qpos = -1, dof = -1;  ///< geom: the first of slot_geoms
  };
  std::vector<Slot> slot;
  int slot_geoms = 1;            ///< of each slot and held part
  std::vector<int> twin_pieces;  ///< geoms of each part, from twin_geom on; a slot uses as many
  std::vector<int> twin_geom, twin_mocap, mover_mocap;
  std::vector<int> belt_qpos, belt_dof;
  std::vector<Owner> owner;  ///< by geom
  /// Turns contacts of part `i` on or off, as a twin or in the geoms from `first` on.
  void let_touch(int first, int geoms, std::size_t part, bool on) noexcept;
  /// Places robot `r` at rest at these positions of its actuated joints; missing ones are 0.
  void place(std::size_t r, const std::vector<double>& positions) noexcept;
  const mjModel* m() const noexcept { return model.get(); }
  mjModel* m() noexcept { return model.get(); }
  mjData* d() const noexcept { return data.get(); }
};

/// Models with 0, 1, 2, 4, … slots, up to one for each part, compiled once. Throws Error if MuJoCo rejects
/// the model.
class ModelSet {
 public:
  ModelSet(const hardware::ComponentContext& context, double timestep);

  /// The smallest model with at least `slots` slots.
  std::size_t index_for(std::size_t slots) const noexcept;
  ModelView& view(std::size_t i) noexcept { return views_[i]; }
  std::size_t size() const noexcept { return views_.size(); }
  const std::vector<std::string>& names() const { return names_; }

  /// Gives slot `s` of `view` the shape and mass of `part`. No allocation.
  void shape_slot(ModelView& view, std::size_t s, std::size_t part) const noexcept;
  /// Gives robot `r`'s held body the shape and mass of `part` at `pose` in the tool; part -1 empties it.
  void shape_held(ModelView& view, std::size_t r, int part, const Pose& pose) const noexcept;

 private:
  /// What MuJoCo derives from the shape and mass of a part.
  struct PartBody {
    mjtByte sameframe = 0;
    mjtNum mass = 0, subtreemass = 0, inertia[3], ipos[3], iquat[4], invweight0[2], dof_M0[6],
           dof_invweight0[6];
  };
  void keep_bodies();
  void compile(const hardware::ComponentContext& context, double timestep, std::size_t slots);
  void find_overlaps(const hardware::ComponentContext& context);
  void find_places(const hardware::ComponentContext& context, ModelView& view);
  void find_owners(const hardware::ComponentContext& context, ModelView& view);
  int name(const std::string& text);

  std::vector<ModelView> views_;
  std::vector<PartBody> bodies_;  ///< by part
  std::vector<std::string> names_;
  std::vector<std::pair<std::string, std::string>> overlaps_;
};

inline Vec3 vec3(const mjtNum* p) {
  return {p[0], p[1], p[2]};
}
inline Quaternion quaternion(const mjtNum* q) {
  return {q[1], q[2], q[3], q[0]};
}
inline void put(mjtNum* p, const Vec3& v) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}
inline void put(mjtNum* q, const Quaternion& r) {
  q[0] = r.w;
  q[1] = r.x;
  q[2] = r.y;
  q[3] = r.z;
}
inline Pose body_pose(const mjData* d, int body) {
  return {vec3(d->xpos + 3 * body), quaternion(d->xquat + 4 * body)};
}

}  // namespace polyarm::drivers
