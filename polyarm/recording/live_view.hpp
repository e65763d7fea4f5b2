#pragma once
/// What a running cell tells those who watch it by Foxglove's protocol.
#include <memory>

#include "polyarm/recording/foxglove_server.hpp"

namespace polyarm::cell {
class CellView;
}

namespace polyarm::recording {

/// Gives the channels of a cell to a server's clients: what changes all the time 50 times a second, and only
/// where somebody watches it; tags, lines and log as they come. Meshes of the descriptions can be fetched.
/// Cell thread; the server outlives it, and it goes before the cell does.
class LiveView {
 public:
  LiveView(cell::CellView& cell, FoxgloveServer& server);
  ~LiveView();
  /// Each tick. True where a client has been given something.
  bool serve();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::recording
