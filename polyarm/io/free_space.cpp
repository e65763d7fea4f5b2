#include "polyarm/io/free_space.hpp"

#include <string>
#include <system_error>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

void require_free_space(const std::filesystem::path& folder, std::uintmax_t bytes, std::uintmax_t least) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error || (space.available >= bytes && space.available - bytes >= least)) return;
  throw Error("no-space",
              "the disk has " + std::to_string(space.available >> 20) + " MiB free, of which uploads leave " +
                  std::to_string(least >> 20) + " MiB",
              "delete files that nobody needs");
}

}  // namespace polyarm::cell
