#pragma once
/// Doors give clients access to a cell. Each is a module `polyarm_door_<name>.so` beside the executable,
/// loaded when a cell or its command line names it. A door holds no state of the cell: it receives reports
/// and posts requests.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

class CellView;

/// Options of a door in a cell file: `ros2: {domain: 3}` is {"domain", "3"}.
using DoorOptions = std::map<std::string, std::string>;

class Door {
 public:
  virtual ~Door() = default;
  /// Cell thread, each tick.
  virtual void serve() = 0;
  /// The bell that its threads ring when input has arrived that must not wait for the next tick; null: nobody
  /// listens any more. Cell thread.
  virtual void set_wakeup(const std::shared_ptr<realtime::Bell>& bell) {}
  /// Cell thread, between ticks, after the bell: hands over received input and does nothing else.
  virtual void take() {}
  /// One line for people: the address under which it is reached.
  virtual std::string address() const = 0;
};

/// Opens the door with this name; the cell must outlive it. Throws Error("no-door") if its module is not
/// installed, and the door's own errors.
std::unique_ptr<Door> open_door(const std::string& name, CellView& cell, const DoorOptions& options);

/// For the source of a module: POLYARM_DOOR(make), where `make` takes (CellView&, const DoorOptions&) and
/// returns a std::unique_ptr<Door>. Doors are part of Polyarm: they are built with the command and are no
/// plugins.
using MakeDoor = Door* (*)(CellView& cell, const DoorOptions& options);
#define POLYARM_DOOR(make)                                                                       \
  extern "C" polyarm::cell::Door* polyarm_open_door(polyarm::cell::CellView& cell,               \
                                                    const polyarm::cell::DoorOptions& options) { \
    return make(cell, options).release();                                                        \
  }

}  // namespace polyarm::cell
