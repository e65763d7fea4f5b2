#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "apps/new_cell.hpp"
#include "apps/options.hpp"
#include "apps/templates.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

/// Replacements for the placeholders of the templates.
struct Names {
  std::string kind, name, type, vendor;
};

bool is_snake(const std::string& word) {
  const auto fits = [](char c) {
    return std::islower(static_cast<unsigned char>(c)) || std::isdigit(static_cast<unsigned char>(c)) ||
           c == '_';
  };
  return !word.empty() && std::islower(static_cast<unsigned char>(word.front())) && word.back() != '_' &&
         word.find("__") == std::string::npos && std::all_of(word.begin(), word.end(), fits);
}

/// "MyArm" → "my_arm"; snake_case stays unchanged.
std::string snake(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (std::isupper(c) && i > 0 && name[i - 1] != '_' &&
        !std::isupper(static_cast<unsigned char>(name[i - 1])))
      out += '_';
    out += static_cast<char>(std::tolower(c));
  }
  return out;
}

/// "my_arm" → "MyArm"
std::string camel(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i)
    if (name[i] != '_')
      out += i == 0 || name[i - 1] == '_'
                 ? static_cast<char>(std::toupper(static_cast<unsigned char>(name[i])))
                 : name[i];
  return out;
}

Names names_of(const std::string& kind, const std::string& given, const std::string& vendor) {
  Names out{kind, snake(given), camel(snake(given)), vendor.empty() ? snake(given) : vendor};
  // CMake reserves these target names.
  static const std::vector<std::string> kTaken = {"all", "clean", "help", "install", "package", "test"};
  if (!is_snake(out.name) || std::find(kTaken.begin(), kTaken.end(), out.name) != kTaken.end())
    throw Error("bad-name", "'" + given + "' cannot be the name",
                "use small letters, digits and '_', beginning with a letter: my_arm");
  if (!is_snake(out.vendor))
    throw Error("bad-name", "'" + vendor + "' cannot be the vendor",
                "use small letters, digits and '_', beginning with a letter: acme");
  return out;
}

/// Replaces the placeholders in one pass, so a name may contain one of them.
std::string filled(const std::string& text, const Names& names) {
  const std::pair<std::string, const std::string&> words[] = {
      {"my_device", names.name}, {"MyDevice", names.type}, {"my_vendor", names.vendor}};
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto found = std::find_if(std::begin(words), std::end(words), [&](const auto& word) {
      return text.compare(at, word.first.size(), word.first) == 0;
    });
    if (found == std::end(words)) {
      out += text[at++];
    } else {
      out += found->second;
      at += found->first.size();
    }
  }
  return out;
}

void write(const fs::path& folder, const Names& names) {
  std::error_code error;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    throw Error("exists", folder.string() + " exists already, nothing was written",
                "choose another folder with --folder DIR, or another name");
  fs::create_directories(folder, error);
  if (error) throw Error("unwritable", folder.string() + " cannot be created: " + error.message());
  for (const TemplateFile& file : template_files())
    if (names.kind == file.kind)
      write_file_atomically(folder / filled(file.name, names), filled(file.text, names));
}

/// CMake option that finds this Polyarm: its build folder, or its installation.
std::string find_option() {
  std::error_code error;
  const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  return fs::exists(here / "polyarmConfig.cmake", error)
             ? "-Dpolyarm_DIR=" + here.string()
             : "-DCMAKE_PREFIX_PATH=" + here.parent_path().string();
}

/// Approves the build folder that the generated cell names, because the author runs the plugin from it.
void approve_builds(const fs::path& build) {
  const std::string folder = resolved(build).string();
  try {
    if (unfit_for_development(folder).empty()) approve({"folder", folder, {}});
  } catch (const Error& e) {  // without a settings folder the user is asked at run time
    fmt::print(stderr, "{}\n", e.what());
  }
}

}  // namespace

namespace {
/// Asks the user at a terminal; otherwise returns `usual`.
std::string robot_asked(const std::string& usual) {
  if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDOUT_FILENO) == 0) return usual;
  fmt::print("Which robot? A name of `polyarm robots`, or the path of a URDF [{}]: ", usual);
  std::fflush(stdout);
  std::string line;
  std::getline(std::cin, line);
  const std::string said(trim(line));
  return said.empty() ? usual : said;
}
}  // namespace

int run_new(int argc, char** argv) {
  CommandLine app(
      "Writes a starting point: a cell that runs, or hardware or a controller of your own that compiles, "
      "with its test",
      "polyarm new");
  std::string kind, name, vendor, folder, robot;
  app.add_option("kind", kind, "cell, hardware or controller")
      ->required()
      ->one_of({"cell", "hardware", "controller"});
  app.add_option("name", name, "its name: my_cell; my_arm, which makes the type MyArm")->required();
  app.add_option("--robot", robot, "of a cell: universal_robots/ur5e, or the path of a description");
  app.add_option("--vendor", vendor,
                 "of hardware or a controller: the first part of its full name, VENDOR/TYPE; default: NAME");
  app.add_option("--folder", folder, "the folder to create; default: ./NAME");
  app.footer(examples({"polyarm new cell my_cell --robot fanuc/lr_mate_200id",
                       "polyarm new hardware my_arm --vendor acme",
                       "polyarm new controller follow_me --folder ~/follow_me"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (kind == "cell") {
    if (name.empty() || name.find('/') != std::string::npos || name.front() == '.' || name.front() == '-' ||
        printable_line(name) != name)
      throw Error("bad-name", "'" + printable_line(name) + "' cannot be the name of a cell",
                  "use a word such as my_cell; --folder DIR sets the folder");
    return write_new_cell({name, robot.empty() ? robot_asked("universal_robots/ur5e") : robot,
                           folder.empty() ? fs::path(name) : fs::path(folder)});
  }
  if (!robot.empty())
    throw Error("bad-value", "--robot is for a cell", "polyarm new cell NAME --robot ROBOT");
  const Names names = names_of(kind, name, vendor);
  const fs::path where = folder.empty() ? fs::path(names.name) : fs::path(folder);
  write(where, names);
  approve_builds(where / "build");
  fmt::print(
      "{} {}/{} is in {}; next:\n  cd {}\n  cmake -S . -B build {}\n  cmake --build build\n"
      "  ctest --test-dir build --output-on-failure\n  polyarm run .\n"
      "What you build into {} may run on this machine (polyarm plugins revoke takes that back).\n",
      kind, names.vendor, names.type, where.string(), where.string(), find_option(),
      (where / "build").string());
  return kOk;
}

}  // namespace polyarm::apps
