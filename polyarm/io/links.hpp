#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/io/tag_binding.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::cell {

/// The links of a cell at work: what comes goes into the store, what the store has goes out. Cell thread.
class CellLinks {
 public:
  /// Where programs and modules of links are looked for: beside the command and its drivers.
  static std::vector<std::filesystem::path> module_folders();

  /// Declares the names that only a link has, and fills the states `link/NAME/up` and `link/NAME/losses`.
  /// `off`: nothing is connected. Problems: programs that are not installed, names of another type.
  CellLinks(const signals::Signals& signals, CellStates& own, data::DataStore& store, bool lock_step,
            bool off, Problems& problems);

  bool any() const { return !links_.empty(); }
  /// Whether every link that the cell waits for has been up once: before that the programs do not begin.
  bool ready() const;
  /// A link that the cell holds without is lost now; why.
  std::optional<Problem> lost() const;
  /// Whether any link that has been up is not, held or not.
  bool any_down() const;
  /// What came, into the store.
  void read(Nanoseconds now);
  /// What changed, to the far sides.
  void write(const signals::Situation& situation);
  /// Whether the far sides that there are have got it.
  bool idle() const;
  /// What was refused, lost and found since the last call.
  std::vector<Problem> take_news() { return std::exchange(news_, {}); }

  /// Of one name: its link and direction ("plc, in"), and whether its value can be trusted now.
  struct Source {
    std::string link, direction, quality;  ///< quality: good, stale, none (never heard of)
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
    std::vector<const signals::Tag*> rules;        ///< by tag: what goes out in place of its value, or null
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
