#pragma once
/// Binds tags to interfaces: states are copied to tags, tags to commands.
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/joint_control/forward_command_controller.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// States that the cell itself provides in addition to the hardware's: `program/pass`, `arm/tcp/x`, … Cell
/// thread.
class CellStates {
 public:
  std::size_t add(std::string name);
  void set(std::size_t index, double value) { values_[index] = value; }
  std::optional<std::size_t> find(std::string_view name) const;
  double value(std::size_t index) const { return values_[index]; }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::vector<std::string> names_;
  std::vector<double> values_;
};

/// Resolves the tags of a signals file once, then copies values each tick. Cell thread.
class TagBinding {
 public:
  /// Declares the tags in the store. Adds a problem for each interface that does not exist, with the nearest
  /// name.
  TagBinding(const std::vector<signals::Tag>& tags, const hardware::InterfaceTable& table,
             const CellStates& own, data::DataStore& store, Problems& problems);

  /// The command interfaces that tags drive, in the order of the values sent to `io`.
  const std::vector<std::string>& command_names() const { return command_names_; }
  void connect(controllers::ForwardCommandController* io) { io_ = io; }

  /// Copies states to tags.
  void read(std::span<const double> states, const CellStates& own);
  /// Copies tags, or the values that their rules give for the situation, to commands. Sends only if a value
  /// changed.
  void write(const signals::Situation& situation = {});
  /// The command value that was last sent for the tag; empty for a tag that is no output.
  std::optional<double> sent(const std::string& tag) const;

 private:
  struct In {
    signals::Tag tag;
    bool own = false;  ///< a state of the cell, not of the interface table
    std::size_t index = 0;
    double last = std::numeric_limits<double>::quiet_NaN();
  };
  struct Out {
    signals::Tag tag;
    std::size_t index = 0;  ///< index in command_names
  };
  data::DataStore& store_;
  std::vector<In> in_;
  std::vector<Out> out_;
  std::vector<std::string> command_names_;
  std::vector<double> values_;
  std::uint64_t seen_version_ = ~0ull;
  signals::Situation seen_situation_;
  controllers::ForwardCommandController* io_ = nullptr;
};

}  // namespace polyarm::cell
