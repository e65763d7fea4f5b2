#pragma once
/// xacro: macros for XML, expanded as the reference implementation expands them. docs/xacro.md says what of
/// it is understood.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/packages.hpp"

namespace polyarm::description {

struct XacroOptions {
  std::map<std::string, std::string> arguments;  ///< NAME:=VALUE
  std::map<std::string, std::filesystem::path> packages;
};

/// What an expansion has read and asked for.
struct XacroReport {
  std::vector<std::filesystem::path> files;      ///< the file, its includes and YAML files
  std::map<std::string, std::string> arguments;  ///< every <xacro:arg> with the value that it had
  std::vector<std::string> macros;               ///< that the file itself defines
};

/// The XML that is left when everything of xacro has been done. Throws Error with the place and the chain of
/// includes and macros that led there.
std::string expand_xacro(const std::filesystem::path& file, const XacroOptions& options, Problems& warnings,
                         XacroReport* report = nullptr);
/// The same of a text; `file` says where its relative names begin.
std::string expand_xacro_text(std::string_view text, const std::filesystem::path& file,
                              const XacroOptions& options, Problems& warnings, XacroReport* report = nullptr);

/// Does the XML use xacro?
bool uses_xacro(std::string_view text);

}  // namespace polyarm::description
