#pragma once
/// Adds entries to the text of a scene file; everything else, with its comments, stays as it is.
#include <string>

#include "polyarm/base/pose.hpp"

namespace polyarm::description {

/// A mesh that is written into a scene. Metres, radians, kg.
struct MeshEntry {
  std::string name, file, unit = "m";
  Vec3 at, rpy;
  double scale = 1, mass = 0;  ///< mass above zero: a part, else a fixture
};

/// The line of the entry, without indentation: "name: {mesh: …}".
std::string line_of(const MeshEntry& entry);

/// The scene's text with the entry. `file` is for errors. Throws Error("bad-name") for a name that is no
/// word, Error("exists") for one that the scene has already, and Error("cannot-keep") if the text would not
/// read back with all other entries.
std::string with_mesh(const std::string& text, const std::string& file, const MeshEntry& entry);

}  // namespace polyarm::description
