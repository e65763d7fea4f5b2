#include "polyarm/base/cache.hpp"

#include <set>
#include <system_error>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"

namespace polyarm {

namespace fs = std::filesystem;

void store_in_cache(const fs::path& path, std::string_view content, std::size_t most, unsigned mode) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  std::set<std::pair<fs::file_time_type, fs::path>> there;
  for (const auto& entry : fs::directory_iterator(path.parent_path(), error))
    if (entry.path().extension() == path.extension())
      there.emplace(entry.last_write_time(error), entry.path());
  for (; there.size() >= most; there.erase(there.begin())) fs::remove(there.begin()->second, error);
  Problems ignored;
  collect(ignored, [&] { write_file_atomically(path, content, mode); });
}

}  // namespace polyarm
