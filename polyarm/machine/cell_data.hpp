#pragma once
/// The data of a cell and what it exchanges with the outside: tags, variables and points, their files, links,
/// cameras.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/control/control_loop.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/io/camera.hpp"
#include "polyarm/io/data_files.hpp"
#include "polyarm/io/heartbeats.hpp"
#include "polyarm/io/links.hpp"
#include "polyarm/io/tag_binding.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// What the cell itself says as tags.
struct OwnStates {
  double passes = 0;
  int line = 0;
  bool running = false, held = false, fault = false;
  std::vector<Vec3> tcps;  ///< by robot, in the world
};

/// Cell thread.
class CellData {
 public:
  CellData(const CellSetup& setup, Observer& observer) : setup_(setup), observer_(observer) {}

  // Building, in this order.
  void build(const hardware::InterfaceTable& table, Worker& worker, Problems& problems);
  /// The named states of descriptions (SRDF, catalogue) are points that a program may move to; names from the
  /// cell's data files go before them. In a cell of several robots the robot's name comes before the state's.
  void offer_named_states();
  /// Once the programs' data are there.
  void connect_links(Problems& problems);
  void end_building() { reported_version_ = store.version(); }

  // Once each tick, in this order. `carrier_of`: the flange in the world that carries a camera.
  void read(Nanoseconds now, const control::Snapshot& snapshot, const OwnStates& states);
  template <class CarrierOf>
  void look(const control::Snapshot& snapshot, CarrierOf carrier_of) {
    for (Camera& camera : cameras_) camera.tick(snapshot.world, store, carrier_of(camera));
  }
  /// Why the cell may not run now: a link or a sign of life is missing. Reports news of links.
  const std::optional<Problem>& watch_links(Nanoseconds now);
  /// Programs begin when the links are there.
  bool links_ready() const { return links_ready_; }
  /// Tags to interfaces and links, or what their rules say. `over`: the programs have ended, or the run has
  /// failed.
  void write(Nanoseconds now, const control::Snapshot& snapshot, bool over);
  void exchange_files(Nanoseconds now);
  /// Reports values that have changed.
  void report_changes(Nanoseconds now);

  /// Whether what outputs are to have at the end has gone out.
  bool outputs_settled(Nanoseconds now) const;
  DataFiles& files() const { return *files_; }
  const CellLinks& links() const { return *links_; }
  TagBinding& tags() const { return *tags_; }
  const signals::Signals& signals() const { return signals_; }

  data::DataStore store;

 private:
  void add_own_states();
  void add_cameras(Problems& problems);
  void set_own(const OwnStates& states);

  const CellSetup& setup_;
  Observer& observer_;
  std::unique_ptr<DataFiles> files_;
  CellStates states_;
  signals::Signals signals_;
  std::unique_ptr<TagBinding> tags_;
  std::unique_ptr<CellLinks> links_;
  std::unique_ptr<Heartbeats> heartbeats_;
  std::vector<Camera> cameras_;
  std::size_t pass_state_ = 0, running_state_ = 0, line_state_ = 0, held_state_ = 0, fault_state_ = 0;
  std::vector<std::array<std::size_t, 3>> tcp_states_;
  bool links_ready_ = false, reported_waiting_ = false;
  std::optional<Problem> missing_;
  Nanoseconds stopped_at_ = -1;  // since when outputs have what they are to have at the end
  std::uint64_t reported_version_ = 0;
};

}  // namespace polyarm::cell
