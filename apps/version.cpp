#include <fmt/format.h>

#include "apps/verb.hpp"

namespace polyarm::apps {

int run_version(int, char**) {
  fmt::print("polyarm {}\n", POLYARM_VERSION);
  return kOk;
}

}  // namespace polyarm::apps
