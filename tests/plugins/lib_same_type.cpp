#include "tests/plugins/things.hpp"

POLYARM_PLUGIN("same_type", "1.0.0", POLYARM_CONTROLLER("things/New", things::Holder, "holds one joint"),
               POLYARM_HARDWARE("things/Follower", things::Follower, "follows what it is told"))
