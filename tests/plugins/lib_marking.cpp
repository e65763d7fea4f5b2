/// A library whose code leaves a mark as soon as it is loaded.
#include <cstdio>
#include <cstdlib>

#include "tests/plugins/things.hpp"

namespace {
const bool marked = [] {
  if (const char* file = std::getenv("POLYARM_TEST_MARK"))
    if (std::FILE* out = std::fopen(file, "w")) std::fclose(out);
  return true;
}();
}  // namespace

POLYARM_PLUGIN("marking", "1.0.0", POLYARM_HARDWARE("marking/Follower", things::Follower, "follows"))
