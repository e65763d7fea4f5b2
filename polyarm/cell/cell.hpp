#pragma once
/// A running cell, built from its files and stepped by its runner. This is the room's main header.
#include <memory>

#include "polyarm/base/time.hpp"
#include "polyarm/setup/cell_options.hpp"

namespace polyarm::description {
class Catalogue;
}

namespace polyarm::cell {

struct CellFile;
struct CellInside;
class CellView;
class Observer;
class Recorder;
class Requests;

/// Threads: construct on any one thread; call tick() on the cell thread; the loop's step runs on the control
/// thread (the same thread in lock-step). A cell cannot be copied or moved, so references to it stay valid.
class Cell {
 public:
  /// Interval between ticks, ns of cell time.
  static constexpr Nanoseconds kTick = 2'000'000;

  /// Throws Error that lists all problems found in the files.
  Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
       Observer& observer);
  ~Cell();
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  /// Runs one tick at cell time `now` on the newest snapshot of the control loop.
  void tick(Nanoseconds now);
  /// The view that doors use. It lives as long as the cell.
  CellView& view();
  /// The entry point for requests to this cell.
  Requests& requests();
  /// Adds an observer that receives events from now on, after the observers added before it. The
  /// constructor's observer is the first.
  void add_observer(Observer& observer);
  void remove_observer(Observer& observer);
  /// The recorder; null if the cell cannot record. Destroyed before the cell's inside.
  Recorder* recorder();
  void set_recorder(std::unique_ptr<Recorder> recorder);

 private:
  friend CellInside& inside_of(Cell& cell);
  std::unique_ptr<CellInside> inside_;
  std::unique_ptr<CellView> view_;
};

/// Internal state of a cell, for the runner and for tests.
CellInside& inside_of(Cell& cell);

}  // namespace polyarm::cell
