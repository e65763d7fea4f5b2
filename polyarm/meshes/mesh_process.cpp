#include "polyarm/meshes/mesh_process.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/packing.hpp"

namespace polyarm::meshes {

namespace {

struct Library {
  const char* program;
  const char* name;
  const char* advice;
};
constexpr Library kAssimp{
    "polyarm_mesh_import", "Assimp",
    "install libassimp-dev and build again, or convert the mesh to STL, OBJ or Collada (.dae)"},
    kOpenCascade{"polyarm_step_import", "Open CASCADE",
                 "install libocct-data-exchange-dev and build again, or convert the file to STL, OBJ or 3MF"};
constexpr struct {
  const char* extension;
  const char* name;  ///< empty: another name of the format before
  const Library& library;
} kFormats[] = {{".glb", "GLB", kAssimp},
                {".gltf", "glTF", kAssimp},
                {".ply", "PLY", kAssimp},
                {".step", "STEP", kOpenCascade},
                {".stp", "", kOpenCascade}};
constexpr std::size_t kMostParts = bounds::kImportParts;
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

/// Images that are not acceptable are left out.
bool unpack_images(process::Unpacker& in, std::vector<Image>& images) {
  const std::size_t count = in.number<std::uint32_t>();
  if (!in.good() || count > kMostImages) return false;
  for (std::size_t i = 0; i < count; ++i) {
    std::string bytes = in.text(kMostImageBytes);
    if (!in.good()) return false;
    images.push_back(why_no_image(bytes).empty() ? std::make_shared<const std::string>(std::move(bytes))
                                                 : Image());
  }
  return true;
}

bool unpack_part(process::Unpacker& in, MeshPart& part, const std::vector<Image>& images) {
  if (!unpack_array(in, part.positions) || !unpack_array(in, part.normals) ||
      !unpack_array(in, part.texcoords) || !unpack_array(in, part.triangles))
    return false;
  part.colored = in.truth();
  const auto share = [&in] { return std::clamp(in.number<float>(), 0.f, 1.f); };
  for (float& value : part.color) value = share();
  part.roughness = share();
  part.metallic = share();
  for (const float value :
       {part.color[0], part.color[1], part.color[2], part.color[3], part.roughness, part.metallic})
    if (!(value >= 0)) return false;
  const std::size_t image = in.number<std::uint32_t>();  // from 1; 0: none
  if (image > images.size()) return false;
  if (image > 0) part.image = images[image - 1];
  const auto has_corner = [&part](std::uint32_t index) { return index < part.positions.size(); };
  return in.good() && part.triangles.size() % 3 == 0 &&
         std::all_of(part.triangles.begin(), part.triangles.end(), has_corner);
}

const Library& library_of(const std::string& extension) {
  for (const auto& format : kFormats)
    if (extension == format.extension) return format.library;
  return kAssimp;
}

}  // namespace

bool is_imported(const std::string& extension) {
  return std::any_of(std::begin(kFormats), std::end(kFormats),
                     [&](const auto& format) { return extension == format.extension; });
}

bool is_step(const std::string& extension) {
  return extension == ".step" || extension == ".stp";
}

std::string imported_formats() {
  std::vector<std::string> names;
  for (const auto& format : kFormats)
    if (*format.name) names.emplace_back(format.name);
  const std::string last = names.back();
  names.pop_back();
  return join(names, ", ") + " or " + last;
}

void pack_mesh(const Mesh& mesh, std::vector<std::byte>& message) {
  process::Packer out(message);
  std::vector<const std::string*> images;
  std::vector<std::uint32_t> image_of;
  for (const MeshPart& part : mesh) {
    const auto at = std::find(images.begin(), images.end(), part.image.get());
    image_of.push_back(part.image ? static_cast<std::uint32_t>(at - images.begin()) + 1 : 0);
    if (part.image && at == images.end()) images.push_back(part.image.get());
  }
  out.number(static_cast<std::uint32_t>(images.size()));
  for (const std::string* image : images) out.text(*image);
  out.number(static_cast<std::uint32_t>(mesh.size()));
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const MeshPart& part = mesh[i];
    pack_array(out, part.positions);
    pack_array(out, part.normals);
    pack_array(out, part.texcoords);
    pack_array(out, part.triangles);
    out.number(static_cast<std::uint8_t>(part.colored));
    for (const float value : part.color) out.number(value);
    out.number(part.roughness).number(part.metallic).number(image_of[i]);
  }
}

bool unpack_mesh(std::span<const std::byte> message, Mesh& mesh) {
  mesh.clear();
  process::Unpacker in(message);
  std::vector<Image> images;
  if (!unpack_images(in, images)) return false;
  const std::size_t parts = in.number<std::uint32_t>();
  if (!in.good() || parts > kMostParts) return false;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < parts; ++i) {
    if (!unpack_part(in, mesh.emplace_back(), images)) return false;
    corners += mesh.back().triangles.size();
    if (corners > 3 * kMostTriangles) return false;
  }
  return in.rest().empty();
}

Mesh import_mesh(const std::string& bytes, const std::string& extension, const std::string& name) {
  const Library& library = library_of(extension);
  const std::string program = process::find_program(library.program);
  if (program.empty())
    throw Error("unknown-mesh",
                "the mesh " + name + " needs " + library.name + ", which this build of Polyarm lacks",
                library.advice);
  const Descriptor file = memory_file(bytes, name);
  const Descriptor answer = memory_file({}, name);
  process::Child child;
  const int handed[] = {file.number(), answer.number()};
  child.start(program, {std::to_string(::getpid()), extension.substr(1)}, handed);
  const process::Ending ending =
      child.finish(kBusyMachine * std::chrono::seconds(import_seconds(bytes.size(), is_step(extension))));
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
