#include "drivers/serial/ports.hpp"

#include <algorithm>
#include <set>
#include <string_view>

namespace polyarm::serial {

namespace fs = std::filesystem;

std::vector<std::string> list_ports(const fs::path& dev) {
  std::vector<std::string> named, others;
  std::set<fs::path> seen;
  std::error_code error;
  for (fs::directory_iterator at(dev / "serial" / "by-id", error), end; !error && at != end;
       at.increment(error)) {
    named.push_back(at->path().string());
    seen.insert(fs::weakly_canonical(at->path(), error));
  }
  for (fs::directory_iterator at(dev, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    for (const std::string_view prefix : {"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS"})
      if (name.starts_with(prefix) && !seen.contains(fs::weakly_canonical(at->path(), ignored)))
        others.push_back(at->path().string());
  }
  std::sort(named.begin(), named.end());
  std::sort(others.begin(), others.end());
  named.insert(named.end(), others.begin(), others.end());
  return named;
}

}  // namespace polyarm::serial
