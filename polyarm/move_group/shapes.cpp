#include "polyarm/move_group/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/hulls/convex_pieces.hpp"
#include "polyarm/hulls/hull.hpp"
#include "polyarm/move_group/scene.hpp"

namespace polyarm::move_group {

namespace {

using description::Shape;
using description::ShapeKind;
using Primitive = messages::shape_msgs::msg::SolidPrimitive;
using Mesh = messages::shape_msgs::msg::Mesh;
using PlaneMessage = messages::shape_msgs::msg::Plane;

constexpr int kConeSides = 24;
constexpr double kSlab = 20, kSlabThickness = 0.002;  // of a plane, m
constexpr std::size_t kMostHullCorners = 64;
constexpr double kLargest = 1e4;  // m

[[noreturn]] void refuse(const std::string& id, const std::string& what) {
  throw Refusal(Code::INVALID_OBJECT_NAME, "object '" + id + "': " + what);
}

double size_at(const std::string& id, const Primitive& primitive, std::size_t i) {
  if (primitive.dimensions.size() <= i)
    refuse(id, fmt::format("a primitive of type {} has {} dimensions", primitive.type,
                           primitive.dimensions.size()));
  const double size = primitive.dimensions[i];
  if (!(size > 0 && size <= kLargest))
    refuse(id, fmt::format("a dimension is {}, not in (0, 10000] m", size));
  return size;
}

/// A cone from its base at -height / 2 to its tip, around the round one.
Shape cone(double height, double radius) {
  Shape out;
  out.kind = ShapeKind::mesh;
  std::vector<Vec3> points{{0, 0, height / 2}};
  const double corner = radius / std::cos(std::numbers::pi / kConeSides);
  for (int i = 0; i < kConeSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kConeSides;
    points.push_back({corner * std::cos(angle), corner * std::sin(angle), -height / 2});
  }
  out.pieces.push_back(std::move(points));
  return out;
}

Shape shape_of(const std::string& id, const Primitive& primitive) {
  const auto size = [&](std::size_t i) { return size_at(id, primitive, i); };
  Shape out;
  switch (primitive.type) {
    case Primitive::BOX:
      out.kind = ShapeKind::box;
      out.size = {size(0), size(1), size(2)};
      return out;
    case Primitive::SPHERE:
      out.kind = ShapeKind::sphere;
      out.radius = size(0);
      return out;
    case Primitive::CYLINDER:
      out.kind = ShapeKind::cylinder;
      out.length = size(0);
      out.radius = size(1);
      return out;
    case Primitive::CONE:
      return cone(size(0), size(1));
    default:
      refuse(id, fmt::format("the primitive type {} is not supported: box, sphere, cylinder and cone are",
                             primitive.type));
  }
}

Shape shape_of(const std::string& id, const Mesh& mesh) {
  if (mesh.triangles.size() > kMostMeshTriangles)
    refuse(id, fmt::format("a mesh has {} triangles; {} are possible", mesh.triangles.size(),
                           kMostMeshTriangles));
  std::vector<Vec3> points;
  for (const auto& p : mesh.vertices) {
    if (!(std::abs(p.x) <= kLargest && std::abs(p.y) <= kLargest && std::abs(p.z) <= kLargest))
      refuse(id, "a mesh has a vertex that is not finite");
    points.push_back({p.x, p.y, p.z});
  }
  if (mesh.triangles.empty() || points.empty()) refuse(id, "a mesh has no triangles");
  std::vector<hulls::Triangle> triangles;
  for (const auto& triangle : mesh.triangles) {
    hulls::Triangle made;
    for (std::size_t i = 0; i < 3; ++i) {
      if (triangle.vertex_indices[i] >= points.size())
        refuse(id,
               fmt::format("a triangle names vertex {} of {}", triangle.vertex_indices[i], points.size()));
      made[i] = points[triangle.vertex_indices[i]];
    }
    triangles.push_back(made);
  }
  Shape out;
  out.kind = ShapeKind::mesh;
  if (triangles.size() > kMostCutTriangles)
    out.pieces.push_back(hulls::enclosing_hull(points, kMostHullCorners).corners);
  else
    for (const hulls::Hull& piece : hulls::convex_pieces(triangles).pieces)
      out.pieces.push_back(piece.corners);
  return out;
}

/// a x + b y + c z + d = 0.
Shape shape_of(const std::string& id, const PlaneMessage& plane) {
  const Vec3 normal{plane.coef[0], plane.coef[1], plane.coef[2]};
  const double length = norm(normal);
  if (!(length > 1e-9 && length < 1e9) || !(std::abs(plane.coef[3] / length) <= kLargest))
    refuse(id, "a plane has no finite normal");
  Shape out;
  out.kind = ShapeKind::box;
  out.size = {kSlab, kSlab, kSlabThickness};
  out.pose.rotation = rotation_between({0, 0, 1}, normalized(normal));
  out.pose.position = (-plane.coef[3] / length) * normalized(normal);
  return out;
}

template <class Messages>
void add(const std::string& id, const Messages& messages, const std::vector<geometry::Pose>& poses,
         const char* what, std::vector<Shape>& out) {
  if (poses.size() > messages.size() || (poses.size() < messages.size() && !poses.empty()))
    refuse(id, fmt::format("it has {} {} and {} poses of them", messages.size(), what, poses.size()));
  for (std::size_t i = 0; i < messages.size(); ++i) {
    Shape shape = shape_of(id, messages[i]);
    if (!poses.empty())
      shape.pose = pose_of(poses[i], "a shape of '" + id + "'", Code::INVALID_OBJECT_NAME) * shape.pose;
    out.push_back(std::move(shape));
  }
}

void add_primitive(std::uint8_t type, std::initializer_list<double> sizes, const Pose& pose,
                   msg::CollisionObject& message) {
  Primitive primitive;
  primitive.type = type;
  primitive.dimensions = sizes;
  message.primitives.push_back(std::move(primitive));
  message.primitive_poses.push_back(to_message(pose));
}

void add_pieces(const Shape& shape, msg::CollisionObject& message) {
  for (const std::vector<Vec3>& piece : shape.pieces) {
    const hulls::Hull hull = hulls::convex_hull(piece);
    Mesh mesh;
    for (const Vec3& p : hull.corners) mesh.vertices.push_back({p.x, p.y, p.z});
    for (const auto& face : hull.faces) mesh.triangles.push_back({face});
    message.meshes.push_back(std::move(mesh));
    message.mesh_poses.push_back(to_message(shape.pose));
  }
}

}  // namespace

std::vector<Shape> shapes_of(const msg::CollisionObject& message) {
  std::vector<Shape> out;
  const std::size_t count = message.primitives.size() + message.meshes.size() + message.planes.size();
  if (count > kMostObjectShapes)
    refuse(message.id, fmt::format("it has {} shapes; {} are possible", count, kMostObjectShapes));
  add(message.id, message.primitives, message.primitive_poses, "primitives", out);
  add(message.id, message.meshes, message.mesh_poses, "meshes", out);
  add(message.id, message.planes, message.plane_poses, "planes", out);
  return out;
}

void add_to_message(const std::vector<Shape>& shapes, msg::CollisionObject& message) {
  for (const Shape& shape : shapes) switch (shape.kind) {
      case ShapeKind::box:
        add_primitive(Primitive::BOX, {shape.size.x, shape.size.y, shape.size.z}, shape.pose, message);
        break;
      case ShapeKind::sphere:
        add_primitive(Primitive::SPHERE, {shape.radius}, shape.pose, message);
        break;
      case ShapeKind::cylinder:
        add_primitive(Primitive::CYLINDER, {shape.length, shape.radius}, shape.pose, message);
        break;
      case ShapeKind::capsule:
        add_primitive(Primitive::CYLINDER, {shape.length, shape.radius}, shape.pose, message);
        for (const int end : {-1, 1})
          add_primitive(Primitive::SPHERE, {shape.radius},
                        shape.pose * Pose{{0, 0, end * shape.length / 2}, {}}, message);
        break;
      case ShapeKind::mesh:
        add_pieces(shape, message);
    }
}

}  // namespace polyarm::move_group
