#pragma once
/// The data file editor of the console, as described in the thesis: one data file in memory.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/client.hpp"
#include "apps/dialogue.hpp"
#include "polyarm/data/import_format.hpp"

namespace polyarm::apps {

/// Access to the robot for the editor.
struct RobotSource {
  struct Joint {
    std::string name;
    bool slides = false;  ///< prismatic: its value is a length
  };
  std::function<Json()> state;                 ///< state from `jog.state`; throws if no cell runs
  std::function<std::vector<Joint>()> joints;  ///< joints of the cell's robot, or of the selected one
};

/// A point whose frame is a point of the same values, in the outermost frame of the chain; other values are
/// unchanged. Throws Error("frame-cycle").
data::Value outermost(const data::Value& value, const data::DataSet& of);

class ConsoleEditor {
 public:
  ConsoleEditor(Dialogue& talk, RobotSource robot) : talk_(talk), robot_(std::move(robot)) {}

  void set_folder(const std::filesystem::path& folder) { folder_ = folder; }
  void run();

  /// Short summary: the file, and whether it is saved.
  std::string summary() const;
  bool has_unsaved() const { return file_.text() != saved_; }
  /// Asks what to do with unsaved changes; false: stay in the editor.
  bool may_leave();
  /// Without questions: writes unsaved changes beside the file and returns the path.
  std::optional<std::filesystem::path> rescue();

  /// The values in memory.
  const data::DataSet& values() const { return file_.values(); }
  /// A point of a file; for the open file the value in memory. Throws Error with the nearest name.
  data::Value value_of(const std::string& file, const std::string& name);
  /// Asks for a name and stores the value under it, as the thesis describes. Returns the name; empty if the
  /// user cancels.
  std::string keep(const data::Value& value);
  /// The joint state, or the pose, from a state of the robot.
  static data::JointState joints_of(const Json& state);
  static data::Point pose_of(const Json& state);
  /// Asks for each value.
  data::JointState ask_joints();
  data::Point ask_pose();
  /// Data files in the folder.
  std::vector<std::string> files() const;

 private:
  void load();
  void save();
  void save_as();
  void list_files() const;
  void delete_file();
  void import();
  void remove();
  void list_keys() const;
  void edit();
  void open(const std::filesystem::path& path);
  void begin(const std::filesystem::path& path);
  void write(const std::filesystem::path& path);
  std::filesystem::path path_for(const std::string& name) const;
  std::optional<std::filesystem::path> find(const std::string& name) const;
  data::Value ask_value(data::Kind kind, const std::string& question);
  void set(const std::string& name, const data::Value& value);

  Dialogue& talk_;
  RobotSource robot_;
  std::filesystem::path folder_ = ".", path_;  ///< of the open file; empty: none yet
  data::ImportFile file_;
  std::string saved_;  ///< its text on disk, as far as known
};

}  // namespace polyarm::apps
