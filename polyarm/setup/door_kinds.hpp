#pragma once
/// Registry of door types: the keys that a cell file may use for each door. The rooms below do not know any
/// door.
#include <string>
#include <vector>

namespace polyarm::cell {

struct DoorKind {
  std::string name;               ///< key in a cell file; the module is polyarm_door_<name>.so
  std::vector<std::string> keys;  ///< names of its options
  std::string advice;             ///< shown if its module is not installed
};

/// Call before any cell file is read; one thread.
void register_door(DoorKind kind);
const std::vector<DoorKind>& door_kinds();

}  // namespace polyarm::cell
