#pragma once
/// Publishes a running cell to viewers that use Foxglove's protocol.
#include <memory>

#include "polyarm/recording/foxglove_server.hpp"

namespace polyarm::cell {
class CellView;
}

namespace polyarm::recording {

/// Publishes the channels of a cell to a server's clients. Joint states, frames and interfaces are sent 50
/// times per second; tags, lines and log when they change. Meshes of the descriptions can be fetched. Cell
/// thread. The server must outlive this; the cell must outlive it, too.
class LiveView {
 public:
  LiveView(cell::CellView& cell, FoxgloveServer& server);
  ~LiveView();
  /// Call each tick. True if a client has something to send.
  bool serve();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::recording
