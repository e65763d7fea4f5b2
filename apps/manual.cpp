#include "apps/manual.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "apps/verb.hpp"

namespace polyarm::apps {

namespace {
using Entry = std::pair<const char*, const char*>;

constexpr Entry kEnvironment[] = {
    {"POLYARM_ROBOTS", "folders of robots, separated by colons, searched before the catalogue"},
    {"POLYARM_DRIVERS", "folders of drivers, searched before the installed ones"},
    {"POLYARM_PLUGINS", "folders of plugins, searched before the installed ones"},
    {"POLYARM_PACKAGES", "folders in which descriptions find ROS packages"},
    {"XDG_DATA_HOME",
     "the user's cells, certificates, users and audit log are in polyarm/ below it (default: "
     "~/.local/share)"},
    {"XDG_CONFIG_HOME", "the user's robots and settings are in polyarm/ below it (default: ~/.config)"},
};

constexpr Entry kFiles[] = {
    {"~/.local/share/polyarm/cells", "the user's cells, and copies of examples"},
    {"../share/polyarm/robots", "the catalogue of robots, as seen from the command"},
    {"../share/polyarm/examples", "cells to run by name"},
    {"../lib/polyarm", "drivers, helper programs and plugins"},
};

constexpr Entry kExits[] = {
    {"0", "done"},
    {"1", "the run, the check or the solve failed"},
    {"2", "the command line is wrong"},
    {"3", "stopped by a person"},
};

/// Text in which nothing is an instruction for the formatter.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (out.empty() && (c == '.' || c == '\''))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

template <class Entries>
std::string section(const char* title, const Entries& entries) {
  std::string out = fmt::format(".SH {}\n", title);
  for (const auto& [name, meaning] : entries)
    out += fmt::format(".TP\n.B {}\n{}\n", plain(name), plain(meaning));
  return out;
}
}  // namespace

std::string manual_page() {
  std::string out = fmt::format(
      ".TH POLYARM 1 \"\" \"polyarm {}\" \"User Commands\"\n"
      ".SH NAME\npolyarm \\- one runtime for every robot arm\n"
      ".SH SYNOPSIS\n.B polyarm\n.I VERB\n.RI [ OPTIONS ]\n"
      ".SH DESCRIPTION\nPolyarm simulates, teaches, scripts and runs robot arms. A cell is a folder with a\n"
      ".I cell.yaml\nthat names robots, scene, signals and program.\n.PP\n"
      ".B polyarm VERB \\-\\-help\nlists the options of a verb, with examples.\n"
      ".SH VERBS\n",
      POLYARM_VERSION);
  for (const Verb& verb : verbs())
    out += fmt::format(".TP\n.B {}\n{}\n", plain(verb.name), plain(verb.summary));
  out +=
      ".SH OPTIONS\nThis option works with every verb.\n.TP\n.BI \\-\\-allow \" "
      "PATH|host:NAME|secret:NAME\"\n"
      "let a cell reach this file, host or secret beyond its own folder; may be repeated\n";
  out += section("EXIT STATUS", kExits);
  out += section("ENVIRONMENT", kEnvironment);
  out += section("FILES", kFiles);
  out +=
      ".SH EXAMPLES\n.nf\npolyarm run pick_and_place\npolyarm run pick_and_place \\-\\-fast \\-\\-seconds 5\n"
      "polyarm ik universal_robots/ur5e \\-\\-xyz 0.4 0 0.3 \\-\\-rpy 3.1416 0 0\n.fi\n"
      ".SH SAFETY\nThe stop key of the pendant is not an emergency stop.\n";
  return out;
}

}  // namespace polyarm::apps
