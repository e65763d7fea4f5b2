#pragma once
/// The visible shapes of grippers, independent of their collision shapes: vacuum cups, parallel jaws, and the
/// built-in grippers of makers. m, in the frame of the flange (tool0). No side effects; any thread.
#include <string>
#include <vector>

#include "polyarm/description/scene.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::shapes {

/// A part of a gripper that moves as one.
struct ToolShape {
  std::string name;
  meshes::Mesh mesh;  ///< with the pads of a parallel gripper closed
  Vec3 slide;         ///< how far it moves for each m between the pads; zero: it does not move
};

/// Empty for a tool that is drawn with the shapes of its file: it grips nothing, or its body is a mesh.
std::vector<ToolShape> tool_shapes(const description::Tool& tool);

/// The same shapes as binary glTF 2.0, with one node for each. The same tool gives the same bytes.
std::string tool_glb(const description::Tool& tool);

/// A hash of everything that tool_glb depends on: 16 hexadecimal digits.
std::string tool_shapes_hash(const description::Tool& tool);

}  // namespace polyarm::shapes
