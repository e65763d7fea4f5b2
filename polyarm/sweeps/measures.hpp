#pragma once
/// What is measured in each tick of a variant. Cell thread; allocates.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/inside/inside.hpp"
#include "polyarm/sweeps/row.hpp"

namespace polyarm::sweeps {

/// Joints, ways and passes of all robots of a cell. SI units.
class Measures {
 public:
  explicit Measures(const cell::CellInside& cell);
  void look(Nanoseconds now);
  void put_into(Row& row) const;

 private:
  struct Joint {
    std::string name;
    bool continuous = false;
    double lower = 0, upper = 0, speed = 0, effort = 0;  ///< limits
    int effort_state = -1, velocity_state = -1;
  };
  struct Extreme {
    double value = 0;
    std::string joint;
  };
  void look_at_joints(const control::Snapshot& snapshot);
  void look_at_passes(Nanoseconds now);

  const cell::CellInside& cell_;
  std::vector<Joint> joints_;
  std::vector<double> before_, now_;
  std::vector<Vec3> tcps_;
  double path_ = 0;
  std::optional<double> energy_;
  std::optional<Extreme> speed_, effort_, limit_;
  std::vector<double> passes_;      ///< end of each pass, s
  std::optional<double> ended_at_;  ///< of the program, s
};

/// Points of the cell in the world that the robot cannot reach.
std::size_t points_out_of_reach(const cell::CellInside& cell, std::size_t robot);

}  // namespace polyarm::sweeps
