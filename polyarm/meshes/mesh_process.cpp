#include "polyarm/meshes/mesh_process.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>

#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/packing.hpp"

namespace polyarm::meshes {

namespace {

constexpr const char* kProgram = "polyarm_mesh_import";
constexpr struct {
  const char* extension;
  const char* name;
} kFormats[] = {{".glb", "GLB"}, {".gltf", "glTF"}, {".ply", "PLY"}};
constexpr std::size_t kMostParts = 10'000;
constexpr int kBusyMachine = 10;  // wall time for each second of processor time

[[noreturn]] void fail(const std::string& name, const std::string& why) {
  throw Error("bad-mesh", "the mesh " + name + " cannot be read: " + why, "export it again");
}

Descriptor memory_file(const std::string& bytes, const std::string& name) {
  Descriptor out(::memfd_create("mesh", MFD_CLOEXEC));
  if (!out) fail(name, "there is no memory for it");
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::write(out.number(), bytes.data() + at, bytes.size() - at);
    if (count <= 0) fail(name, "there is no memory for it");
    at += static_cast<std::size_t>(count);
  }
  ::lseek(out.number(), 0, SEEK_SET);
  return out;
}

std::vector<std::byte> content_of(const Descriptor& file, const std::string& name) {
  struct stat about {};
  if (::fstat(file.number(), &about) != 0 || about.st_size < 0) fail(name, "its triangles did not arrive");
  std::vector<std::byte> out(
      std::min<std::size_t>(static_cast<std::size_t>(about.st_size), kMostImportBytes));
  std::size_t at = 0;
  while (at < out.size()) {
    const ssize_t count = ::pread(file.number(), out.data() + at, out.size() - at, static_cast<off_t>(at));
    if (count <= 0) break;
    at += static_cast<std::size_t>(count);
  }
  out.resize(at);
  return out;
}

template <class T>
void pack_array(process::Packer& out, const std::vector<T>& values) {
  out.number(static_cast<std::uint32_t>(values.size()));
  out.rest(std::as_bytes(std::span(values)));
}

template <class T>
bool unpack_array(process::Unpacker& in, std::vector<T>& values) {
  const std::size_t count = in.number<std::uint32_t>();
  if (!in.good() || count > 3 * kMostTriangles) return false;
  const std::span<const std::byte> bytes = in.take(count * sizeof(T));
  if (!in.good()) return false;
  values.resize(count);
  if (count > 0) std::memcpy(values.data(), bytes.data(), bytes.size());
  return true;
}

bool unpack_part(process::Unpacker& in, MeshPart& part) {
  if (!unpack_array(in, part.positions) || !unpack_array(in, part.normals) ||
      !unpack_array(in, part.triangles))
    return false;
  part.colored = in.truth();
  const auto share = [&in] { return std::clamp(in.number<float>(), 0.f, 1.f); };
  for (float& value : part.color) value = share();
  part.roughness = share();
  part.metallic = share();
  for (const float value :
       {part.color[0], part.color[1], part.color[2], part.color[3], part.roughness, part.metallic})
    if (!(value >= 0)) return false;
  const auto has_corner = [&part](std::uint32_t index) { return index < part.positions.size(); };
  return in.good() && part.triangles.size() % 3 == 0 &&
         std::all_of(part.triangles.begin(), part.triangles.end(), has_corner);
}

}  // namespace

bool is_imported(const std::string& extension) {
  return std::any_of(std::begin(kFormats), std::end(kFormats),
                     [&](const auto& format) { return extension == format.extension; });
}

std::string imported_formats() {
  std::string out;
  for (const auto& format : kFormats) out += (out.empty() ? "" : ", ") + std::string(format.name);
  return out;
}

void pack_mesh(const Mesh& mesh, std::vector<std::byte>& message) {
  process::Packer out(message);
  out.number(static_cast<std::uint32_t>(mesh.size()));
  for (const MeshPart& part : mesh) {
    pack_array(out, part.positions);
    pack_array(out, part.normals);
    pack_array(out, part.triangles);
    out.number(static_cast<std::uint8_t>(part.colored));
    for (const float value : part.color) out.number(value);
    out.number(part.roughness).number(part.metallic);
  }
}

bool unpack_mesh(std::span<const std::byte> message, Mesh& mesh) {
  mesh.clear();
  process::Unpacker in(message);
  const std::size_t parts = in.number<std::uint32_t>();
  if (!in.good() || parts > kMostParts) return false;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < parts; ++i) {
    if (!unpack_part(in, mesh.emplace_back())) return false;
    corners += mesh.back().triangles.size();
    if (corners > 3 * kMostTriangles) return false;
  }
  return in.rest().empty();
}

Mesh import_mesh(const std::string& bytes, const std::string& extension, const std::string& name) {
  const std::string program = process::find_program(kProgram);
  if (program.empty())
    throw Error("unknown-mesh", "the mesh " + name + " needs Assimp, which this build of Polyarm lacks",
                "install libassimp-dev and build again, or convert the mesh to STL, OBJ or Collada (.dae)");
  const Descriptor file = memory_file(bytes, name);
  const Descriptor answer = memory_file({}, name);
  process::Child child;
  const int handed[] = {file.number(), answer.number()};
  child.start(program, {std::to_string(::getpid()), extension.substr(1)}, handed);
  const process::Ending ending =
      child.finish(kBusyMachine * std::chrono::seconds(import_seconds(bytes.size())));
  if (ending.code == kImportRefused)
    fail(name, ending.last_words.empty() ? "it is damaged" : ending.last_words);
  if (ending.signal == SIGXCPU || ending.signal == SIGKILL)
    fail(name, "the process that read it took too long or too much memory; it may be damaged");
  if (ending.signal != 0 || ending.code != 0) fail(name, "the process that read it " + ending.text());
  Mesh out;
  if (!unpack_mesh(content_of(answer, name), out))
    throw Error("large-mesh",
                "the mesh " + name + " has more than " + std::to_string(kMostTriangles) +
                    " triangles, or damaged ones",
                "simplify it, and export it again");
  return out;
}

}  // namespace polyarm::meshes
