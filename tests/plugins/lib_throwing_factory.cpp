#include "tests/plugins/things.hpp"

namespace {
class Refuser : public things::Follower {
 public:
  Refuser() { throw std::runtime_error("no licence found"); }
};
class Nothing : public things::Holder {
 public:
  Nothing() { throw 7; }
};
}  // namespace

POLYARM_PLUGIN("throwing_factory", "1.0.0", POLYARM_HARDWARE("throwing/Hardware", Refuser, "cannot be made"),
               POLYARM_CONTROLLER("throwing/Controller", Nothing, "cannot be made"))
