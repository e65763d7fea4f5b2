#pragma once
/// Tags tied to interfaces: states come in, commands go out.
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

/// States that the cell itself offers beside those of the hardware: `program/pass`, `arm/tcp/x`, … Cell
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

/// Resolves the tags of a signals file once, then copies values every tick. Cell thread.
class TagBinding {
 public:
  /// Declares the tags in the store. Problems: interfaces that do not exist, with the nearest name.
  TagBinding(const std::vector<signals::Tag>& tags, const hardware::InterfaceTable& table,
             const CellStates& own, data::DataStore& store, Problems& problems);

  /// Command interfaces that tags drive, in the order of the values given to `io`.
  const std::vector<std::string>& command_names() const { return command_names_; }
  void connect(controllers::ForwardCommandController* io) { io_ = io; }

  /// States into tags.
  void read(std::span<const double> states, const CellStates& own);
  /// Tags to commands, or what their rules say of the situation; sends only when something changed.
  void write(const signals::Situation& situation = {});
  /// What goes out for the tag now; nothing for a tag that is no output.
  std::optional<double> sent(const std::string& tag) const;

 private:
  struct In {
    signals::Tag tag;
    bool own = false;  ///< a state of the cell, not of the table
    std::size_t index = 0;
    double last = std::numeric_limits<double>::quiet_NaN();
  };
  struct Out {
    signals::Tag tag;
    std::size_t index = 0;  ///< into command_names
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
