#pragma once
/// Draws meshes into a picture on the processor, without GPU or browser. For thumbnails and documents. No
/// side effects; any thread.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::shapes {

/// A mesh and its pose; m.
struct Placed {
  const meshes::Mesh* mesh = nullptr;
  Pose pose;  ///< in the world, z up
};

/// Pixels from the upper left corner, four bytes each: red, green, blue, opacity.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

struct View {
  double azimuth = -0.87, elevation = 0.38;  ///< of the eye, rad: about z from x, and above the floor
  int size = 260;                            ///< px; the longer side of the picture
  int samples = 3;                           ///< per pixel and direction
  double floor = 0;                          ///< m
};

/// Draws all meshes as large as the picture allows, with a soft shadow on the floor and a transparent
/// background. The same meshes give the same pixels. Empty if there is nothing to draw.
Picture draw(std::span<const Placed> things, const View& view);

/// The picture as a PNG file. `colors`: the maximum number of different colours (2 to 256); fewer make the
/// file smaller.
std::string png(const Picture& picture, int colors = 256);

}  // namespace polyarm::shapes
