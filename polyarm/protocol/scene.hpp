#pragma once
/// Requests that add things to the scene of a cell.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/facts.hpp"

namespace polyarm::protocol {

/// A mesh file as it was read.
struct MeshFacts {
  Vec3 size, lower;  ///< the box around it and its lower corner, in the numbers of the file, or m if `metres`
  std::uint64_t triangles = 0;
  bool metres = false;  ///< its format says its unit
  std::string likely;   ///< the unit that its size suggests: m, mm
  POLYARM_MEMBERS(MeshFacts, size, lower, triangles, metres, likely)
};

struct SceneUpload {
  static constexpr Facts kFacts{
      .name = "scene.upload",
      .role = Role::program,
      .text =
          "Stores a file for the scene in the folder meshes of the cell, piece by piece: a mesh, its .mtl or "
          "its images. "
          "`data` is base64; `offset` counts the bytes before it, 0 begins the file. With `last`, a mesh is "
          "read whole, and its size is returned; a file that cannot be read is not kept.",
      .moves = true};
  std::string name;
  std::uint64_t offset = 0;
  std::string data;
  bool last = false;
  struct Answer {
    static constexpr const char* kOf = "SceneUpload";
    std::uint64_t bytes = 0;  ///< stored so far
    std::string file;         ///< with `last`: its path in the cell's folder
    OrNull<MeshFacts> mesh;   ///< with `last`, of a mesh
    POLYARM_MEMBERS(Answer, bytes, file, mesh)
  };
  POLYARM_MEMBERS(SceneUpload, name, offset, data, last)
};

struct SceneAdd {
  static constexpr Facts kFacts{
      .name = "scene.add",
      .role = Role::program,
      .text =
          "Writes a mesh into the scene file, as a fixture or, with `mass` in kg, as a part. `unit` is m, "
          "mm, cm or in, "
          "`scale` 1 without it; `at` and `rpy` are its pose in the world. It is there after cell.reset.",
      .moves = true};
  std::string name, file, unit = "m";
  Vec3 at, rpy;
  std::optional<double> scale, mass;
  struct Answer {
    static constexpr const char* kOf = "SceneAdd";
    std::string file, text;  ///< the scene file, and the line that was written
    POLYARM_MEMBERS(Answer, file, text)
  };
  POLYARM_MEMBERS(SceneAdd, name, file, unit, at, rpy, scale, mass)
};

}  // namespace polyarm::protocol
