#pragma once
/// Tools of others that watch a cell on the pendant's port: Foxglove, Lichtblick, PlotJuggler.
#include <functional>
#include <memory>
#include <string>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/stream.hpp"

namespace polyarm::server {

/// They move nothing and take no control. Everything but welcome() is the cell thread's.
class Viewers {
 public:
  explicit Viewers(const std::string& version);
  ~Viewers();
  /// I/O thread; null: there are too many.
  std::shared_ptr<Stream> welcome();
  /// Called, from any thread, when one of them has been given something between two calls of serve().
  void set_wake(std::function<void()> wake);
  void attach(cell::CellView& cell);
  void detach();
  /// True when somebody has been given something to send.
  bool serve();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
