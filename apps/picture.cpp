#include "apps/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/shapes/render.hpp"
#include "polyarm/shapes/robot_shapes.hpp"

namespace polyarm::apps {

namespace {

using description::Link;
using description::RobotModel;
using description::Shape;
using description::ShapeKind;
using shapes::LinkShape;

constexpr int kSize = 260;   // px, longer side
constexpr int kColorsOfPicture = 48;  // keeps a picture below 15 kB

constexpr std::size_t kTriangles = 100'000;  // of all meshes; more are simplified

/// A mesh file in the frame of its link; nothing if it cannot be read. Without images.
meshes::Mesh read(const Shape& shape) {
  meshes::Mesh out;
  Problems ignored;
  if (!shape.mesh_path.empty()) collect(ignored, [&] { out = meshes::read_mesh(shape.mesh_path); });
  meshes::place(out, shape);
  return out;
}

/// Shapes in the frame of their link.
meshes::Mesh mesh_of(const std::vector<Shape>& shapes) {
  meshes::Mesh out;
  for (const Shape& shape : shapes) {
    meshes::Mesh mesh = shape.kind == ShapeKind::mesh ? read(shape) : meshes::mesh_of_shape(shape);
    if (shape.kind != ShapeKind::mesh) meshes::place(mesh, shape);
    for (meshes::MeshPart& part : mesh) {
      if (!part.colored) part.color = {0.86f, 0.87f, 0.88f, 1};
      out.push_back(std::move(part));
    }
  }
  return out;
}

/// The look that the description gives a link, or its collision shapes without one.
meshes::Mesh mesh_of(const Link& link) {
  meshes::Mesh out = mesh_of(link.visuals);
  return out.empty() ? mesh_of(link.collisions) : out;
}

void simplify(std::vector<LinkShape>& shapes) {
  std::size_t all = 0;
  for (const LinkShape& each : shapes) all += meshes::triangles_of(each.mesh);
  if (all <= kTriangles) return;
  for (LinkShape& each : shapes)
    meshes::simplify(each.mesh, kTriangles * meshes::triangles_of(each.mesh) / all + 12);
}

/// The description's own look; generated shapes without one.
std::vector<LinkShape> look_of(const RobotModel& model) {
  Problems ignored;
  std::vector<LinkShape> out;
  if (!shapes::has_no_look(model))
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (meshes::Mesh mesh = mesh_of(model.links[i]); !mesh.empty())
        out.push_back({static_cast<int>(i), std::move(mesh)});
  simplify(out);
  return out.empty() ? shapes::robot_shapes(model, ignored) : out;
}

/// RFC 4648, 4.
std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

}  // namespace

std::string picture_of(const RobotModel& model, std::span<const double> q) {
  const std::vector<LinkShape> look = look_of(model);
  std::vector<Pose> poses(model.links.size());
  kinematics::Chain(model, model.tool_link()).link_poses(q, poses);
  std::vector<shapes::Placed> placed;
  for (const LinkShape& each : look)
    placed.push_back({&each.mesh, poses[static_cast<std::size_t>(each.link)]});
  shapes::View view;
  view.size = kSize;
  const shapes::Picture picture = shapes::draw(placed, view);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\">"
      "<image width=\"{0}\" height=\"{1}\" href=\"data:image/png;base64,{2}\"/></svg>\n",
      picture.width, picture.height, base64(shapes::png(picture, kColorsOfPicture)));
}

}  // namespace polyarm::apps
