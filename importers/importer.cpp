#include "importers/importer.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <vector>

#include "polyarm/meshes/mesh_process.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/confinement.hpp"

namespace polyarm::meshes {
namespace {

void limit_work(std::size_t bytes, bool step) {
  const rlim_t seconds = import_seconds(bytes, step);
  const rlimit file{kMostImportBytes, kMostImportBytes}, time{seconds, seconds};
  ::setrlimit(RLIMIT_FSIZE, &file);
  ::setrlimit(RLIMIT_CPU, &time);
}

std::string read_all(int descriptor) {
  std::string out;
  char bytes[65536];
  for (ssize_t count = 0; (count = ::read(descriptor, bytes, sizeof bytes)) > 0;)
    out.append(bytes, static_cast<std::size_t>(count));
  return out;
}

bool write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

int run_importer(int argc, char** argv, std::size_t most_memory,
                 const std::function<Mesh(const std::string&, const std::string&)>& read) {
  const int parent = argc == 3 ? std::atoi(argv[1]) : 0;
  if (parent <= 0) {
    std::fputs("polyarm starts this program to read a mesh file\n", stderr);
    return 2;
  }
  process::ChildRules rules;
  rules.handed = 2;
  rules.parent = parent;
  rules.most_memory = most_memory;
  if (!process::become_child(rules)) return 1;
  process::filter_calls();
  process::confine(
      {.readable = {}, .connects = std::vector<std::uint16_t>{}, .listens = std::vector<std::uint16_t>{}});
  int code = 1;
  try {
    const std::string bytes = read_all(kImportFile), kind = argv[2];
    limit_work(bytes.size(), is_step("." + kind));
    std::vector<std::byte> message;
    pack_mesh(read(bytes, kind), message);
    if (write_all(kImportAnswer, message)) code = 0;
  } catch (const Refused& refused) {
    std::fprintf(stderr, "%s\n", refused.why.c_str());
    code = kImportRefused;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
  }
  std::fflush(stderr);
  ::_exit(code);  // without the destructors of a library that has read a hostile file
}

}  // namespace polyarm::meshes
