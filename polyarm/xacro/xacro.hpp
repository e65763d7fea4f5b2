#pragma once
/// xacro: macros for XML, expanded as by the reference implementation. docs/xacro.md lists the supported
/// features. Reads the disk.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::description {

struct XacroOptions {
  std::map<std::string, std::string> arguments;  ///< NAME:=VALUE
  std::map<std::string, std::filesystem::path> packages;
};

/// The files and arguments that an expansion used.
struct XacroReport {
  std::vector<std::filesystem::path> files;      ///< the file, its includes and YAML files
  std::map<std::string, std::string> arguments;  ///< every <xacro:arg> with its final value
  std::vector<std::string> macros;               ///< defined by the file itself
};

/// The XML after the expansion. Throws Error with the place and the chain of includes and macros.
std::string expand_xacro(const std::filesystem::path& file, const XacroOptions& options, Problems& warnings,
                         XacroReport* report = nullptr);
/// The same for a text; relative names start from `file`.
std::string expand_xacro_text(std::string_view text, const std::filesystem::path& file,
                              const XacroOptions& options, Problems& warnings, XacroReport* report = nullptr);

/// True if the XML uses xacro.
bool uses_xacro(std::string_view text);

}  // namespace polyarm::description
