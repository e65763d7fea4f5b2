#pragma once
/// The elements from which a robot's look is built: turned profiles, lofts through rounded sections, rounded
/// boxes. Lengths in m, in the frame of the link. No side effects; any thread.
#include <array>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::shapes {

/// Colour (sRGB, 0 to 1) and finish of a surface.
struct Paint {
  std::array<float, 3> color{0.8f, 0.8f, 0.8f};
  float roughness = 0.5f;
  float metallic = 0;
};

/// A point of a turned profile: its distance from the axis and its position along the axis.
struct Ring {
  double radius = 0, at = 0;
};

/// A rounded rectangle across a loft. `frame`: x and y span it, z points along the loft.
struct Section {
  Pose frame;
  double half_x = 0, half_y = 0;
  double corner = 0;  ///< radius of its corners; a value equal to the smaller half size makes round ends
};

/// Collects the surfaces of one link, one mesh part per paint.
class Solid {
 public:
  /// A body of revolution about z of `frame`. An end is closed if its ring has no radius.
  void turn(const Pose& frame, std::span<const Ring> profile, const Paint& paint);
  /// A cylinder on z of `frame`, from `from` to `to`. Each end has its own edge radius.
  void drum(const Pose& frame, double from, double to, double radius, double edge_from, double edge_to,
            const Paint& paint);
  /// A skin through the sections, with flat ends.
  void loft(std::span<const Section> sections, const Paint& paint);
  /// A skin through closed loops of equally many points, anticlockwise seen from the last one, with flat
  /// ends.
  void skin(std::span<const std::vector<Vec3>> loops, const Paint& paint);
  /// A box centred on `frame`, its edges rounded by `edge`.
  void box(const Pose& frame, const Vec3& size, double edge, const Paint& paint);

  /// The surfaces with normals, smooth over edges below 30 degrees. Empties the collector.
  meshes::Mesh take();

 private:
  meshes::MeshPart& part(const Paint& paint);
  std::vector<meshes::MeshPart> parts_;
};

/// A frame at `at` with z along `z`, and x as close to `x` as possible.
Pose frame_along(const Vec3& at, const Vec3& z, const Vec3& x);
/// A frame at `at` with z along `z`.
Pose frame_along(const Vec3& at, const Vec3& z);

}  // namespace polyarm::shapes
