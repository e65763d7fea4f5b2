#pragma once
/// Which doors there are: what a cell's file may say of each, under its name. The rooms below know none.
#include <string>
#include <vector>

namespace polyarm::cell {

struct DoorKind {
  std::string name;               ///< of its key in a cell, and of its module: polyarm_door_<name>.so
  std::vector<std::string> keys;  ///< of its options
  std::string advice;             ///< where its module is not installed
};

/// Before any cell's file is read; one thread.
void register_door(DoorKind kind);
const std::vector<DoorKind>& door_kinds();

}  // namespace polyarm::cell
