#pragma once
/// The parameters of a controller manager, with the names and defaults of ROS 2.
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"

namespace polyarm::ros_files {

/// A known key without effect here, and the reason.
struct UnusedKey {
  std::string key;
  Location where;
  std::string why;
};

struct ManagerParameters {
  std::string ns;          ///< "/" or "/left"
  double update_rate = 0;  ///< Hz, a whole number; 0: not given (ROS uses 100)
  bool enforce_command_limits = true;
  std::vector<std::string> unconfigured;  ///< components that stay unconfigured at the start
  std::vector<std::string> inactive;      ///< components that are configured but not activated at the start
  std::string
      strictness;  ///< of a switch request that gives none: best_effort, strict, auto, force_auto; empty: not
                   ///< given
  bool overruns_print_warnings = true;
  double thread_priority = 0;  ///< 1 to 99; 0: not given (ROS uses 50 on a real-time kernel)
  std::vector<double> cpu_affinity;  ///< cores; empty: any
  std::optional<bool> lock_memory;   ///< empty: not given
};

/// Reads the manager's own keys. Keys of its controllers (`NAME.type` …) are skipped; `is_controller` is true
/// for NAME if it is one. A wrong type is an error. A request for behaviour that Polyarm does not have is a
/// warning that says what it does instead. An unknown key is a warning with the nearest known key, if
/// `is_own` is true: then it was written for the manager, not for every node.
ManagerParameters read_manager(const controllers::Parameters& parameters,
                               const std::function<bool(const std::string& name)>& is_controller,
                               const std::function<bool(const std::string& key)>& is_own,
                               std::vector<UnusedKey>& unused, Problems& problems);

/// True if `key` is one of the manager's own.
bool is_manager_key(std::string_view key);

/// Reads values of parameter files. A wrong value is an error with its location and what to write instead.
class ParameterReader {
 public:
  explicit ParameterReader(Problems& problems) : problems_(problems) {}
  using Entry = controllers::Parameters::Entry;
  void read(const std::string& key, const Entry& entry, bool& out);
  void read(const std::string& key, const Entry& entry, double& out);
  void read(const std::string& key, const Entry& entry, std::string& out);
  void read(const std::string& key, const Entry& entry, std::vector<std::string>& out);
  void read(const std::string& key, const Entry& entry, std::vector<double>& out);
  /// A whole number from `least` to `most`.
  void whole(const std::string& key, const Entry& entry, double least, double most, double& out);

 private:
  bool single(const std::string& key, const Entry& entry, const char* wanted);
  void refuse(const std::string& key, const Entry& entry, const std::string& wanted);
  Problems& problems_;
};

}  // namespace polyarm::ros_files
