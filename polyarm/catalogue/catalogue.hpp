#pragma once
/// The robots that come with Polyarm: one data file for each, `robots/<maker>/<model>.yaml`, facts only.
/// Reads the disk: not for the control cycle. SI units.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

struct CatalogueEntry {
  std::string name;   ///< "maker/model"
  std::string maker;  ///< as written by the maker: "Universal Robots"
  std::string model;
  int axes = 0;
  std::optional<double> reach_m, payload_kg;
  std::optional<double> mass_kg;  ///< of all links
  bool mass_estimated = false;    ///< the mass of at least one link is an estimate
  std::filesystem::path file;
};

class Catalogue {
 public:
  /// If several folders have a robot of the same name, the earlier folder has priority. Missing folders are
  /// ignored.
  explicit Catalogue(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  /// All robots, by name. Reads the files that are not in the user's index (catalogue_index.hpp). Throws
  /// Error for an unreadable file.
  std::vector<CatalogueEntry> entries() const;
  std::vector<std::string> names() const;
  /// The file of the robot `maker/model`, or of `model` alone if that is unique. Reads no file. For a
  /// complete name it only checks for that file.
  std::optional<std::filesystem::path> find(const std::string& name) const;
  /// The robot `maker/model`, or `model` alone if that is unique. Throws Error("unknown-robot") with similar
  /// names.
  RobotModel load(const std::string& name) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

/// POLYARM_ROBOTS (folders separated by ':'), then `robots/` beside or above the executable, then
/// `../share/polyarm/robots`.
std::vector<std::filesystem::path> default_catalogue_folders();

/// Reads a robot file (`polyarm: robot/1`). Throws Error with all its faults.
RobotModel read_robot_file(const std::filesystem::path& path);

/// Reads `<name>.srdf` beside a description into the model, if it exists. Faulty parts are skipped and added
/// to `warnings`.
void add_srdf_beside(const std::filesystem::path& description, RobotModel& model, Problems& warnings);

/// A catalogue name, or the path of a robot file or URDF (with the SRDF beside it, if there is one).
RobotModel load_robot(const std::string& name_or_path, const Catalogue& catalogue, Problems& warnings,
                      const std::map<std::string, std::string>& arguments = {});

}  // namespace polyarm::description
