#include "polyarm/shapes/robot_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/meshes/glb_writer.hpp"
#include "polyarm/shapes/link_builder.hpp"
#include "polyarm/shapes/measured_look.hpp"
#include "polyarm/shapes/skeleton.hpp"
#include "polyarm/shapes/style.hpp"

namespace polyarm::shapes {

using description::kMeasuredLook;
using description::Link;
using description::RobotModel;
using description::Shape;
using description::ShapeKind;

namespace {

/// Change this whenever the shapes change, so that browsers load them again.
constexpr const char* kFormat = "shapes/3";

/// For each body: the number of joints from the base to it, and to the tip of the arm.
std::vector<Rank> ranks(const Skeleton& skeleton) {
  std::map<int, std::size_t> by_joint;
  for (std::size_t b = 0; b < skeleton.bodies.size(); ++b)
    if (skeleton.bodies[b].has_in) by_joint[skeleton.bodies[b].in.joint] = b;
  std::vector<Rank> out(skeleton.bodies.size());
  for (std::size_t b = 0; b < out.size(); ++b)
    for (const End& end : skeleton.bodies[b].out)
      if (end.joint >= 0) out[by_joint.at(end.joint)].depth = out[b].depth + 1;
  // The tip is the body with the flange; fingers beyond it do not count.
  int tip = 0;
  for (std::size_t b = 0; b < out.size(); ++b)
    if (skeleton.bodies[b].has_flange) tip = out[b].depth;
  for (const Rank& each : out) tip = tip > 0 ? tip : std::max(tip, each.depth);
  for (Rank& each : out) each.most = std::max(tip, each.depth);
  return out;
}

double travel_of(const RobotModel& model, const RigidBody& body) {
  if (!body.has_in) return 0;
  const description::JointLimits& limits = model.joints[static_cast<std::size_t>(body.in.joint)].limits;
  return limits.lower && limits.upper ? *limits.upper - *limits.lower : 0.2;
}

/// The measured surfaces of the catalogue; none if they cannot be read, which is reported.
MeasuredLook measured_look(const RobotModel& model, Problems& problems) {
  const auto path = model.look.find(kMeasuredLook);
  if (path == model.look.end()) return {};
  try {
    return read_measured_look(path->second);
  } catch (const Error& e) {
    for (Problem problem : e.problems()) {
      problem.severity = Severity::warning;
      problem.what += "; '" + model.name + "' is drawn without its measured surfaces";
      if (problem.advice.empty())
        problem.advice = "measure them again with `polyarm robots fit`, or remove the file";
      problems.add(problem);
    }
    return {};
  }
}

/// The content of a file; empty if it cannot be read, or is larger than measured_look() reads.
std::string content_of(const std::string& path) {
  try {
    return read_file(path, bounds::kYamlBytes);
  } catch (const Error&) {
    return {};
  }
}

meshes::Mesh measured_link(const std::string& link, const MeasuredLook& look, const Paint& paint) {
  Solid solid;
  for (const MeasuredLoft& loft : look.lofts)
    if (loft.link == link) add_loft(solid, loft, read_color(loft.paint).value_or(paint));
  return solid.take();
}

}  // namespace

bool has_no_look(const RobotModel& model) {
  const auto plain = [](const Shape& shape) { return shape.kind == ShapeKind::capsule; };
  return !model.actuated.empty() &&
         std::all_of(model.links.begin(), model.links.end(), [&](const Link& link) {
           return std::all_of(link.visuals.begin(), link.visuals.end(), plain);
         });
}

std::vector<LinkShape> robot_shapes(const RobotModel& model, Problems& problems) {
  const Style style = style_of(model, problems);
  const Skeleton skeleton = skeleton_of(model, style.build == Build::cast || style.build == Build::servo);
  const std::vector<Rank> rank = ranks(skeleton);
  const MeasuredLook measured = measured_look(model, problems);
  std::vector<LinkShape> out;
  for (std::size_t b = 0; b < skeleton.bodies.size(); ++b) {
    const RigidBody& body = skeleton.bodies[b];
    const std::string& name = model.links[static_cast<std::size_t>(body.link)].name;
    LinkShape shape{body.link, measured_link(name, measured, paint_of(style, rank[b]))};
    if (shape.mesh.empty()) shape.mesh = build_link(body, style, rank[b], travel_of(model, body));
    if (!shape.mesh.empty()) out.push_back(std::move(shape));
  }
  return out;
}

void check_look(const RobotModel& model, Problems& problems) {
  style_of(model, problems);
  measured_look(model, problems);
}

std::vector<int> links_with_shapes(const RobotModel& model) {
  std::vector<int> out;
  for (const RigidBody& body : skeleton_of(model, false).bodies) out.push_back(body.link);
  return out;
}

std::string robot_glb(const RobotModel& model) {
  Problems ignored;
  std::vector<meshes::GlbNode> nodes;
  for (LinkShape& each : robot_shapes(model, ignored))
    nodes.push_back({model.links[static_cast<std::size_t>(each.link)].name, std::move(each.mesh)});
  return meshes::write_glb(nodes, meshes::Precision::compact);
}

std::string shapes_hash(const RobotModel& model) {
  std::uint64_t h = 0xcbf29ce484222325u;
  const auto add = [&](const std::string& text) {
    for (const char c : text + '\n') h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  };
  const auto place = [&](const Vec3& p) { add(fmt::format("{} {} {}", p.x, p.y, p.z)); };
  add(kFormat);
  add(model.provenance.maker + "|" + model.provenance.model);
  for (const auto& [key, value] : model.look)
    add(key + "=" + (key == kMeasuredLook ? content_of(value) : value));
  for (const Link& link : model.links) {
    add(link.name);
    if (link.outline) place(link.outline->lower), place(link.outline->upper);
    for (const Shape& shape : link.collisions) {
      add(fmt::format("{} {} {}", static_cast<int>(shape.kind), shape.radius, shape.length));
      place(shape.size), place(shape.pose.position);
    }
  }
  for (const description::Joint& joint : model.joints) {
    add(fmt::format("{} {} {}", joint.name, joint.parent_link, joint.child_link));
    place(joint.origin.position), place(joint.axis);
    const Quaternion& q = joint.origin.rotation;
    add(fmt::format("{} {} {} {}", q.x, q.y, q.z, q.w));
  }
  return fmt::format("{:016x}", h);
}

}  // namespace polyarm::shapes
