#include "polyarm/move_group/scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/move_group/poses.hpp"
#include "polyarm/move_group/shapes.hpp"

namespace polyarm::move_group {

namespace {

using Operation = msg::CollisionObject;

Pose inverse_of_frame(const Around& around, int link) {
  return inverse(around.link_in_world(link));
}

/// The pose of the robot whose link carries an attached object, and of that link. Objects are attached to
/// links that are rigid with the tool link, so the moment of the other robots is enough.
Pose attached_in_world(const Around& around, const AttachedObject& attached) {
  if (attached.robot == around.arm->index())
    return around.link_in_world(attached.link) * attached.object.pose;
  const surroundings::Robot& robot = (*around.bodies.robots)[attached.robot];
  const auto& state = around.moment.robots[attached.robot];
  const kinematics::Chain chain(*robot.model, attached.link, state.base);
  return chain.forward(state.joints) * attached.object.pose;
}

Object object_of(const msg::CollisionObject& message, const Pose& T_owner_frame) {
  if (message.id.empty() || message.id.size() > 256)
    throw Refusal(Code::INVALID_OBJECT_NAME, "an object needs a name of at most 256 bytes");
  Object out;
  out.id = message.id;
  out.type = message.type;
  out.pose = T_owner_frame * pose_of(message.pose, "object '" + message.id + "'", Code::INVALID_OBJECT_NAME);
  out.shapes = shapes_of(message);
  if (message.subframe_names.size() != message.subframe_poses.size())
    throw Refusal(Code::INVALID_OBJECT_NAME,
                  "object '" + message.id + "' has not one pose for each subframe");
  for (std::size_t i = 0; i < message.subframe_names.size(); ++i)
    out.subframes[message.subframe_names[i]] =
        pose_of(message.subframe_poses[i], "a subframe of '" + message.id + "'", Code::INVALID_OBJECT_NAME);
  return out;
}

/// Fixtures and parts of the cell are not the clients' to change.
void check_free(const Around& around, const std::string& id) {
  const auto named = [&](const auto& list) {
    return std::any_of(list.begin(), list.end(), [&](const auto& each) { return each.name == id; });
  };
  if (named(around.bodies.scene->fixtures) || named(around.bodies.scene->parts))
    throw Refusal(Code::INVALID_OBJECT_NAME, "'" + id + "' belongs to the cell and is not changed from ROS");
}

void check_bounds(const SceneState& state) {
  std::size_t shapes = 0;
  for (const auto& [id, object] : state.world) shapes += object.shapes.size();
  for (const auto& [id, attached] : state.attached) shapes += attached.object.shapes.size();
  const std::size_t objects = state.world.size() + state.attached.size();
  if (objects > kMostObjects || shapes > kMostObjectShapes)
    throw Refusal(Code::INVALID_OBJECT_NAME,
                  fmt::format("the scene would have {} objects with {} shapes; {} and {} are possible",
                              objects, shapes, kMostObjects, kMostObjectShapes));
}

void remove(const std::string& id, SceneState& state) {
  if (id.empty()) return state.world.clear();
  if (state.world.erase(id) == 0)
    throw Refusal(Code::INVALID_OBJECT_NAME, "there is no object '" + id + "' to remove");
}

Object& existing(const std::string& id, SceneState& state) {
  const auto found = state.world.find(id);
  if (found == state.world.end()) throw Refusal(Code::INVALID_OBJECT_NAME, "there is no object '" + id + "'");
  return found->second;
}

/// An entry of the matrix that lets an object touch everything. Pairs with single links are not kept.
void take_allowed(const msg::AllowedCollisionMatrix& matrix, SceneState& state,
                  std::vector<std::string>& notes) {
  if (matrix.entry_names.empty() && matrix.default_entry_names.empty()) return;
  if (matrix.entry_values.size() != matrix.entry_names.size() ||
      matrix.default_entry_values.size() != matrix.default_entry_names.size())
    throw Refusal(Code::INVALID_OBJECT_NAME,
                  "the matrix of allowed collisions has lists of different lengths");
  state.allowed.clear();
  for (std::size_t i = 0; i < matrix.default_entry_names.size(); ++i)
    if (matrix.default_entry_values[i] != 0) state.allowed.insert(matrix.default_entry_names[i]);
  bool single = false;
  for (std::size_t i = 0; i < matrix.entry_names.size(); ++i) {
    const std::string& name = matrix.entry_names[i];
    const auto& values = matrix.entry_values[i].enabled;
    if (values.size() != matrix.entry_names.size())
      throw Refusal(Code::INVALID_OBJECT_NAME, "the matrix of allowed collisions is not square");
    if (!state.world.contains(name) && !state.attached.contains(name)) continue;
    std::size_t allowed = 0;
    for (std::size_t k = 0; k < values.size(); ++k) allowed += k == i || values[k] != 0 ? 1 : 0;
    if (allowed == values.size())
      state.allowed.insert(name);
    else
      single = single || allowed > 1;
  }
  if (single)
    notes.push_back(
        "the matrix of allowed collisions lets objects touch single links: that is not supported, and these "
        "contacts are refused as before (an object may touch everything or nothing)");
}

void note_the_rest(const msg::PlanningScene& message, std::vector<std::string>& notes) {
  if (!message.world.octomap.octomap.data.empty())
    notes.push_back(
        "an octomap is not taken: obstacles are boxes, spheres, cylinders, cones, planes and meshes");
  if (std::any_of(message.link_padding.begin(), message.link_padding.end(),
                  [](const auto& each) { return each.padding != 0; }) ||
      std::any_of(message.link_scale.begin(), message.link_scale.end(),
                  [](const auto& each) { return each.scale != 1; }))
    notes.push_back("padding and scale of links have no effect: the clearance of the cell is kept");
}

bool is_of(const description::Scene& scene, const std::string& id) {
  return std::any_of(scene.fixtures.begin(), scene.fixtures.end(),
                     [&](const auto& f) { return f.name == id; }) ||
         std::any_of(scene.parts.begin(), scene.parts.end(), [&](const auto& p) { return p.name == id; });
}

msg::CollisionObject object_message(const Object& object, const std::string& frame, const Pose& T_frame_owner,
                                    bool geometry) {
  msg::CollisionObject out;
  out.header.frame_id = frame;
  out.id = object.id;
  out.type = object.type;
  out.pose = to_message(T_frame_owner * object.pose);
  out.operation = Operation::ADD;
  for (const auto& [name, pose] : object.subframes) {
    out.subframe_names.push_back(name);
    out.subframe_poses.push_back(to_message(pose));
  }
  if (geometry) add_to_message(object.shapes, out);
  return out;
}

/// Fixtures, and parts that nobody holds.
std::vector<Object> objects_of_cell(const Around& around) {
  std::vector<Object> out;
  const description::Scene& scene = *around.bodies.scene;
  for (const description::Fixture& fixture : scene.fixtures)
    out.push_back(
        {fixture.name, surroundings::pose_of(fixture, scene, around.moment), fixture.shapes, {}, {}});
  for (std::size_t i = 0; i < scene.parts.size() && i < around.moment.parts.size(); ++i)
    if (const auto& part = around.moment.parts[i]; part.in_world && part.held_by < 0)
      out.push_back({scene.parts[i].name, part.pose, {scene.parts[i].shape}, {}, {}});
  return out;
}

/// Pairs that never count: links, as the SRDF has them, and what the robot stands on.
msg::AllowedCollisionMatrix matrix_of(const Around& around, const std::vector<std::string>& objects) {
  msg::AllowedCollisionMatrix out;
  const description::RobotModel& model = around.arm->model();
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (surroundings::is_rigid_with_root(model, static_cast<int>(i)) ||
        surroundings::is_first_moving(model, static_cast<int>(i)))
      out.entry_names.push_back(model.links[i].name);
  const std::size_t links = out.entry_names.size();
  for (const std::string& id : objects)
    if (is_of(*around.bodies.scene, id)) out.entry_names.push_back(id);
  for (std::size_t i = 0; i < out.entry_names.size(); ++i) {
    msg::AllowedCollisionEntry row;
    for (std::size_t k = 0; k < out.entry_names.size(); ++k)
      row.enabled.push_back((i < links) != (k < links) || (i < links && k < links) ? 1 : 0);
    out.entry_values.push_back(std::move(row));
  }
  for (const std::string& id : around.scene->allowed) {
    out.default_entry_names.push_back(id);
    out.default_entry_values.push_back(1);
  }
  return out;
}

}  // namespace

Pose Around::frame(const std::string& id) const {
  const std::string name = id.starts_with('/') ? id.substr(1) : id;
  if (name.empty()) return base();
  if (name == "world") return {};
  const std::string own = arm->name() + "/";
  const std::string link = name.starts_with(own) ? name.substr(own.size()) : name;
  for (std::size_t i = 0; i < arm->model().links.size(); ++i)
    if (arm->model().links[i].name == link) return link_in_world(static_cast<int>(i));
  for (const Object& object : objects_of_cell(*this))
    if (object.id == name) return object.pose;
  const std::size_t slash = name.find('/');
  const std::string object = name.substr(0, slash);
  const auto in = [&](const Object& found, const Pose& pose) {
    if (slash == std::string::npos) return pose;
    const auto sub = found.subframes.find(name.substr(slash + 1));
    if (sub == found.subframes.end())
      throw Refusal(Code::FRAME_TRANSFORM_FAILURE, "object '" + object + "' has no subframe of '" + id + "'");
    return pose * sub->second;
  };
  if (const auto found = scene->world.find(object); found != scene->world.end())
    return in(found->second, found->second.pose);
  if (const auto found = scene->attached.find(object); found != scene->attached.end())
    return in(found->second.object, attached_in_world(*this, found->second));
  throw Refusal(
      Code::FRAME_TRANSFORM_FAILURE,
      fmt::format("there is no frame '{}': world, links of '{}' and objects are frames", id, arm->name()));
}

void apply(const Around& around, const msg::CollisionObject& message, SceneState& state) {
  const bool all = message.operation == Operation::REMOVE && message.id.empty();
  if (!all) check_free(around, message.id);
  switch (message.operation) {
    case Operation::REMOVE:
      return remove(message.id, state);
    case Operation::ADD: {
      Object object = object_of(message, around.frame(message.header.frame_id));
      if (object.shapes.empty() && object.subframes.empty())
        throw Refusal(Code::INVALID_OBJECT_NAME, "object '" + object.id + "' has no shapes");
      state.world[message.id] = std::move(object);
      return check_bounds(state);
    }
    case Operation::APPEND: {
      Object added = object_of(message, around.frame(message.header.frame_id));
      if (!state.world.contains(message.id)) {
        state.world[message.id] = std::move(added);
      } else {
        Object& object = existing(message.id, state);
        const Pose T_object_added = inverse(object.pose) * added.pose;
        for (description::Shape& shape : added.shapes) {
          shape.pose = T_object_added * shape.pose;
          object.shapes.push_back(std::move(shape));
        }
      }
      return check_bounds(state);
    }
    case Operation::MOVE:
      existing(message.id, state).pose =
          around.frame(message.header.frame_id) *
          pose_of(message.pose, "object '" + message.id + "'", Code::INVALID_OBJECT_NAME);
      return;
    default:
      throw Refusal(Code::INVALID_OBJECT_NAME,
                    fmt::format("the operation {} of object '{}' is none of ADD, REMOVE, APPEND and MOVE",
                                message.operation, message.id));
  }
}

void apply(const Around& around, const msg::AttachedCollisionObject& message, SceneState& state) {
  const std::string& id = message.object.id;
  if (message.object.operation == Operation::REMOVE) {
    bool any = id.empty();
    for (auto at = state.attached.begin(); at != state.attached.end();) {
      const bool meant =
          at->second.robot == around.arm->index() && (id.empty() || at->first == id) &&
          (message.link_name.empty() || around.arm->link_name(at->second.link) == message.link_name);
      if (!meant) {
        ++at;
        continue;
      }
      Object object = at->second.object;  // it stays where it is let go
      object.pose = attached_in_world(around, at->second);
      state.world[object.id] = std::move(object);
      at = state.attached.erase(at);
      any = true;
    }
    if (!any)
      throw Refusal(Code::INVALID_OBJECT_NAME,
                    "no object '" + id + "' is attached to '" + around.arm->name() + "'");
    return;
  }
  if (message.object.operation != Operation::ADD && message.object.operation != Operation::APPEND)
    throw Refusal(Code::INVALID_OBJECT_NAME,
                  "an attached object is added or removed; '" + id + "' is neither");
  check_free(around, id);
  const int link = around.arm->link(message.link_name);
  if (!around.arm->carries_tool(link))
    throw Refusal(
        Code::INVALID_LINK_NAME,
        fmt::format("'{}' cannot be attached to '{}': objects are attached to the tool link '{}' or a "
                    "link that is rigid with it",
                    id, message.link_name, around.arm->link_name(around.arm->model().tool_link())));
  AttachedObject made{{}, around.arm->index(), link, message.touch_links};
  const Pose T_link_world = inverse_of_frame(around, link);
  if (message.object.primitives.empty() && message.object.meshes.empty() && message.object.planes.empty()) {
    made.object = existing(id, state);
    made.object.pose = T_link_world * made.object.pose;
  } else {
    const std::string& frame = message.object.header.frame_id;
    made.object = object_of(
        message.object, T_link_world * (frame.empty() ? around.link_in_world(link) : around.frame(frame)));
  }
  state.world.erase(id);
  state.attached[id] = std::move(made);
  check_bounds(state);
}

SceneState applied(const Around& around, const msg::PlanningScene& message, std::vector<std::string>& notes) {
  SceneState state = *around.scene;
  Around now = around;
  if (!message.is_diff) {
    state.world.clear();
    std::erase_if(state.attached, [&](const auto& each) { return each.second.robot == around.arm->index(); });
    state.allowed.clear();
  } else if (!message.robot_state.is_diff && !message.robot_state.joint_state.name.empty()) {
    // A whole robot state inside a diff replaces what is attached.
    std::erase_if(state.attached, [&](const auto& each) { return each.second.robot == around.arm->index(); });
  }
  if (!message.name.empty()) state.name = message.name.substr(0, 256);
  const auto look = [&] { now.scene = std::make_shared<const SceneState>(state); };
  for (const msg::CollisionObject& object : message.world.collision_objects) {
    if (is_of(*around.bodies.scene, object.id)) continue;  // clients send back the scene that they read
    look();
    apply(now, object, state);
  }
  for (const msg::AttachedCollisionObject& object : message.robot_state.attached_collision_objects) {
    if (is_of(*around.bodies.scene, object.object.id)) continue;
    look();
    apply(now, object, state);
  }
  take_allowed(message.allowed_collision_matrix, state, notes);
  for (const msg::ObjectColor& each : message.object_colors) {
    if (state.colors.size() >= kMostObjects && !state.colors.contains(each.id)) break;
    state.colors[each.id] = each.color;
  }
  note_the_rest(message, notes);
  ++state.version;
  return state;
}

msg::RobotState robot_state(const Around& around, std::span<const double> q, bool with_attached) {
  msg::RobotState out;
  out.joint_state = around.arm->joint_state(q);
  if (!with_attached) return out;
  for (const auto& [id, attached] : around.scene->attached) {
    if (attached.robot != around.arm->index()) continue;
    msg::AttachedCollisionObject made;
    made.link_name = around.arm->link_name(attached.link);
    made.object = object_message(attached.object, made.link_name, {}, true);
    made.touch_links = attached.touch_links;
    for (const int link : surroundings::links_at_tool(around.arm->model()))
      made.touch_links.push_back(around.arm->link_name(link));
    out.attached_collision_objects.push_back(std::move(made));
  }
  return out;
}

msg::PlanningScene to_message(const Around& around, std::uint32_t components) {
  using Components = msg::PlanningSceneComponents;
  const auto has = [&](std::uint32_t bit) { return components == 0 || (components & bit) != 0; };
  msg::PlanningScene out;
  out.name = around.scene->name;
  out.robot_model_name = around.arm->model().name;
  const std::string& frame = around.arm->planning_frame();
  const Pose T_frame_world = inverse(around.base());
  if (has(Components::ROBOT_STATE) || has(Components::ROBOT_STATE_ATTACHED_OBJECTS))
    out.robot_state = robot_state(around, around.joints(), has(Components::ROBOT_STATE_ATTACHED_OBJECTS));
  std::vector<std::string> names;
  std::vector<Object> objects = objects_of_cell(around);
  for (const auto& [id, object] : around.scene->world) objects.push_back(object);
  for (const Object& object : objects) {
    names.push_back(object.id);
    const bool geometry = has(Components::WORLD_OBJECT_GEOMETRY);
    if (geometry || has(Components::WORLD_OBJECT_NAMES))
      out.world.collision_objects.push_back(object_message(object, frame, T_frame_world, geometry));
  }
  if (has(Components::TRANSFORMS) && frame != "world") {
    geometry::TransformStamped made;
    made.header.frame_id = frame;
    made.child_frame_id = "world";
    const geometry::Pose pose = to_message(T_frame_world);
    made.transform.translation = {pose.position.x, pose.position.y, pose.position.z};
    made.transform.rotation = pose.orientation;
    out.fixed_frame_transforms.push_back(std::move(made));
  }
  if (has(Components::ALLOWED_COLLISION_MATRIX)) out.allowed_collision_matrix = matrix_of(around, names);
  if (has(Components::OBJECT_COLORS))
    for (const auto& [id, color] : around.scene->colors) out.object_colors.push_back({id, color});
  return out;
}

std::vector<description::Fixture> fixtures_of(const SceneState& state) {
  std::vector<description::Fixture> out;
  for (const auto& [id, object] : state.world)
    if (!state.allowed.contains(id) && !object.shapes.empty())
      out.push_back({id, object.shapes, object.pose, {}, 0.8});
  return out;
}

std::vector<surroundings::AttachedThing> attached_of(const SceneState& state) {
  std::vector<surroundings::AttachedThing> out;
  for (const auto& [id, attached] : state.attached) {
    if (state.allowed.contains(id)) continue;
    for (const description::Shape& shape : attached.object.shapes) {
      surroundings::AttachedThing thing{id, shape, attached.robot, attached.link,
                                        attached.object.pose * shape.pose};
      thing.shape.pose = {};
      out.push_back(std::move(thing));
    }
  }
  return out;
}

std::unique_ptr<surroundings::Surroundings> compiled(const Around& around, std::span<const double> q,
                                                     double clearance) {
  description::Scene scene = *around.bodies.scene;
  Around now = around;
  now.moment.robots[around.arm->index()].joints.assign(q.begin(), q.end());
  now.moment.parts.resize(
      scene.parts.size());  // where the cell does not know its parts, none is in the world
  const int tool = around.arm->model().tool_link();
  const Pose T_new_old = now.link_in_world(tool) * inverse(around.link_in_world(tool));
  for (auto& part : now.moment.parts)
    if (part.in_world && part.held_by == static_cast<int>(around.arm->index()))
      part.pose = T_new_old * part.pose;
  for (description::Fixture& fixture : fixtures_of(*around.scene))
    scene.fixtures.push_back(std::move(fixture));
  for (const auto& [id, attached] : around.scene->attached) {
    if (around.scene->allowed.contains(id)) continue;
    const Pose pose = attached_in_world(now, attached);
    for (const description::Shape& shape : attached.object.shapes) {
      description::Part part;
      part.name = id;
      part.shape = shape;
      part.shape.pose = {};
      scene.parts.push_back(std::move(part));
      now.moment.parts.push_back({pose * shape.pose, true, static_cast<int>(attached.robot)});
    }
  }
  return std::make_unique<surroundings::Surroundings>(*around.bodies.robots, scene, now.moment,
                                                      around.arm->index(), clearance);
}

}  // namespace polyarm::move_group
