#pragma once
/// What all programs that read mesh files have in common: their limits, the file, and the answer.
#include <functional>
#include <string>

#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

/// The library refuses the file; the text says why.
struct Refused {
  std::string why;
};

/// Runs the program: reads the file's bytes, calls `read` with them and the extension without its dot, and
/// writes the mesh to the process that started it. Limits time and memory, and blocks other files and the
/// network first. Does not return to a library that has read a hostile file.
int run_importer(int argc, char** argv, std::size_t most_memory,
                 const std::function<Mesh(const std::string& bytes, const std::string& kind)>& read);

}  // namespace polyarm::meshes
