#pragma once
/// A running cell: built from its files, stepped by the one who runs it. The front door of the room.
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

/// Building: any one thread. tick(): the cell thread; the loop's step: the control thread (the same one in
/// lock-step). Addresses are stable: it is neither copied nor moved.
class Cell {
 public:
  /// Nanoseconds of cell time between ticks.
  static constexpr Nanoseconds kTick = 2'000'000;

  /// Throws Error with everything that is wrong in any file.
  Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
       Observer& observer);
  ~Cell();
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  /// One tick at cell time `now` on the newest snapshot.
  void tick(Nanoseconds now);
  /// What doors see of the cell. It lives as long as the cell does.
  CellView& view();
  /// What is asked of it and done to it.
  Requests& requests();
  /// `observer` hears from now on what happens; the one that the cell was built with is the first.
  void add_observer(Observer& observer);
  void remove_observer(Observer& observer);
  /// What records the cell; null where nothing can. It goes before the cell does.
  Recorder* recorder();
  void set_recorder(std::unique_ptr<Recorder> recorder);

 private:
  friend CellInside& inside_of(Cell& cell);
  std::unique_ptr<CellInside> inside_;
  std::unique_ptr<CellView> view_;
};

/// The inside of a cell, for those who run it: the runner, and tests.
CellInside& inside_of(Cell& cell);

}  // namespace polyarm::cell
