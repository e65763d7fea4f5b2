#pragma once
/// Reads mesh files in a process apart (`polyarm_mesh_import` with Assimp, `polyarm_step_import` with Open
/// CASCADE), which uses a library of others. The file may come from anybody: a fault of the library ends that
/// process only, and nothing that it answers is trusted.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

/// Descriptors of the process: the file's bytes, and the answer.
inline constexpr int kImportFile = 3, kImportAnswer = 4;
/// Exit code of the process if the library refuses the file; its error output says why.
inline constexpr int kImportRefused = 3;
/// Most bytes of the answer.
inline constexpr std::size_t kMostImportBytes = 100 * kMostTriangles;
/// Processor time that the process may take for a file of so many bytes, s: damaged files can keep the
/// library busy without end. Surfaces of STEP files are computed, which takes longer.
constexpr std::size_t import_seconds(std::size_t bytes, bool is_step) {
  return is_step ? 10 + bytes / (256 << 10) : 1 + bytes / (4 << 20);
}

/// True if the extension (".glb", lower case) is that of a format that the process reads.
bool is_imported(const std::string& extension);
/// True for ".step" and ".stp".
bool is_step(const std::string& extension);
/// The formats, for messages: "GLB, glTF, PLY or STEP".
std::string imported_formats();

/// Reads the file's `bytes`. `name` is for errors. Waits for the process. A STEP file comes in m. Any
/// thread. Throws
/// Error("bad-mesh" | "large-mesh" | "unknown-mesh").
Mesh import_mesh(const std::string& bytes, const std::string& extension, const std::string& name);

/// The answer of the process. `message` is replaced.
void pack_mesh(const Mesh& mesh, std::vector<std::byte>& message);
/// False if the message is damaged, or has an index without a corner, or more than kMostTriangles triangles.
bool unpack_mesh(std::span<const std::byte> message, Mesh& mesh);

}  // namespace polyarm::meshes
