#include "polyarm/base/installation.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <system_error>

namespace polyarm::installation {

namespace fs = std::filesystem;

namespace {
constexpr int kLevels = 5;

fs::path& named() {
  static fs::path prefix;
  return prefix;
}

fs::path executable_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path folder_of(const void* code) {
  Dl_info info{};
  if (!code || ::dladdr(code, &info) == 0 || !info.dli_fname) return {};
  std::error_code error;
  return fs::absolute(info.dli_fname, error).parent_path();
}
}  // namespace

void use(const fs::path& prefix) {
  named() = prefix;
}

std::vector<fs::path> program_folders(const void* code) {
  std::vector<fs::path> out;
  const auto add = [&out](const fs::path& folder) {
    if (std::find(out.begin(), out.end(), folder) == out.end()) out.push_back(folder);
  };
  if (!named().empty())
    for (const char* below : {"drivers", "lib/polyarm"}) add(named() / below);
  for (const fs::path& here : {folder_of(code), executable_folder()}) {
    if (here.empty()) continue;
    for (const fs::path& folder :
         {here, here / "drivers", here.parent_path() / "drivers", here.parent_path() / "lib" / "polyarm"})
      add(folder);
  }
  return out;
}

std::vector<fs::path> data_folders(std::string_view name, std::string_view proof) {
  std::vector<fs::path> out;
  std::error_code error;
  const auto search = [&](fs::path here) {
    for (int level = 0; level < kLevels && !here.empty(); ++level, here = here.parent_path())
      for (const fs::path& folder : {here / name, here / "share" / "polyarm" / name})
        if (fs::exists(folder / proof, error) && std::find(out.begin(), out.end(), folder) == out.end())
          out.push_back(folder);
  };
  search(named());
  search(executable_folder());
  return out;
}

}  // namespace polyarm::installation
