#pragma once
/// The table of all named numbers that hardware and controllers exchange.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace polyarm::hardware {

/// One contiguous array of doubles for states, one for commands, and a full name per entry. Names become
/// indices when a controller is configured; a cycle uses indices only. Names and look-up: cell thread;
/// values: control thread only. After seal() the arrays keep their size and address; later entries use
/// reserved ones, so the control thread is not affected.
class InterfaceTable {
 public:
  /// Number of entries of each kind that seal() reserves.
  static constexpr std::size_t kSpare = 64;

  /// Adds an entry and returns its index. Throws Error("duplicate-interface") if the name exists,
  /// Error("table-full") if the table is sealed and no entry is free. After seal(), `initial` is not written.
  std::size_t add_state(std::string name, double initial);
  std::size_t add_command(std::string name);
  /// Frees entries; their values stay until the entries are used again. Only after seal().
  void remove_state(std::string_view name);
  void remove_command(std::string_view name);
  /// Fixes the size of the arrays.
  void seal();
  bool sealed() const noexcept { return sealed_; }

  std::optional<std::size_t> find_state(std::string_view name) const;
  std::optional<std::size_t> find_command(std::string_view name) const;
  /// By index; free entries have an empty name.
  const std::vector<std::string>& state_names() const { return state_.names; }
  const std::vector<std::string>& command_names() const { return command_.names; }

  std::span<double> states() noexcept { return state_.values; }
  std::span<const double> states() const noexcept { return state_.values; }
  std::span<double> commands() noexcept { return command_.values; }
  std::span<const double> commands() const noexcept { return command_.values; }
  /// Number of entries when the table was sealed; before that, of all entries.
  std::size_t built_states() const noexcept { return state_.built; }
  std::size_t built_commands() const noexcept { return command_.built; }
  /// Entries from these indices on were never used: they are NaN. Any thread.
  std::size_t live_states() const noexcept { return state_.live.load(std::memory_order_relaxed); }
  std::size_t live_commands() const noexcept { return command_.live.load(std::memory_order_relaxed); }
  /// Number of changes of the names.
  std::uint64_t changes() const noexcept { return changes_; }

 private:
  struct Hash {  // transparent hash: a look-up creates no string
    using is_transparent = void;
    std::size_t operator()(std::string_view name) const noexcept {
      return std::hash<std::string_view>{}(name);
    }
  };
  struct Side {
    std::vector<double> values;
    std::vector<std::string> names;
    std::unordered_map<std::string, std::size_t, Hash, std::equal_to<>> index;
    std::vector<std::size_t> free;
    std::size_t built = 0;
    std::atomic<std::size_t> live{0};
  };
  static std::optional<std::size_t> find(const Side& side, std::string_view name);
  std::size_t add(Side& side, std::string name, double initial, const char* kind);
  void remove(Side& side, std::string_view name);
  void seal(Side& side);

  Side state_, command_;
  bool sealed_ = false;
  std::uint64_t changes_ = 0;
};

}  // namespace polyarm::hardware
