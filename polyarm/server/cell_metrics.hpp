#pragma once
/// Counts what a cell does while it runs, for Prometheus and for the page of a site. Cell thread.
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/pendant.hpp"

namespace polyarm::server {

/// Counters go on over restarts of the cell.
class CellMetrics : public cell::Observer {
 public:
  static constexpr std::size_t kMostCauses = 64;  ///< further causes are counted as "other"
  static constexpr double kEvery_s = 0.1;

  explicit CellMetrics(std::string version) : version_(std::move(version)) {}
  void attach(cell::CellView& cell, double now);
  void detach(double now);
  /// Call each tick; `now`: s, steady.
  void tick(double now);

  std::string prometheus(const Pendant::Counts& counts) const;
  /// The same for a site's page: state, program, faults in words, and the counters that OEE figures need.
  nlohmann::json summary(const Pendant::Counts& counts) const;

  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override;

 private:
  void sample(double now);
  std::map<std::string, double> parts() const;

  const std::string version_;
  cell::CellView* cell_ = nullptr;
  double sampled_ = 0;
  std::array<double, control::kRunStates> state_s_{};
  double no_cell_s_ = 0;
  std::map<std::string, double> program_s_;
  std::string program_state_ = "none";
  std::uint64_t passes_ = 0, last_passes_ = 0, restarts_ = 0;
  double working_s_ = 0;  ///< the program runs, and the cell is not held
  std::map<std::string, std::uint64_t> faults_;
};

}  // namespace polyarm::server
