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
/// The catalogue: folders of --catalogue first, then where it is installed.
description::Catalogue open_catalogue();

}  // namespace polyarm::apps
