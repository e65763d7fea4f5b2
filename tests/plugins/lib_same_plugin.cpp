#include "tests/plugins/things.hpp"

POLYARM_PLUGIN("both", "2.0.0",
               POLYARM_HARDWARE("things/Another", things::Follower, "follows what it is told"))
