#pragma once
/// The data of a cell and their exchange with the outside: tags, variables and points, their files, links and
/// cameras.
#include <array>
#include <memory>
#include <optional>
#include <span>
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

/// The cell's own states, which it offers as tags.
struct OwnStates {
  double passes = 0;
  int line = 0;
  bool running = false, held = false, fault = false;
  std::span<const Vec3> tcps;  ///< by robot, in the world, m
};

/// Cell thread.
class CellData {
 public:
  CellData(const CellSetup& setup, Observer& observer) : setup_(setup), observer_(observer) {}

  // Construction; call in this order.
  void build(const hardware::InterfaceTable& table, Worker& worker, Problems& problems);
  /// Offers the named states of descriptions (SRDF, catalogue) as points that a program may move to. Names
  /// from the cell's data files take precedence. In a cell with several robots the state's name is prefixed
  /// with the robot's name.
  void offer_named_states();
  /// Call after the programs' data are loaded.
  void connect_links(Problems& problems);
  void end_building() { reported_version_ = store.version(); }

  // Call once each tick, in this order. `carrier_of` returns the pose in the world of the flange that carries
  // a camera.
  void read(Nanoseconds now, const control::Snapshot& snapshot, const OwnStates& states);
  template <class CarrierOf>
  void look(const control::Snapshot& snapshot, CarrierOf carrier_of) {
    for (Camera& camera : cameras_) camera.tick(snapshot.world, store, carrier_of(camera));
  }
  /// Why the cell may not run now: a link or a heartbeat is missing. Reports changes of links.
  const std::optional<Problem>& watch_links(Nanoseconds now);
  /// True when programs may start because their links are up.
  bool links_ready() const { return links_ready_; }
  /// Writes tags, or the values of their rules, to interfaces and links. `over`: the programs have ended or
  /// the run has failed.
  void write(Nanoseconds now, const control::Snapshot& snapshot, bool over);
  void exchange_files(Nanoseconds now);
  /// Reports values that have changed to the observer.
  void report_changes(Nanoseconds now);

  /// True when the final values of the outputs were sent.
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
  Nanoseconds stopped_at_ = -1;  // time at which outputs got their final values; -1: not yet
  std::uint64_t reported_version_ = 0;
};

}  // namespace polyarm::cell
