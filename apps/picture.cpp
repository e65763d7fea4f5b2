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

bool drawable(const std::vector<Shape>& list) {
  return std::any_of(list.begin(), list.end(),
                     [](const Shape& shape) { return shape.kind != ShapeKind::mesh; });
}

/// The plain shapes of a link in its frame: visuals, or collision shapes without them.
meshes::Mesh mesh_of(const Link& link) {
  meshes::Mesh out;
  for (const Shape& shape : drawable(link.visuals) ? link.visuals : link.collisions)
    for (meshes::MeshPart& part : meshes::mesh_of_shape(shape)) {
      for (std::size_t i = 0; i < part.positions.size(); ++i) {
        auto& p = part.positions[i];
        auto& n = part.normals[i];
        const Vec3 at = shape.pose * Vec3{p[0], p[1], p[2]},
                   to = shape.pose.rotation * Vec3{n[0], n[1], n[2]};
        p = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
        n = {static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(to.z)};
      }
      part.color = {0.86f, 0.87f, 0.88f, 1};
      out.push_back(std::move(part));
    }
  return out;
}

/// The description's own look if it consists of plain shapes; otherwise generated shapes.
std::vector<LinkShape> look_of(const RobotModel& model) {
  Problems ignored;
  std::vector<LinkShape> out;
  if (!shapes::has_no_look(model))
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (meshes::Mesh mesh = mesh_of(model.links[i]); !mesh.empty())
        out.push_back({static_cast<int>(i), std::move(mesh)});
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
