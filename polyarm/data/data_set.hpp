#pragma once
/// The names and values of one data file, in the order of the file. Unsynchronised: one thread at a time.
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::data {

struct Entry {
  std::string name;
  Value value;
  Location where;     ///< the line of its value
  std::string group;  ///< set by the user, for lists; programs ignore it
};

class DataSet {
 public:
  /// Appends the name, or changes the value of an existing one in place.
  void set(const std::string& name, Value value, Location where = {});
  /// Puts a name of the set into a group; an empty text removes it from its group. Does nothing if the set
  /// does not have the name.
  void set_group(const std::string& name, std::string group);
  const Entry* find(const std::string& name) const;
  const Value* value(const std::string& name) const;
  const std::vector<Entry>& entries() const { return entries_; }
  std::vector<std::string> names() const;
  bool empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }

  /// Equal if names, order, values and groups are equal; locations do not count.
  friend bool operator==(const DataSet& a, const DataSet& b);

 private:
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::size_t> index_;
};

/// The script and the file of points that a data set names. A data set that names a script starts a program.
struct ScriptInformation {
  std::string script_file;
  std::optional<std::string> point_file;
};

/// The texts ScriptFile and PointFile of `set`; empty if it has no ScriptFile.
std::optional<ScriptInformation> script_information(const DataSet& set);

}  // namespace polyarm::data
