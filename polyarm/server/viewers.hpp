#pragma once
/// Read-only viewers on the pendant's port: Foxglove, Lichtblick, PlotJuggler.
#include <functional>
#include <memory>
#include <string>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/stream.hpp"

namespace polyarm::server {

/// Viewers move nothing and take no control. All members but welcome() belong to the cell thread.
class Viewers {
 public:
  explicit Viewers(const std::string& version);
  ~Viewers();
  /// I/O thread. Null: too many are connected.
  std::shared_ptr<Stream> welcome();
  /// `wake` is called, from any thread, when a viewer has something to send between two calls of serve().
  void set_wake(std::function<void()> wake);
  void attach(cell::CellView& cell);
  void detach();
  /// Call each tick. Returns true if a viewer has something to send.
  bool serve();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
