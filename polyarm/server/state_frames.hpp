#pragma once
/// What moves, as binary frames: all numbers of a cell that a page shows many times a second.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/client.hpp"

namespace polyarm::server {

/// Fields: every state interface under its name; every command as `<joint>/command_<interface>`; of each
/// robot `<robot>/tcp/{x, y, z, qx, qy, qz, qw, speed}` (world, as if a base that drives stood where it
/// began; m, m/s) and, where its base drives, `<robot>/base/{position.x … orientation.w}` (world, m), which
/// in physics are state interfaces; of the loop `loop/period_us`, `loop/cost_us` (medians so far),
/// `loop/late`. Cell thread.
class StateFrames {
 public:
  /// The cell outlives this. `layout`: a number that tells layouts apart.
  StateFrames(cell::CellView& cell, std::uint16_t layout);

  /// {"event": "layout", "id", "fields": [{name, unit}]}
  const Text& layout() const { return layout_; }
  /// Little-endian: u8 1, u8 0, u16 layout, u32 sequence, f64 cell time (s), f32 for each field; not a number
  /// where it is not known.
  Text frame();

 private:
  struct Field {
    std::string name, unit;
  };
  void add(std::string name, std::string unit) { fields_.push_back({std::move(name), std::move(unit)}); }

  cell::CellView& cell_;
  std::uint16_t id_;
  std::uint32_t sequence_ = 0;
  std::vector<Field> fields_;
  std::vector<std::size_t> wheeled_;  ///< robots whose base is known by its odometry alone
  std::vector<Pose> before_;
  double before_time_ = -1;
  std::vector<double> speed_;
  Text layout_;
};

}  // namespace polyarm::server
