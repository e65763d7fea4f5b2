#pragma once
/// The parameters of a controller manager, by the names and with the defaults of ROS 2.
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"

namespace polyarm::ros_files {

/// A key that is understood and changes nothing here, with the reason.
struct UnusedKey {
  std::string key;
  Location where;
  std::string why;
};

struct ManagerParameters {
  std::string ns;          ///< "/" or "/left"
  double update_rate = 0;  ///< Hz, a whole number; 0: not stated (ROS takes 100)
  bool enforce_command_limits = true;
  std::vector<std::string> unconfigured;  ///< components that stay so at the start
  std::vector<std::string> inactive;      ///< components that are configured and not activated at the start
  std::string
      strictness;  ///< of a switch that states none: best_effort, strict, auto, force_auto; empty: not stated
  bool overruns_print_warnings = true;
  double thread_priority = 0;  ///< 1 to 99; 0: not stated (ROS takes 50 where the kernel is of real time)
  std::vector<double> cpu_affinity;  ///< cores; empty: any
  std::optional<bool> lock_memory;   ///< stated, or not
};

/// Reads the keys of the manager itself, those of its controllers (`NAME.type` …) aside: `is_controller` says
/// whether NAME is one. A wrong type is an error; what is asked for and never done here is a warning that
/// says what is done; a key that nobody knows is a warning with the nearest known one if `is_own` says that
/// it was written for the manager and not for every node.
ManagerParameters read_manager(const controllers::Parameters& parameters,
                               const std::function<bool(const std::string& name)>& is_controller,
                               const std::function<bool(const std::string& key)>& is_own,
                               std::vector<UnusedKey>& unused, Problems& problems);

/// Is `key` one of the manager's own?
bool is_manager_key(std::string_view key);

/// Values as parameter files write them, each wrong one an error with its place and what to write.
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
