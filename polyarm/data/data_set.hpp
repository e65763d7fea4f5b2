#pragma once
/// The names of one data file with their values, in the order of the file.
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
  std::string group;  ///< that a person has put it into, for lists; means nothing to programs
};

class DataSet {
 public:
  /// Adds the name at the end, or changes its value where it stands.
  void set(const std::string& name, Value value, Location where = {});
  /// Puts a name of the set into a group; an empty text: into none. Nothing where the set has no such name.
  void set_group(const std::string& name, std::string group);
  const Entry* find(const std::string& name) const;
  const Value* value(const std::string& name) const;
  const std::vector<Entry>& entries() const { return entries_; }
  std::vector<std::string> names() const;
  bool empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }

  /// The same names in the same order with the same values and groups, wherever they stand.
  friend bool operator==(const DataSet& a, const DataSet& b);

 private:
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::size_t> index_;
};

/// A data set that starts a program names its script, and the file of its points if it has one.
struct ScriptInformation {
  std::string script_file;
  std::optional<std::string> point_file;
};

/// The texts ScriptFile and PointFile of `set`; nothing where it has no ScriptFile.
std::optional<ScriptInformation> script_information(const DataSet& set);

}  // namespace polyarm::data
