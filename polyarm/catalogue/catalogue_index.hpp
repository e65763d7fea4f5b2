#pragma once
/// A persistent index with one line for each robot of the catalogue, so that finding a robot does not read
/// every file. A file with another size or time than in the index is read again. One thread.
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::description {

class CatalogueIndex {
 public:
  /// Reads the index in `file`; empty if it does not exist, is damaged, or was made by another build of
  /// Polyarm.
  explicit CatalogueIndex(std::filesystem::path file);

  /// Empty if the index does not have this version of the robot file.
  std::optional<CatalogueEntry> find(const std::filesystem::path& robot);
  void add(const CatalogueEntry& entry);
  /// Writes the entries that were found or added since construction, if any were added. An unwritable disk is
  /// not an error.
  void save() const;

 private:
  std::filesystem::path file_;
  std::map<std::string, std::string> lines_, used_;  ///< by path: all lines of the index; the lines that
                                                     ///< save() writes
  bool added_ = false;
};

/// `catalogue` in the user's cache folder; empty without a home folder.
std::filesystem::path catalogue_index_file();

}  // namespace polyarm::description
