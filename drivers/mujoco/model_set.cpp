#include "drivers/mujoco/model_set.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "drivers/mujoco/box_contacts.hpp"
#include "drivers/mujoco/mjcf.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/description/bodies.hpp"

namespace polyarm::drivers {

namespace {

/// MuJoCo's errors and warnings must not end the process or print on the control thread. A warning appears in
/// mjData::warning; an error would be a fault in our text and becomes the message of compile().
void keep_quiet(const char*) {}

#if mjVERSION_HEADER < 230
/// The compiler makes data of the model's capacity three times and clears them, tens of megabytes. So a model
/// is compiled with hardly any, and given its capacity here, as the compiler does.
constexpr Capacity kWhileCompiling{100, 20};

void give_capacity(mjModel& m, Capacity capacity) {
  m.njmax = capacity.rows;
  m.nconmax = capacity.contacts;
  constexpr std::int64_t kLargestStack = std::int64_t{1} << 27;
  const std::int64_t rows = m.njmax + m.neq + m.nv;
  const std::int64_t objects =
      m.nq + m.nv + m.nu + m.na + m.nbody + m.njnt + m.ngeom + m.nsite + m.neq + m.ntendon + m.nwrap;
  m.nstack = static_cast<int>(std::clamp<std::int64_t>(5 * rows * rows + 20 * objects, 1000, kLargestStack));
}

/// Square matrices of all rows, which only other solvers than ours use. They were filled with zeros, and read
/// as zeros again should anything read it.
void give_back_unused(const mjModel& m, mjData& d) {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(d.efc_AR_colind);
  const std::uintptr_t end =
      reinterpret_cast<std::uintptr_t>(d.efc_AR) +
      sizeof(mjtNum) * static_cast<std::size_t>(m.njmax) * static_cast<std::size_t>(m.njmax);
  const std::uintptr_t first = (begin + page - 1) / page * page, last = end / page * page;
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}
#endif

mjModel* load(const std::string& text, std::string& reason) {
  auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  char message[1000] = "";
#if mjVERSION_HEADER >= 300
  mj_addBufferVFS(vfs.get(), "cell.xml", text.data(), static_cast<int>(text.size()));
#else
  if (mj_makeEmptyFileVFS(vfs.get(), "cell.xml", static_cast<int>(text.size())) != 0) {
    reason = "no room for the model's text";
    return nullptr;
  }
  std::memcpy(vfs->filedata[0], text.data(), text.size());
#endif
  mjModel* model = mj_loadXML("cell.xml", vfs.get(), message, sizeof message);
  mj_deleteVFS(vfs.get());
  if (!model) reason = message;
  return model;
}

int find(const mjModel* m, int type, const std::string& name) {
  return mj_name2id(m, type, name.c_str());
}

template <typename T>
void copy_rows(T* to, int to_row, const T* from, int from_row, int width) {
  std::copy_n(from + from_row * width, width, to + to_row * width);
}

}  // namespace

ModelSet::ModelSet(const hardware::ComponentContext& context, double timestep) {
  mju_user_warning = keep_quiet;
  keep_true_box_contacts();
  const std::size_t parts = context.scene ? context.scene->parts.size() : 0;
  compile(context, timestep, 0);
  find_overlaps(context);
  if (overlaps_.empty()) {
    mj_resetData(views_[0].m(), views_[0].d());
#if mjVERSION_HEADER < 230
    give_back_unused(*views_[0].m(), *views_[0].d());
#endif
  } else {
    views_.clear();
    compile(context, timestep, 0);
  }
  for (std::size_t slots = 1; slots < parts; slots *= 2) compile(context, timestep, slots);
  if (parts > 0) compile(context, timestep, parts);
  keep_bodies();
}

/// In the last model, slot i begins with the shape and mass of part i.
void ModelSet::keep_bodies() {
  const ModelView& from = views_.back();
  const mjModel* m = from.m();
  for (const ModelView::Slot& slot : from.slot) {
    PartBody body;
    body.sameframe = m->body_sameframe[slot.body];
    copy_rows(&body.mass, 0, m->body_mass, slot.body, 1);
    copy_rows(&body.subtreemass, 0, m->body_subtreemass, slot.body, 1);
    copy_rows(body.inertia, 0, m->body_inertia, slot.body, 3);
    copy_rows(body.ipos, 0, m->body_ipos, slot.body, 3);
    copy_rows(body.iquat, 0, m->body_iquat, slot.body, 4);
    copy_rows(body.invweight0, 0, m->body_invweight0, slot.body, 2);
    copy_rows(body.dof_M0, 0, m->dof_M0 + slot.dof, 0, 6);
    copy_rows(body.dof_invweight0, 0, m->dof_invweight0 + slot.dof, 0, 6);
    bodies_.push_back(body);
  }
}

void ModelView::let_touch(int first, int geoms, std::size_t part, bool on) noexcept {
  for (int k = 0; k < geoms; ++k)
    model->geom_contype[first + k] = model->geom_conaffinity[first + k] = on && k < twin_pieces[part] ? 1 : 0;
}

void ModelView::place(std::size_t r, const std::vector<double>& positions) noexcept {
  const Robot& robot = robots[r];
  mjtNum* q = data->qpos;
  for (std::size_t j = 0; j < robot.qpos.size(); ++j)
    q[robot.qpos[j]] = j < positions.size() ? positions[j] : 0;
  for (const Robot::Follower& f : robot.followers)
    q[f.qpos] = f.multiplier * q[robot.qpos[f.source]] + f.offset;
}

int ModelSet::name(const std::string& text) {
  const auto found = std::find(names_.begin(), names_.end(), text);
  if (found != names_.end()) return static_cast<int>(found - names_.begin());
  names_.push_back(text);
  return static_cast<int>(names_.size()) - 1;
}

void ModelSet::compile(const hardware::ComponentContext& context, double timestep, std::size_t slots) {
  ModelView view;
  std::string reason;
  const Capacity capacity = capacity_of(slots, most_pieces(context.scene));
#if mjVERSION_HEADER < 230
  view.model.reset(load(write_mjcf(context, timestep, slots, overlaps_, kWhileCompiling), reason));
  if (view.model) give_capacity(*view.model, capacity);
#else
  view.model.reset(load(write_mjcf(context, timestep, slots, overlaps_, capacity), reason));
#endif
  if (!view.model)
    throw Error("physics-model", "MuJoCo does not accept this cell: " + reason,
                "check masses, inertias and sizes of the robot's links and of the parts");
  view.data.reset(mj_makeData(view.model.get()));
#if mjVERSION_HEADER < 230
  give_back_unused(*view.model, *view.data);
#endif
  view.slots = slots;
  find_places(context, view);
  find_owners(context, view);
  views_.push_back(std::move(view));
}

void ModelSet::find_overlaps(const hardware::ComponentContext& context) {
  ModelView& view = views_.front();
  mjData* d = view.d();
  for (std::size_t r = 0; r < context.robots.size(); ++r) view.place(r, context.robots[r].initial_positions);
  mj_forward(view.m(), d);
  for (int i = 0; i < d->ncon; ++i) {
    const int a = d->contact[i].geom1, b = d->contact[i].geom2;
    const Owner& first = view.owner[static_cast<std::size_t>(a)];
    const Owner& second = view.owner[static_cast<std::size_t>(b)];
    const auto own = [](const Owner& o) {
      return o.kind == Owner::Kind::link || o.kind == Owner::Kind::tool;
    };
    if (!own(first) || !own(second) || first.index != second.index) continue;
    const auto body = [&](int geom) {
      return std::string(mj_id2name(view.m(), mjOBJ_BODY, view.m()->geom_bodyid[geom]));
    };
    const std::pair<std::string, std::string> pair{body(a), body(b)};
    if (std::find(overlaps_.begin(), overlaps_.end(), pair) == overlaps_.end()) overlaps_.push_back(pair);
  }
}

void ModelSet::find_places(const hardware::ComponentContext& context, ModelView& view) {
  const mjModel* m = view.m();
  for (std::size_t r = 0; r < context.robots.size(); ++r) {
    ModelView::Robot robot;
    for (const int joint : context.robots[r].model->actuated) {
      const int id = find(m, mjOBJ_JOINT, joint_name(r, joint));
      robot.qpos.push_back(m->jnt_qposadr[id]);
      robot.dof.push_back(m->jnt_dofadr[id]);
    }
    for (const Follower& f : followers(*context.robots[r].model)) {
      const std::vector<int>& actuated = context.robots[r].model->actuated;
      const auto source = std::find(actuated.begin(), actuated.end(), f.source);
      const int id = find(m, mjOBJ_JOINT, joint_name(r, f.joint));
      if (source == actuated.end() || id < 0) continue;
      robot.followers.push_back({m->jnt_qposadr[id], m->jnt_dofadr[id],
                                 static_cast<std::size_t>(source - actuated.begin()), f.multiplier,
                                 f.offset});
    }
    if (const int id = find(m, mjOBJ_JOINT, base_name(r)); id >= 0) {
      robot.base_qpos = m->jnt_qposadr[id];
      robot.base_dof = m->jnt_dofadr[id];
      robot.base_body = m->jnt_bodyid[id];
    }
    robot.tool_body = find(m, mjOBJ_BODY, tool_name(r));
    robot.held_body = find(m, mjOBJ_BODY, held_name(r));
    robot.held_geom = find(m, mjOBJ_GEOM, held_name(r));
    for (int side = 0; side < 2; ++side)
      if (const int id = find(m, mjOBJ_JOINT, finger_name(r, side)); id >= 0) {
        robot.finger_qpos[static_cast<std::size_t>(side)] = m->jnt_qposadr[id];
        robot.finger_dof[static_cast<std::size_t>(side)] = m->jnt_dofadr[id];
      }
    view.robots.push_back(std::move(robot));
  }
  for (std::size_t s = 0; s < view.slots; ++s) {
    ModelView::Slot slot;
    slot.body = find(m, mjOBJ_BODY, slot_name(s));
    slot.geom = find(m, mjOBJ_GEOM, slot_name(s));
    slot.qpos = m->jnt_qposadr[m->body_jntadr[slot.body]];
    slot.dof = m->body_dofadr[slot.body];
    view.slot.push_back(slot);
  }
  const std::size_t parts = context.scene ? context.scene->parts.size() : 0;
  view.slot_geoms = static_cast<int>(most_pieces(context.scene));
  for (std::size_t i = 0; i < parts; ++i) {
    view.twin_geom.push_back(find(m, mjOBJ_GEOM, twin_name(i)));
    view.twin_pieces.push_back(static_cast<int>(pieces_of(context.scene->parts[i])));
    view.twin_mocap.push_back(m->body_mocapid[find(m, mjOBJ_BODY, twin_name(i))]);
  }
  for (std::size_t k = 0; context.scene && k < context.scene->movers.size(); ++k)
    view.mover_mocap.push_back(m->body_mocapid[find(m, mjOBJ_BODY, mover_name(k))]);
  for (std::size_t b = 0; context.scene && b < context.scene->belts.size(); ++b) {
    const int id = find(m, mjOBJ_JOINT, belt_name(b));
    view.belt_qpos.push_back(m->jnt_qposadr[id]);
    view.belt_dof.push_back(m->jnt_dofadr[id]);
  }
}

void ModelSet::find_owners(const hardware::ComponentContext& context, ModelView& view) {
  const mjModel* m = view.m();
  view.owner.assign(static_cast<std::size_t>(m->ngeom), {});
  const auto own = [&](int geom, Owner::Kind kind, int index, const std::string& called, bool stands = false) {
    if (geom >= 0) view.owner[static_cast<std::size_t>(geom)] = {kind, index, name(called), stands};
  };
  const auto own_shape = [&](const std::string& geom, const description::Shape& shape, Owner::Kind kind, int index,
                             const std::string& called, bool stands = false) {
    own(find(m, mjOBJ_GEOM, geom), kind, index, called, stands);
    for (std::size_t p = 0; p < shape.pieces.size(); ++p)
      own(find(m, mjOBJ_GEOM, geom + "_" + std::to_string(p)), kind, index, called, stands);
  };
  own(find(m, mjOBJ_GEOM, "floor"), Owner::Kind::floor, 0, "floor");
  for (std::size_t r = 0; r < context.robots.size(); ++r) {
    const hardware::RobotInstance& robot = context.robots[r];
    const int index = static_cast<int>(r);
    const std::vector<char> stands =
        description::links_on_the_floor(*robot.model, view.robots[r].base_dof >= 0, wheel_joints(robot));
    for (std::size_t l = 0; l < robot.model->links.size(); ++l)
      for (std::size_t s = 0; s < robot.model->links[l].collisions.size(); ++s)
        own_shape(link_name(r, static_cast<int>(l)) + "_" + std::to_string(s), robot.model->links[l].collisions[s],
                  Owner::Kind::link, index, robot.name + "/" + robot.model->links[l].name, stands[l] != 0);
    for (std::size_t s = 0; robot.tool && s < robot.tool->body.size(); ++s)
      own_shape(tool_name(r) + "_" + std::to_string(s), robot.tool->body[s], Owner::Kind::tool, index,
                robot.name + "/tool");
    for (int k = 0; view.robots[r].held_geom >= 0 && k < view.slot_geoms; ++k)
      own(view.robots[r].held_geom + k, Owner::Kind::held, index, "the part held by " + robot.name);
    for (int side = 0; side < 2; ++side)
      own(find(m, mjOBJ_GEOM, finger_name(r, side)), Owner::Kind::finger, index, robot.name + "/finger");
  }
  if (!context.scene) return;
  const description::Scene& scene = *context.scene;
  for (std::size_t f = 0; f < scene.fixtures.size(); ++f)
    for (std::size_t s = 0; s < scene.fixtures[f].shapes.size(); ++s) {
      if (!description::cloud_of(scene.fixtures[f].shapes[s]).empty()) continue;
      const auto mover =
          std::find_if(scene.movers.begin(), scene.movers.end(),
                       [&](const description::Mover& k) { return k.name == scene.fixtures[f].mover; });
      const bool moves = mover != scene.movers.end();
      own_shape(fixture_name(f, s), scene.fixtures[f].shapes[s], moves ? Owner::Kind::mover : Owner::Kind::fixture,
                static_cast<int>(moves ? mover - scene.movers.begin() : static_cast<std::ptrdiff_t>(f)),
                "fixture " + scene.fixtures[f].name);
    }
  for (std::size_t i = 0; i < scene.parts.size(); ++i)
    for (int k = 0; k < view.twin_pieces[i]; ++k)
      own(view.twin_geom[i] + k, Owner::Kind::part, static_cast<int>(i), "part " + scene.parts[i].name);
}

std::size_t ModelSet::index_for(std::size_t slots) const noexcept {
  for (std::size_t i = 0; i < views_.size(); ++i)
    if (views_[i].slots >= slots) return i;
  return views_.size() - 1;
}

namespace {
/// Gives the geoms from `to` on the shapes of the part's twin, which never changes.
void shape_geoms(ModelView& view, int to, std::size_t part) noexcept {
  mjModel* m = view.m();
  for (int k = 0; k < view.twin_pieces[part]; ++k) {
    const int a = to + k, b = view.twin_geom[part] + k;
    copy_rows(m->geom_type, a, m->geom_type, b, 1);
    copy_rows(m->geom_dataid, a, m->geom_dataid, b, 1);
    // 2 stands for the twin's inertial frame, which follows from its geoms; that of a slot follows from the
    // part.
    m->geom_sameframe[a] = m->geom_sameframe[b] == 1 ? 1 : 0;
    copy_rows(m->geom_pos, a, m->geom_pos, b, 3);
    copy_rows(m->geom_quat, a, m->geom_quat, b, 4);
    copy_rows(m->geom_size, a, m->geom_size, b, 3);
    copy_rows(m->geom_rbound, a, m->geom_rbound, b, 1);
#if mjVERSION_HEADER >= 300
    copy_rows(m->geom_aabb, a, m->geom_aabb, b, 6);
#endif
    copy_rows(m->geom_friction, a, m->geom_friction, b, 3);
  }
}
}  // namespace

void ModelSet::shape_slot(ModelView& view, std::size_t s, std::size_t part) const noexcept {
  const ModelView::Slot& slot = view.slot[s];
  const PartBody& from = bodies_[part];
  mjModel* m = view.m();
  m->body_sameframe[slot.body] = from.sameframe;
  copy_rows(m->body_mass, slot.body, &from.mass, 0, 1);
  copy_rows(m->body_subtreemass, slot.body, &from.subtreemass, 0, 1);
  copy_rows(m->body_inertia, slot.body, from.inertia, 0, 3);
  copy_rows(m->body_ipos, slot.body, from.ipos, 0, 3);
  copy_rows(m->body_iquat, slot.body, from.iquat, 0, 4);
  copy_rows(m->body_invweight0, slot.body, from.invweight0, 0, 2);
  copy_rows(m->dof_M0 + slot.dof, 0, from.dof_M0, 0, 6);
  copy_rows(m->dof_invweight0 + slot.dof, 0, from.dof_invweight0, 0, 6);
  shape_geoms(view, slot.geom, part);
  for (int k = 0; k < view.slot_geoms; ++k)
    view.owner[static_cast<std::size_t>(slot.geom + k)] =
        view.owner[static_cast<std::size_t>(view.twin_geom[part])];
}

void ModelSet::shape_held(ModelView& view, std::size_t r, int part, const Pose& pose) const noexcept {
  const ModelView::Robot& robot = view.robots[r];
  if (robot.held_body < 0) return;
  mjModel* m = view.m();
  if (part < 0) {
    view.let_touch(robot.held_geom, view.slot_geoms, 0, false);
    m->body_mass[robot.held_body] = 1e-5;
    for (int k = 0; k < 3; ++k) m->body_inertia[3 * robot.held_body + k] = 1e-8;
    return;
  }
  const PartBody& from = bodies_[static_cast<std::size_t>(part)];
  view.let_touch(robot.held_geom, view.slot_geoms, static_cast<std::size_t>(part), true);
  copy_rows(m->body_mass, robot.held_body, &from.mass, 0, 1);
  copy_rows(m->body_inertia, robot.held_body, from.inertia, 0, 3);
  copy_rows(m->body_ipos, robot.held_body, from.ipos, 0, 3);
  copy_rows(m->body_iquat, robot.held_body, from.iquat, 0, 4);
  m->body_sameframe[robot.held_body] = from.sameframe;
  shape_geoms(view, robot.held_geom, static_cast<std::size_t>(part));
  put(m->body_pos + 3 * robot.held_body, pose.position);
  put(m->body_quat + 4 * robot.held_body, pose.rotation);
}

}  // namespace polyarm::drivers
