#pragma once
/// The robots that come with Polyarm: one data file for each, `robots/<maker>/<model>.yaml`, facts only.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

struct CatalogueEntry {
  std::string name;   ///< "maker/model"
  std::string maker;  ///< as it is spelled: "Universal Robots"
  std::string model;
  int axes = 0;
  std::optional<double> reach_m, payload_kg;
  std::optional<double> mass_kg;  ///< of all links together
  bool mass_estimated = false;    ///< that of some link at least is an estimate
  std::filesystem::path file;
};

class Catalogue {
 public:
  /// Robots of earlier folders hide those of the same name in later ones. Folders that do not exist are
  /// passed over.
  explicit Catalogue(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  /// Every robot, by name. Reads files that the index of this user does not know (catalogue_index.hpp); throws
  /// Error for one that cannot be read.
  std::vector<CatalogueEntry> entries() const;
  std::vector<std::string> names() const;
  /// The file of the robot called `maker/model`, or `model` alone where that is clear; no file is read, and
  /// of a whole name only its own is looked for.
  std::optional<std::filesystem::path> find(const std::string& name) const;
  /// The robot called `maker/model`, or `model` alone where that is clear. Throws Error("unknown-robot") with
  /// near names.
  RobotModel load(const std::string& name) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

/// POLYARM_ROBOTS (folders separated by ':'), then `robots/` beside or above the executable, then
/// `../share/polyarm/robots`.
std::vector<std::filesystem::path> default_catalogue_folders();

/// Reads one robot file of ours (`polyarm: robot/1`). Throws Error with everything wrong in it.
RobotModel read_robot_file(const std::filesystem::path& path);

/// Reads `<name>.srdf` beside a description into the model, where there is one. What is wrong in it is left
/// out and added to `warnings`.
void add_srdf_beside(const std::filesystem::path& description, RobotModel& model, Problems& warnings);

/// A catalogue name, or the path of a URDF (with an SRDF beside it, where there is one) or robot file.
RobotModel load_robot(const std::string& name_or_path, const Catalogue& catalogue, Problems& warnings,
                      const std::map<std::string, std::string>& arguments = {});

}  // namespace polyarm::description
