#pragma once
/// Keeps the rows of a sweep in an SQLite file, one transaction for each row: a process that is killed loses
/// the variants that were running, and nothing else. One thread. SQLite's own locks are not relied on: a lock
/// file keeps a second writer away.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/sweeps/inputs.hpp"
#include "polyarm/sweeps/row.hpp"

namespace polyarm::sweeps {

class Store {
 public:
  enum class Open {
    write,  ///< makes the file; Error("busy") while another process writes it
    read,   ///< Error("no-results") without the file
  };
  /// Throws Error("unwritable" | "bad-results" | "busy" | "no-results"), which names the file.
  Store(const std::filesystem::path& file, Open how);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// What the rows depend on; empty in a new file.
  Inputs inputs() const;
  void set_inputs(const Inputs& inputs);
  /// Deletes all rows and inputs.
  void clear();

  bool has(const std::string& key) const;
  std::optional<Row> find(const std::string& key) const;
  /// Keeps the row that is there already.
  void add(const Row& row);
  std::uint64_t count() const;
  /// Each row, in the order of keys.
  void each(const std::function<void(const Row&)>& take) const;
  /// Takes over the rows of another file that has the same inputs; those that are here already stay as they
  /// are. Returns how many are new. Throws Error("changed-inputs") if the inputs differ.
  std::uint64_t merge(const std::filesystem::path& other);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::sweeps
