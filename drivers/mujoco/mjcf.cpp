#include "drivers/mujoco/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "polyarm/description/bodies.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/hardware/force_sensor.hpp"

namespace polyarm::drivers {

using description::Shape;
using description::ShapeKind;

namespace {

constexpr double kLinkFriction = 0.5;  // if the description states none
constexpr double kArmature =
    0.08;  // kg m², inertia of a motor and its gear at the joint; makes the servo stiff
constexpr double kHingeMargin = 0.05;   // rad
constexpr double kSlideMargin = 0.01;   // m: distance of a joint's stop from its limit, so that only faults
                                        // reach the stop
constexpr double kSmallestMass = 0.01;  // kg, for a moving link that states none

std::string text(const Vec3& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x, v.y, v.z);
}
std::string text(const Quaternion& q) {
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", q.w, q.x, q.y, q.z);
}
std::string place(const Pose& p) {
  return fmt::format("pos=\"{}\" quat=\"{}\"", text(p.position), text(p.rotation));
}

/// Type, size and pose; empty for a mesh, whose pieces are geoms of their own.
std::string geometry(const Shape& s, const Pose& at) {
  switch (s.kind) {
    case ShapeKind::box:
      return fmt::format("type=\"box\" size=\"{}\" {}", text(0.5 * s.size), place(at));
    case ShapeKind::sphere:
      return fmt::format("type=\"sphere\" size=\"{:.17g}\" {}", s.radius, place(at));
    case ShapeKind::cylinder:
      return fmt::format("type=\"cylinder\" size=\"{:.17g} {:.17g}\" {}", s.radius, s.length / 2, place(at));
    case ShapeKind::capsule:
      if (s.length < 1e-6) return fmt::format("type=\"sphere\" size=\"{:.17g}\" {}", s.radius, place(at));
      return fmt::format("type=\"capsule\" size=\"{:.17g} {:.17g}\" {}", s.radius, s.length / 2, place(at));
    case ShapeKind::mesh:
      break;
  }
  return {};
}

std::string site_name(std::size_t robot, std::size_t sensor) {
  return fmt::format("force{}_{}", robot, sensor);
}

class Writer {
 public:
  Writer(const hardware::ComponentContext& context, double timestep, std::size_t slots,
         const BodyPairs& excluded, Capacity capacity)
      : context_(context),
        timestep_(timestep),
        slots_(slots),
        excluded_(excluded),
        capacity_(capacity),
        geoms_(most_pieces(context.scene)) {
    if (context.scene)
      for (const description::Part& part : context.scene->parts)
        has_mesh_parts_ |= !part.shape.pieces.empty();
    for (std::size_t r = 0; r < context.robots.size(); ++r) {
      weighed_.emplace_back(context.robots[r].model->links.size(), 0);
      for (std::size_t before = 0; before < r; ++before)
        for (std::size_t i = 0; const char shared : shared_with(r, before)) weighed_[r][i++] |= shared;
    }
  }

  std::string write() {
    const description::Scene empty;
    const description::Scene& scene = context_.scene ? *context_.scene : empty;
    out_ = fmt::format(
        "<mujoco model=\"cell\">\n<compiler angle=\"radian\" boundmass=\"1e-5\" boundinertia=\"1e-8\" "
        "balanceinertia=\"true\"/>\n<option timestep=\"{:.17g}\" gravity=\"{}\" integrator=\"Euler\" "
        "cone=\"elliptic\" "
        "impratio=\"5\" solver=\"Newton\" iterations=\"30\" tolerance=\"1e-10\" jacobian=\"sparse\">"
        // With one contact point a standing cylinder wobbles on its edge and never comes to rest.
        "<flag multiccd=\"enable\"/></option>\n"
        "<size njmax=\"{}\" nconmax=\"{}\"/>\n"
        "<default><geom condim=\"4\" friction=\"0.8 0.005 0.0001\" solref=\"0.004 1\" solimp=\"0.95 0.99 "
        "0.0005\"/>"
        "</default>\n",
        timestep_, text(scene.gravity), capacity_.rows, capacity_.contacts);
    meshes();
    out_ += "<worldbody>\n";
    if (scene.floor)
      line("<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" pos=\"0 0 {:.17g}\"/>", scene.floor_height);
    for (std::size_t r = 0; r < context_.robots.size(); ++r)
      if (!carrier_of(context_.robots[r], context_.robots)) robot(r, context_.robots[r].base);
    for (std::size_t i = 0; i < slots_; ++i) slot(i, scene.parts[i]);
    fixtures(scene);
    for (std::size_t i = 0; i < scene.parts.size(); ++i) twin(i, scene.parts[i]);
    out_ += "</worldbody>\n<contact>\n";
    for (std::size_t r = 0; r < context_.robots.size(); ++r) excludes(r);
    belt_excludes(scene);
    for (const auto& [a, b] : excluded_) line("<exclude body1=\"{}\" body2=\"{}\"/>", a, b);
    out_ += "</contact>\n<equality>\n";
    for (std::size_t r = 0; r < context_.robots.size(); ++r) couplings(r);
    out_ += "</equality>\n<sensor>\n";
    for (std::size_t r = 0; r < context_.robots.size(); ++r)
      for (std::size_t k = 0; k < force_sensors(context_.robots[r]).size(); ++k)
        for (const char* kind : {"force", "torque"}) line("<{} site=\"{}\"/>", kind, site_name(r, k));
    out_ += "</sensor>\n</mujoco>\n";
    return std::move(out_);
  }

