#pragma once
/// Doors in modules: `polyarm_door_<name>.so` beside the command, loaded when a cell or its command line
/// names one. A door owns nothing: it reads what the cell tells and posts requests like everybody.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

class CellView;

/// What a cell says of a door: `ros2: {domain: 3}` is {"domain", "3"}.
using DoorOptions = std::map<std::string, std::string>;

class Door {
 public:
  virtual ~Door() = default;
  /// Cell thread, each tick.
  virtual void serve() = 0;
  /// What its threads ring when something has come in that is not to wait for the next tick; null: nobody
  /// hears it any more. Cell thread.
  virtual void set_bell(const std::shared_ptr<realtime::Bell>& bell) {}
  /// Cell thread, between ticks, after the bell: hands over what has come in, and nothing else.
  virtual void take() {}
  /// One line for a person: where it is reached.
  virtual std::string address() const = 0;
};

/// A door of that name into the cell, which must outlive it. Throws Error("no-door") where its module is not
/// installed, and what the door throws.
std::unique_ptr<Door> open_door(const std::string& name, CellView& cell, const DoorOptions& options);

/// In the source of a module: POLYARM_DOOR(make), where `make` takes (CellView&, const DoorOptions&) and
/// gives a std::unique_ptr<Door>. Doors are Polyarm's own: they are built with the command, and are no
/// plugins.
using MakeDoor = Door* (*)(CellView& cell, const DoorOptions& options);
#define POLYARM_DOOR(make)                                                                       \
  extern "C" polyarm::cell::Door* polyarm_open_door(polyarm::cell::CellView& cell,               \
                                                    const polyarm::cell::DoorOptions& options) { \
    return make(cell, options).release();                                                        \
  }

}  // namespace polyarm::cell
