#include "apps/reach.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <vector>

#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_reach.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/secrets.hpp"

namespace polyarm::apps {

namespace fs = std::filesystem;

namespace {
std::vector<std::string>& kept() {
  static std::vector<std::string> all;
  return all;
}

void allow(const std::string& what) {
  constexpr const char* kForms = "--allow PATH, --allow host:NAME or --allow secret:NAME";
  const bool host = what.starts_with("host:"), secret = what.starts_with(kSecretPrefix);
  if (what.empty() || what == "host:" || what == kSecretPrefix)
    throw Error("bad-value", "--allow " + what + ": a name is missing", kForms);
  kept().push_back(host || secret ? what : fs::absolute(what).string());
  if (host) return reach().allow_host(what.substr(5));
  if (secret) return reach().allow_secret(what.substr(kSecretPrefix.size()));
  std::error_code error;
  const auto colon = what.find(':');
  const bool other = colon != std::string::npos && what.find('/') > colon && !fs::exists(what, error);
  if (other || (!fs::exists(what, error) && !fs::exists(fs::absolute(what, error).parent_path(), error)))
    throw Error("bad-value", "--allow " + what + ": there is no such file or folder", kForms);
  reach().allow(what);
}

void readable_from(const char* variable, const char* below) {
  if (const char* value = std::getenv(variable))
    for (const std::string& folder : split_words(value, ":")) reach().allow_reading(fs::path(folder) / below);
}

/// Allows a word, or the value of NAME:=VALUE and --name=VALUE.
void allow_named(const std::string& word) {
  const auto equals = word.find('=');
  if (equals != std::string::npos) allow_named(word.substr(equals + 1));
  if (!word.empty() && !word.starts_with('-')) reach().allow(word);
}
}  // namespace

void take_reach_options(int& argc, char** argv) {
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") {
      while (i < argc) argv[kept++] = argv[i++];
      break;
    }
    if (word == "--allow" && i + 1 < argc)
      allow(argv[++i]);
    else if (word.starts_with("--allow="))
      allow(word.substr(8));
    else
      argv[kept++] = argv[i];
  }
  argc = kept;
  argv[argc] = nullptr;
  for (int i = 2; i < argc; ++i) allow_named(argv[i]);
  for (const fs::path& folder : description::default_catalogue_folders()) reach().allow_reading(folder);
  readable_from("POLYARM_PACKAGES", "");
  readable_from("ROS_PACKAGE_PATH", "");
  readable_from("AMENT_PREFIX_PATH", "share");
  reach().confine();
}

const std::vector<std::string>& allowed_by_options() {
  return kept();
}

bool can_ask() {
  return ::isatty(STDIN_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0;
}

bool ask(const std::string& question) {
  fmt::print(stderr, "{} Type yes or no: ", question);
  std::fflush(stderr);
  std::string answer;
  std::getline(std::cin, answer);
  return trim(answer) == "yes";
}

void ask_for_access(const cell::CellFile& file) {
  const std::vector<cell::Wanted> wanted = cell::required_by(file);
  bool any = false;
  for (const cell::Wanted& each : wanted) any = any || !each.allowed;
  if (!any || !can_ask()) return;
  fmt::print(stderr, "The cell {} accesses resources outside its folder:\n", file.path.string());
  for (const cell::Wanted& each : wanted) {
    fmt::print(stderr, "  {:<8}{}  ({}){}\n", each.kind, printable_line(each.what), printable_line(each.why),
               each.allowed && each.kind != "device" ? "  allowed" : "");
    if (!each.sha256.empty() && !each.allowed)
      fmt::print(stderr, "          native code, which would run with all your rights; sha256 {}\n", each.sha256);
  }
  if (!ask("Allow this, and remember it for this cell?")) return;
  for (const cell::Wanted& each : wanted)
    if (!each.allowed) cell::allow_and_remember(file, each);
}

}  // namespace polyarm::apps
