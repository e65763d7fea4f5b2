#pragma once
/// What the catalogue's files say about each robot in one line, kept from one run to the next, so that finding
/// a robot does not read every file. A file that has another size or time than the index knows is read again.
/// One thread.
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "polyarm/description/catalogue.hpp"

namespace polyarm::description {

class CatalogueIndex {
 public:
  /// The index kept in `file`; empty where there is none, where it is damaged, or where another build of
  /// Polyarm made it.
  explicit CatalogueIndex(std::filesystem::path file);

  /// Nothing: the robot file is not known as it is now.
  std::optional<CatalogueEntry> find(const std::filesystem::path& robot);
  void add(const CatalogueEntry& entry);
  /// Writes it with what was found or added since it was opened, if anything was added. A disk that cannot be
  /// written is no error.
  void save() const;

 private:
  std::filesystem::path file_;
  std::map<std::string, std::string> lines_, used_;  ///< by path: its line; what save() writes
  bool added_ = false;
};

/// `catalogue` in the cache folder of this user; empty without a home.
std::filesystem::path catalogue_index_file();

}  // namespace polyarm::description
