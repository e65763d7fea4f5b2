#pragma once
/// Chooses the reduced profile while a tag is true, or while a TCP is beyond a boundary that asks for it.
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::cell {

class CellData;
class Machine;
class Motions;
class Observer;
struct CellSetup;

/// Cell thread. Without a reason the profile is the one that was asked for.
class ProfileChoice {
 public:
  struct Owners {
    const CellSetup& setup;
    Machine& machine;
    CellData& data;
    Motions& motions;
    Observer& observer;
  };
  explicit ProfileChoice(const Owners& cell) : cell_(cell) {}

  /// Call when all data are loaded. Adds an error for a tag that the cell does not have.
  void build(Problems& problems);
  /// Call each tick before motions.
  void tick();

 private:
  std::string reason();

  Owners cell_;
  bool chosen_ = false;
  Nanoseconds since_ = -1;  // without a reason
};

}  // namespace polyarm::cell
