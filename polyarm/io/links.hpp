#pragma once
/// Runs the links of a cell to external devices such as a PLC.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/io/tag_binding.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::cell {

/// Copies received values to the store, and changed values of the store to the remote devices. Cell thread.
class CellLinks {
 public:
  /// Folders searched for link programs and modules: those beside the executable and its drivers.
  static std::vector<std::filesystem::path> module_folders();

  /// Declares the names that only a link defines, and provides the states `link/NAME/up` and
  /// `link/NAME/losses`. With `off` nothing is connected. Adds problems for programs that are not installed
  /// and names with different types.
  CellLinks(const signals::Signals& signals, CellStates& own, data::DataStore& store, bool lock_step,
            bool off, Problems& problems);

  bool any() const { return !links_.empty(); }
  /// True when every link that the cell waits for has been up once; programs do not start before that.
  bool ready() const;
  /// Why a link that the cell must not run without is lost; empty if none is lost.
  std::optional<Problem> lost() const;
  /// True if any link that has been up is down now, whether or not it holds the cell.
  bool any_down() const;
  /// Writes received values to the store.
  void read(Nanoseconds now);
  /// Sends changed values to the remote devices.
  void write(const signals::Situation& situation);
  /// True when the connected devices have received all values.
  bool idle() const;
  /// Refused values, lost links and restored links since the last call.
  std::vector<Problem> take_reports() { return std::exchange(news_, {}); }

  /// The link and direction of a name ("plc, in"), and whether its value can be trusted now.
  struct Source {
    std::string link, direction, quality;  ///< quality: good, stale, or none (never received)
  };
  std::optional<Source> source_of(const std::string& name) const;
  struct Status {
    const signals::LinkEntry* entry = nullptr;
    signals::LinkState state;
  };
  std::vector<Status> status() const;

 private:
  struct Running {
    std::unique_ptr<signals::Link> link;
    signals::LinkState state;
    std::vector<std::optional<data::Value>> sent;  ///< by tag
    std::vector<const signals::Tag*> rules;        ///< by tag: a tag whose rules replace the value, or null
    std::size_t up_state = 0, losses_state = 0;
  };
  void declare(const signals::LinkEntry& entry, data::DataStore& store, Problems& problems) const;
  void take(Running& running, signals::LinkEvent& event);

  const std::vector<signals::Tag> tags_;
  CellStates& own_;
  data::DataStore& store_;
  bool lock_step_;
  std::vector<Running> links_;
  std::vector<Problem> news_;
  std::uint64_t seen_version_ = ~0ull;
  signals::Situation seen_situation_;
  Nanoseconds stepped_ = -1'000'000'000;
};

}  // namespace polyarm::cell
