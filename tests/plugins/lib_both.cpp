#include "tests/plugins/things.hpp"

POLYARM_PLUGIN("both", "1.2.3",
               POLYARM_HARDWARE("things/Follower", things::Follower, "follows what it is told"),
               POLYARM_CONTROLLER("things/Holder", things::Holder, "holds one joint"))
