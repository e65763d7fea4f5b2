#include "tests/plugins/things.hpp"

POLYARM_PLUGIN("no_slash", "1.0.0", POLYARM_HARDWARE("follower", things::Follower, "follows what it is told"))
