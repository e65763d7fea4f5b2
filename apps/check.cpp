#include "apps/options.hpp"

namespace polyarm::apps {

int run_check(int argc, char** argv) {
  return kOk;
}

}  // namespace polyarm::apps