 private:
  template <typename... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...) + "\n";
  }

  void geom(const std::string& name, const Shape& shape, const Pose& at, double friction,
            bool its_friction_counts = false) {
    const char* priority = its_friction_counts ? " priority=\"1\"" : "";
    for (std::size_t p = 0; p < shape.pieces.size(); ++p)
      line("<geom name=\"{0}_{1}\" type=\"mesh\" mesh=\"{0}_{1}\" {2} friction=\"{3:.17g} 0.005 0.0001\"{4}/>", name, p,
           place(at), friction, priority);
    const std::string what = geometry(shape, at);
    if (!what.empty())
      line("<geom name=\"{}\" {} friction=\"{:.17g} 0.005 0.0001\"{}/>", name, what, friction, priority);
  }

  /// The convex pieces of all meshes, repeated for every shape that uses a mesh.
  void meshes() {
    out_ += "<asset>\n";
    for (std::size_t r = 0; r < context_.robots.size(); ++r) {
      const description::RobotModel& model = *context_.robots[r].model;
      for (std::size_t i = 0; i < model.links.size(); ++i)
        for (std::size_t s = 0; s < model.links[i].collisions.size(); ++s)
          pieces(link_name(r, static_cast<int>(i)) + "_" + std::to_string(s), model.links[i].collisions[s]);
    }
    for (std::size_t r = 0; r < context_.robots.size(); ++r)
      if (const description::Tool* tool = context_.robots[r].tool)
        for (std::size_t s = 0; s < tool->body.size(); ++s)
          pieces(tool_name(r) + "_" + std::to_string(s), tool->body[s]);
    if (context_.scene)
      for (std::size_t f = 0; f < context_.scene->fixtures.size(); ++f)
        for (std::size_t s = 0; s < context_.scene->fixtures[f].shapes.size(); ++s)
          pieces(fixture_name(f, s), context_.scene->fixtures[f].shapes[s]);
    for (std::size_t i = 0; context_.scene && i < context_.scene->parts.size(); ++i)
      if (mesh_owner(i) == i) pieces(part_mesh(i), context_.scene->parts[i].shape);
    out_ += "</asset>\n";
  }

  void pieces(const std::string& name, const Shape& shape) {
    for (std::size_t p = 0; p < shape.pieces.size(); ++p) {
      out_ += fmt::format("<mesh name=\"{}_{}\" vertex=\"", name, p);
      for (const Vec3& corner : shape.pieces[p])
        fmt::format_to(std::back_inserter(out_), "{:.9g} {:.9g} {:.9g} ", corner.x, corner.y, corner.z);
      out_ += "\"/>\n";
    }
  }

  /// MuJoCo raises each value to boundinertia, but rejects zero values before that (1e-14 kg m²).
  void inertial(const description::Inertial& i) {
    constexpr double kNotZero = 1e-12;  // kg m²
    const auto& [xx, xy, xz, yy, yz, zz] = i.inertia;
    line(
        "<inertial pos=\"{}\" mass=\"{:.17g}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} "
        "{:.17g}\"/>",
        text(i.center), i.mass, xx + kNotZero, yy + kNotZero, zz + kNotZero, xy, xz, yz);
  }

  // --- robots

  /// `at`: pose of its root link in the body that carries it.
  void robot(std::size_t r, const Pose& at) {
    const hardware::RobotInstance& robot = context_.robots[r];
    line("<body name=\"{}\" {}>", link_name(r, robot.model->root), place(at));
    if (is_freestanding(robot)) line("<freejoint name=\"{}\"/>", base_name(r));
    link(r, robot.model->root);
    for (std::size_t other = 0; other < context_.robots.size(); ++other)
      if (carrier_of(context_.robots[other], context_.robots) == &robot)
        this->robot(other, inverse(robot.base) * context_.robots[other].base);
    line("</body>");
  }

  void link(std::size_t r, int index) {
    const description::RobotModel& model = *context_.robots[r].model;
    const description::Link& link = model.links[static_cast<std::size_t>(index)];
    const bool is_weighed = weighed_[r][static_cast<std::size_t>(index)] != 0;
    if (!is_weighed && link.inertial && description::plausible(*link.inertial)) {
      inertial(*link.inertial);
    } else if (is_weighed || (link.parent_joint >= 0 &&
                              model.joints[static_cast<std::size_t>(link.parent_joint)].moves())) {
      line("<inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"1e-4 1e-4 1e-4\"/>", kSmallestMass);
    }
    for (std::size_t s = 0; s < link.collisions.size(); ++s)
      geom(link_name(r, index) + "_" + std::to_string(s), link.collisions[s], link.collisions[s].pose,
           link.contact.mu1.value_or(kLinkFriction),
           link.contact.mu1 && is_freestanding(context_.robots[r]));  // a caster slides on any floor
    const std::vector<ForceSensor> sensors = force_sensors(context_.robots[r]);
    for (std::size_t k = 0; k < sensors.size(); ++k)
      if (sensors[k].link == index) line("<site name=\"{}\" size=\"0.001\"/>", site_name(r, k));
    if (index == model.tool_link()) tool(r);
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].parent_link == index) child(r, static_cast<int>(j));
  }

  void child(std::size_t r, int index) {
    const description::RobotModel& model = *context_.robots[r].model;
    const description::Joint& joint = model.joints[static_cast<std::size_t>(index)];
    line("<body name=\"{}\" {}>", link_name(r, joint.child_link), place(joint.origin));
    using description::JointType;
    const bool hinge = joint.type == JointType::revolute || joint.type == JointType::continuous;
    if (hinge || joint.type == JointType::prismatic)
      line(
          "<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{:.17g}\" damping=\"{:.17g}\" "
          "frictionloss=\"{:.17g}\"{}/>",
          joint_name(r, index), hinge ? "hinge" : "slide", text(joint.axis), hinge ? kArmature : 1.0,
          joint.damping, joint.friction, stops(r, index));
    link(r, joint.child_link);
    line("</body>");
  }

  /// The range of a joint, extended a little beyond its limits and its start position; empty if it has no
  /// limits.
  std::string stops(std::size_t r, int index) {
    const hardware::RobotInstance& robot = context_.robots[r];
    const description::Joint& joint = robot.model->joints[static_cast<std::size_t>(index)];
    if (joint.mimic || joint.type == description::JointType::continuous || !joint.limits.lower ||
        !joint.limits.upper || !(*joint.limits.lower < *joint.limits.upper))
      return {};
    double lower = *joint.limits.lower, upper = *joint.limits.upper;
    for (std::size_t j = 0; j < robot.model->actuated.size() && j < robot.initial_positions.size(); ++j)
      if (robot.model->actuated[j] == index) {
        lower = std::min(lower, robot.initial_positions[j]);
        upper = std::max(upper, robot.initial_positions[j]);
      }
    const double margin = joint.type == description::JointType::prismatic ? kSlideMargin : kHingeMargin;
    return fmt::format(" limited=\"true\" range=\"{:.17g} {:.17g}\" solreflimit=\"0.004 1\"", lower - margin,
                       upper + margin);
  }

  /// Couplings of mimic joints, and of the second finger of a gripper, which shares its drive.
  void couplings(std::size_t r) {
    const hardware::RobotInstance& robot = context_.robots[r];
    for (const Follower& f : followers(*robot.model))
      line("<joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{:.17g} {:.17g} 0 0 0\" solref=\"0.004 1\"/>",
           joint_name(r, f.joint), joint_name(r, f.source), f.offset, f.multiplier);
    if (robot.tool && robot.tool->gripper == description::GripperKind::parallel)
      line("<joint joint1=\"{}\" joint2=\"{}\" solref=\"0.004 1\"/>", finger_name(r, 1), finger_name(r, 0));
  }

  void tool(std::size_t r) {
    const description::Tool* tool = context_.robots[r].tool;
    if (!tool) return;
    line("<body name=\"{}\">", tool_name(r));
    if (tool->mass > 0) {
      const double small = tool->mass * 4e-4;
      line("<inertial pos=\"{}\" mass=\"{:.17g}\" diaginertia=\"{:.17g} {:.17g} {:.17g}\"/>",
           text(tool->center), tool->mass, small, small, small);
    }
    for (std::size_t s = 0; s < tool->body.size(); ++s)
      geom(tool_name(r) + "_" + std::to_string(s), tool->body[s], tool->body[s].pose, 0.5);
    if (tool->gripper == description::GripperKind::suction) {
      // The held part becomes part of the arm: shape and mass are set when it is gripped.
      line(
          "<body name=\"{}\"><inertial pos=\"0 0 0\" mass=\"1e-5\" diaginertia=\"1e-8 1e-8 1e-8\"/>"
          "<geom name=\"{}\" type=\"box\" size=\"0.01 0.01 0.01\" contype=\"0\" conaffinity=\"0\"/>",
          held_name(r), held_name(r));
      unused_geoms(held_name(r), 1, geoms_);
      line("</body>");
    }
    if (tool->gripper == description::GripperKind::parallel)
      for (int side = 0; side < 2; ++side) finger(r, *tool, side);
    line("</body>");
  }

  void finger(std::size_t r, const description::Tool& tool, int side) {
    constexpr double kThickness = description::kFingerThickness;
    const double sign = side == 0 ? 1 : -1;
    Pose at = tool.tcp;
    at = at * Pose{{0, sign * tool.stroke / 2, 0}, {}};
    const std::string name = finger_name(r, side);
    line("<body name=\"{}\" {}>", name, place(at));
    line("<inertial pos=\"0 0 {:.17g}\" mass=\"0.05\" diaginertia=\"2e-5 2e-5 2e-5\"/>",
         -tool.finger_length / 2);
    line(
        "<joint name=\"{}\" type=\"slide\" axis=\"0 {} 0\" limited=\"true\" range=\"0 {:.17g}\" "
        "armature=\"0.4\" damping=\"2\" solreflimit=\"0.004 1\" solimplimit=\"0.95 0.99 0.0005\"/>",
        name, side == 0 ? -1 : 1, tool.stroke / 2);
    line(
        "<geom name=\"{}\" type=\"box\" size=\"{:.17g} {:.17g} {:.17g}\" pos=\"0 {:.17g} {:.17g}\" "
        "condim=\"4\" "
        "friction=\"1.5 0.05 0.001\" solref=\"0.004 1\"/>",
        name, tool.finger_width / 2, kThickness / 2, tool.finger_length / 2, sign * kThickness / 2,
        -tool.finger_length / 2);
    line("</body>");
  }

  // --- the scene

  void fixtures(const description::Scene& scene) {
    for (std::size_t f = 0; f < scene.fixtures.size(); ++f)
      if (scene.fixtures[f].mover.empty() && scene.fixtures[f].belt.empty())
        fixture(f, scene.fixtures[f], scene.fixtures[f].pose);
    for (std::size_t b = 0; b < scene.belts.size(); ++b) belt(b, scene);
    for (std::size_t m = 0; m < scene.movers.size(); ++m) {
      line("<body name=\"{}\" mocap=\"true\">", mover_name(m));
      bool any = false;
      for (std::size_t f = 0; f < scene.fixtures.size(); ++f)
        if (scene.fixtures[f].mover == scene.movers[m].name) {
          fixture(f, scene.fixtures[f], scene.fixtures[f].pose);
          any = true;
        }
      if (!any) line("<geom type=\"sphere\" size=\"0.001\" contype=\"0\" conaffinity=\"0\"/>");
      line("</body>");
    }
  }

  void belt(std::size_t b, const description::Scene& scene) {
    const description::Belt& belt = scene.belts[b];
    constexpr double kHeavy = 1000;  // kg, kg m²: parts do not slow it down
    line("<body name=\"{}\" {}>", belt_name(b), place(belt.pose));
    line("<joint name=\"{}\" type=\"{}\" axis=\"{}\"/>", belt_name(b), belt.turns ? "hinge" : "slide",
         belt.turns ? "0 0 1" : "1 0 0");
    line("<inertial pos=\"0 0 0\" mass=\"{0:g}\" diaginertia=\"{0:g} {0:g} {0:g}\"/>", kHeavy);
    for (std::size_t f = 0; f < scene.fixtures.size(); ++f)
      if (scene.fixtures[f].belt == belt.name) fixture(f, scene.fixtures[f], {});
    line("</body>");
  }

  void fixture(std::size_t f, const description::Fixture& fixture, const Pose& at) {
    for (std::size_t s = 0; s < fixture.shapes.size(); ++s)
      if (description::cloud_of(fixture.shapes[s]).empty())
        geom(fixture_name(f, s), fixture.shapes[s], at * fixture.shapes[s].pose, fixture.friction);
  }

  /// The first part with the same pieces: parts of one kind share their meshes.
  std::size_t mesh_owner(std::size_t part) const {
    const std::vector<description::Part>& parts = context_.scene->parts;
    std::size_t first = 0;
    while (first < part && (parts[first].shape.mesh_path != parts[part].shape.mesh_path ||
                            parts[first].shape.pieces != parts[part].shape.pieces))
      ++first;
    return first;
  }
  static std::string part_mesh(std::size_t owner) { return "part" + std::to_string(owner); }

  /// `geoms`: how many in all; those beyond the part's pieces touch nothing.
  void part_geoms(const std::string& name, std::size_t i, const description::Part& part, std::size_t geoms) {
    if (part.shape.pieces.empty()) geom(name, part.shape, {}, part.friction);
    const std::string mesh = part.shape.pieces.empty() ? std::string() : part_mesh(mesh_owner(i));
    for (std::size_t p = 0; p < part.shape.pieces.size(); ++p)
      line("<geom name=\"{}\" type=\"mesh\" mesh=\"{}_{}\" friction=\"{:.17g} 0.005 0.0001\"/>",
           piece_name(name, p), mesh, p, part.friction);
    unused_geoms(name, pieces_of(part), geoms);
  }

  void unused_geoms(const std::string& name, std::size_t from, std::size_t to) {
    for (std::size_t p = from; p < to; ++p)
      line("<geom name=\"{}\" type=\"sphere\" size=\"0.001\" contype=\"0\" conaffinity=\"0\"/>",
           piece_name(name, p));
  }

  /// With meshes among the parts, all slots have general inertias, so that they have one structure: MuJoCo
  /// treats bodies with their centre of mass in the origin in another way.
  void part_inertial(description::Inertial body) {
    constexpr double kOffOrigin = 1e-9;  // m
    if (body.center == Vec3{}) body.center.x = kOffOrigin;
    inertial(body);
  }

  void slot(std::size_t i, const description::Part& part) {
    line("<body name=\"{}\" pos=\"0 0 {:.17g}\"><freejoint/>", slot_name(i), 50.0 + static_cast<double>(i));
    description::Inertial body = description::inertial_of({part.shape}, 1);
    const double scale = body.mass > 0 ? part.mass / body.mass : 0;
    body.mass = part.mass;
    for (double& x : body.inertia) x *= scale;
    if (has_mesh_parts_)
      part_inertial(body);
    else  // in the part's own axes instead of the principal axes, so that a slot can take the shape of any
          // part
      line("<inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"{:.17g} {:.17g} {:.17g}\"/>", body.mass,
           std::max(body.inertia[0], 0.0), std::max(body.inertia[3], 0.0), std::max(body.inertia[5], 0.0));
    part_geoms(slot_name(i), i, part, geoms_);
    line("</body>");
  }

  void twin(std::size_t i, const description::Part& part) {
    line("<body name=\"{}\" mocap=\"true\" pos=\"0 0 {:.17g}\">", twin_name(i),
         -50.0 - static_cast<double>(i));
    part_geoms(twin_name(i), i, part, pieces_of(part));
    line("</body>");
  }

  // --- pairs that are excluded from collision checks

  void excludes(std::size_t r) {
    const description::RobotModel& model = *context_.robots[r].model;
    const Rigid rigid = rigid_links(model);
    std::set<std::pair<int, int>> pairs;
    const auto add = [&](int a, int b) {
      if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
    };
    // Links connected by one joint always touch; the bodies of a rigid group are listed one by one.
    for (std::size_t a = 0; a < model.links.size(); ++a)
      for (std::size_t b = a + 1; b < model.links.size(); ++b) {
        const int ga = rigid.body_of_link[a], gb = rigid.body_of_link[b];
        const auto parent_group = [&](int g) {
          const int joint = model.links[static_cast<std::size_t>(g)].parent_joint;
          return joint < 0 ? -1
                           : rigid.body_of_link[static_cast<std::size_t>(
                                 model.joints[static_cast<std::size_t>(joint)].parent_link)];
        };
        if (ga == gb || parent_group(ga) == gb || parent_group(gb) == ga)
          add(static_cast<int>(a), static_cast<int>(b));
      }
    for (const auto& [a, b] : model.allowed_collisions) add(a, b);
    const auto spares_its_own = [&](std::size_t i) { return model.links[i].contact.self_collide == false; };
    for (std::size_t a = 0; a < model.links.size(); ++a)
      for (std::size_t b = a + 1; b < model.links.size(); ++b)
        if (spares_its_own(a) || spares_its_own(b)) add(static_cast<int>(a), static_cast<int>(b));
    for (const auto& [a, b] : pairs)
      line("<exclude body1=\"{}\" body2=\"{}\"/>", link_name(r, a), link_name(r, b));
    world_excludes(r, rigid);
    tool_excludes(r, rigid);
    for (std::size_t other = 0; other < context_.robots.size(); ++other) shared_excludes(r, other);
  }

  /// By link of robot `r`: what is also a body of the other one, as the torso that carries both. Empty:
  /// nothing.
  std::vector<char> shared_with(std::size_t r, std::size_t other) const {
    const hardware::RobotInstance &one = context_.robots[r], &two = context_.robots[other];
    if (r == other || one.on != two.on || is_freestanding(one) || is_freestanding(two)) return {};
    return description::shared_links(*one.model, one.base, *two.model, two.base);
  }

  /// Each robot meets its own copy of what it shares with another one.
  void shared_excludes(std::size_t r, std::size_t other) {
    const std::vector<char> mine = shared_with(r, other);
    if (mine.empty()) return;
    const std::vector<char> its = shared_with(other, r);
    std::vector<std::string> bodies = own_bodies(other);
    for (std::size_t i = 0; i < its.size(); ++i)
      if (!its[i] || r < other) bodies.push_back(link_name(other, static_cast<int>(i)));
    for (std::size_t i = 0; i < mine.size(); ++i)
      for (const std::string& body : bodies)
        if (mine[i]) line("<exclude body1=\"{}\" body2=\"{}\"/>", link_name(r, static_cast<int>(i)), body);
  }

  /// The bodies at the tool link of a robot that are no links.
  std::vector<std::string> own_bodies(std::size_t r) const {
    const hardware::RobotInstance& robot = context_.robots[r];
    if (!robot.tool) return {};
    std::vector<std::string> own = {tool_name(r)};
    if (robot.tool->gripper == description::GripperKind::suction) own.push_back(held_name(r));
    if (robot.tool->gripper == description::GripperKind::parallel)
      for (int side = 0; side < 2; ++side) own.push_back(finger_name(r, side));
    return own;
  }

  /// A fixture that reaches into a belt would stop its surface. Only parts and robots touch belts.
  void belt_excludes(const description::Scene& scene) {
    const auto exclude = [&](std::size_t belt, const std::string& other) {
      line("<exclude body1=\"{}\" body2=\"{}\"/>", belt_name(belt), other);
    };
    for (std::size_t b = 0; b < scene.belts.size(); ++b) {
      exclude(b, "world");
      for (std::size_t m = 0; m < scene.movers.size(); ++m) exclude(b, mover_name(m));
      for (std::size_t other = b + 1; other < scene.belts.size(); ++other) exclude(b, belt_name(other));
    }
  }

  /// The first moving link turns at the mounting, so its loose capsule may reach into the table.
  void world_excludes(std::size_t r, const Rigid& rigid) {
    if (is_freestanding(context_.robots[r])) return;
    const hardware::RobotInstance* carrier = carrier_of(context_.robots[r], context_.robots);
    const std::vector<std::string> grounds = grounds_of(carrier);
    const description::RobotModel& model = *context_.robots[r].model;
    const int root = rigid.body_of_link[static_cast<std::size_t>(model.root)];
    for (std::size_t i = 0; i < model.links.size(); ++i) {
      const int joint = model.links[static_cast<std::size_t>(rigid.body_of_link[i])].parent_joint;
      if (joint < 0) continue;
      const int parent = model.joints[static_cast<std::size_t>(joint)].parent_link;
      if (rigid.body_of_link[static_cast<std::size_t>(parent)] == root)
        for (const std::string& ground : grounds)
          line("<exclude body1=\"{}\" body2=\"{}\"/>", link_name(r, static_cast<int>(i)), ground);
    }
  }

  /// What carries a robot: the world, or the root link of its carrier, also as others have it.
  std::vector<std::string> grounds_of(const hardware::RobotInstance* carrier) const {
    if (!carrier) return {"world"};
    const auto index = static_cast<std::size_t>(carrier - context_.robots.data());
    const auto root = static_cast<std::size_t>(carrier->model->root);
    std::vector<std::string> out{link_name(index, carrier->model->root)};
    for (std::size_t other = 0; other < context_.robots.size(); ++other)
      if (const std::vector<char> shared = shared_with(index, other); !shared.empty() && shared[root])
        out.push_back(link_name(other, context_.robots[other].model->root));
    return out;
  }

  void tool_excludes(std::size_t r, const Rigid& rigid) {
    const hardware::RobotInstance& robot = context_.robots[r];
    if (!robot.tool) return;
    const int mount = rigid.body_of_link[static_cast<std::size_t>(robot.model->tool_link())];
    const int joint = robot.model->links[static_cast<std::size_t>(mount)].parent_joint;
    const int before = joint < 0 ? mount
                                 : rigid.body_of_link[static_cast<std::size_t>(
                                       robot.model->joints[static_cast<std::size_t>(joint)].parent_link)];
    const std::vector<std::string> own = own_bodies(r);
    for (std::size_t i = 0; i < robot.model->links.size(); ++i) {
      const int group = rigid.body_of_link[i];
      if (group != mount && group != before) continue;
      for (const std::string& name : own)
        line("<exclude body1=\"{}\" body2=\"{}\"/>", link_name(r, static_cast<int>(i)), name);
    }
    for (std::size_t a = 0; a < own.size(); ++a)
      for (std::size_t b = a + 1; b < own.size(); ++b)
        line("<exclude body1=\"{}\" body2=\"{}\"/>", own[a], own[b]);
  }

  const hardware::ComponentContext& context_;
  double timestep_;
  std::size_t slots_;
  const BodyPairs& excluded_;
  Capacity capacity_;
  std::size_t geoms_;  ///< of each slot
  bool has_mesh_parts_ = false;
  std::vector<std::vector<char>> weighed_;  ///< by robot and link: a robot before it has the same body
  std::string out_;
};

}  // namespace

std::string joint_name(std::size_t robot, int joint) {
  return fmt::format("r{}j{}", robot, joint);
}
std::string link_name(std::size_t robot, int link) {
  return fmt::format("r{}l{}", robot, link);
}
std::string finger_name(std::size_t robot, int side) {
  return fmt::format("finger{}_{}", robot, side);
}

std::string write_mjcf(const hardware::ComponentContext& context, double timestep, std::size_t slots,
                       const BodyPairs& excluded, Capacity capacity) {
  return Writer(context, timestep, slots, excluded, capacity).write();
}

}  // namespace polyarm::drivers
