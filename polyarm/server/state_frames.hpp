#pragma once
/// Binary frames with all numbers of a cell that a page shows many times a second.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/client.hpp"

namespace polyarm::server {

/// Fields:
/// - each state interface under its own name;
/// - each command as `<joint>/command_<interface>`;
/// - of each robot `<robot>/tcp/{x, y, z, qx, qy, qz, qw, speed}` (m, m/s; world frame, with a mobile base
///   taken at its start pose);
/// - of each robot with a mobile base `<robot>/base/{position.x … orientation.w}` (world frame, m); in
///   physics these are state interfaces;
/// - of the control loop `loop/period_us`, `loop/cost_us` (medians so far) and `loop/late`.
/// Cell thread.
class StateFrames {
 public:
  /// The cell must outlive this. `layout`: a number that identifies this layout.
  StateFrames(cell::CellView& cell, std::uint16_t layout);

  /// {"event": "layout", "id", "fields": [{name, unit}]}
  const Text& layout() const { return layout_; }
  /// Little-endian: u8 1, u8 0, u16 layout, u32 sequence, f64 cell time (s), then f32 for each field; NaN
  /// where unknown.
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
  std::vector<std::size_t> wheeled_;  ///< robots whose base pose comes from odometry alone
  std::vector<Pose> before_;
  double before_time_ = -1;
  std::vector<double> speed_;
  Text layout_;
};

}  // namespace polyarm::server
