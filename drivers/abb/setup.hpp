#pragma once
/// `polyarm setup abb`: looks at a controller and offers our RAPID module. Nothing moves.
#include <functional>
#include <string>

#include "drivers/abb/rapid.hpp"
#include "drivers/abb/rws.hpp"

namespace polyarm::abb {

struct SetupOptions {
  std::string host;       ///< empty: the address of the controller's service port
  int rws = 0, port = 0;  ///< 0: both versions are tried, at their own ports
  std::string user = "Default User", password = "robotics", task = "T_ROB1";
  int egm_port = 6510;
  bool forward = false;  ///< the module of forward mode, not that of EGM
  int moves_port = kMovesPort;
  RapidSettings rapid;
  std::string folder;    ///< where the texts are written; empty: nowhere
  bool install = false;  ///< loads the module into the controller, after a yes
  Nanoseconds timeout = 3'000'000'000;
};

/// Talks with a person.
class SetupTalk {
 public:
  virtual ~SetupTalk() = default;
  virtual void say(const std::string& text) = 0;
  virtual bool agree(const std::string& question) = 0;
};

/// True if everything that the driver needs is there. Throws Error if a file cannot be written.
bool set_up(const SetupOptions& options, SetupTalk& talk);

}  // namespace polyarm::abb
