#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "apps/verb.hpp"
#include "polyarm/description/catalogue.hpp"

namespace polyarm::apps {

/// Parses; on --help or a wrong line it prints and returns the exit code to end with.
std::optional<int> parse(CLI::App& app, int argc, char** argv);
/// Text below the options in --help.
std::string examples(std::initializer_list<const char*> lines);
/// What --hardware takes: declared, a driver of Polyarm, or VENDOR/TYPE.
CLI::Validator hardware_name();
/// --plugins DIR, which may be repeated; load_plugins() takes the folders up before any other.
void add_plugin_option(CLI::App& app, std::vector<std::string>& folders);
void load_plugins(const std::vector<std::string>& folders);
/// The catalogue: folders of --catalogue first, then where it is installed.
description::Catalogue open_catalogue();

}  // namespace polyarm::apps
