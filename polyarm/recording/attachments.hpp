#pragma once
/// Files that are attached to a recording, so that it can be understood without the cell's folder.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"

namespace polyarm::recording {

struct AttachedFile {
  std::string name;  ///< relative to the cell's folder if the file is inside it
  std::filesystem::path path;
};

/// The files of the cell, sorted by name: all files in the folder of a cell.yaml (except hidden files and
/// recordings), or those that a description was given with. At most 1 MB per file and 10 MB in total. Reads
/// the disk.
std::vector<AttachedFile> files_of(const cell::CellFile& file);

/// "application/xml" for descriptions, "text/plain" for unknown types.
std::string media_type_of(const std::string& name);

}  // namespace polyarm::recording
