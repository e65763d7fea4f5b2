#pragma once
/// What goes into a recording beside its messages, so that it can be understood on its own.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"

namespace polyarm::recording {

struct AttachedFile {
  std::string name;  ///< relative to the cell's folder where it lies in it
  std::filesystem::path path;
};

/// The files that the cell is made of, in the order of their names: all that lie in the folder of a cell.yaml
/// (but for hidden ones and recordings), or those that a description was given with. At most 1 MB each and 10
/// MB in all. Reads the disk.
std::vector<AttachedFile> files_of(const cell::CellFile& file);

/// "application/xml" of a description, "text/plain" of what is not known.
std::string media_type_of(const std::string& name);

}  // namespace polyarm::recording
