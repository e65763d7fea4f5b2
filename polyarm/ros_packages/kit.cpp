#include "polyarm/ros_packages/kit.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/installation.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ros_packages {

namespace fs = std::filesystem;

namespace {

fs::path find_folder() {
  const auto found = installation::data_folders("ros", "packages.list");
  if (!found.empty()) return found.front();
  throw Error("no-kit", "the headers for packages of ROS are not beside this command",
              "install Polyarm with its development files: cmake --install build --prefix DIR");
}

/// The rows of a list, without comments.
std::vector<std::vector<std::string>> rows(const fs::path& file) {
  std::vector<std::vector<std::string>> out;
  std::istringstream lines(read_file(file, kLargestSource));
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && line[0] != '#') out.push_back(split_words(line));
  return out;
}
}  // namespace

std::string Source::advice() const {
  return debian.empty() ? note : "sudo apt install " + debian;
}

Kit::Kit() : folder_(find_folder()) {
  std::error_code error;
  const bool installed = fs::exists(folder_ / "interfaces.list", error);
  headers_ =
      installed ? folder_.parent_path().parent_path().parent_path() / "include" : folder_.parent_path();
  interfaces_ = read_interface_list(installed ? folder_ / "interfaces.list"
                                              : folder_.parent_path() / "polyarm/messages/interfaces.list");
  for (Interface& more : read_interface_list(folder_ / "more_interfaces.list")) {
    const auto same = std::find_if(interfaces_.begin(), interfaces_.end(), [&](const Interface& i) {
      return i.package == more.package && i.kind == more.kind && i.name == more.name;
    });
    if (same == interfaces_.end())
      interfaces_.push_back(std::move(more));
    else
      *same = std::move(more);
  }
  for (const Interface& each : interfaces_) {
    for (std::string& name : header_names(each)) message_headers_.insert(std::move(name));
    packages_.insert(each.package);
  }
  for (const auto& row : rows(folder_ / "packages.list"))
    if (row.size() >= 2 && row[1] != "system") {
      if ((row[1] == "headers" || row[1] == "tool") && !packages_.contains(row[0])) replaced_.insert(row[0]);
      packages_.insert(row[0]);
    }
  for (const auto& row : rows(folder_ / "sources.list")) {
    if (row.size() < 3) continue;
    Source source;
    if (row[2] == "-")
      source.note = join(std::vector<std::string>(row.begin() + 3, row.end()), " ");
    else
      source.debian = row[2];
    (row[0] == "header" ? header_sources_ : package_sources_)[row[1]] = source;
  }
}

void Kit::require_headers() const {
  std::error_code error;
  if (!fs::exists(headers_ / "polyarm/hardware/component.hpp", error))
    throw Error("no-kit", "Polyarm's headers for plugins are not in " + headers_.string(),
                "sudo apt install polyarm-dev; from source: cmake --install build --prefix DIR");
}

std::string Kit::key() const {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::path& folder : {folder_, headers_ / "polyarm"})
    for (const auto& file : fs::recursive_directory_iterator(folder, error)) {
      const std::string ending = file.path().extension().string();
      if (ending == ".hpp" || ending == ".h" || ending == ".list" ||
          file.path().parent_path().filename() == "wrappers")
        files.push_back(file.path());
    }
  std::sort(files.begin(), files.end());
  std::string all;
  for (const fs::path& file : files)
    all += file.string() + " " + sha256(read_file(file, kLargestSource)) + "\n";
  for (const Interface& each : interfaces_) all += header_code(each);
  return sha256(all);
}

std::set<std::string> Kit::message_packages() const {
  std::set<std::string> out;
  for (const Interface& each : interfaces_) out.insert(each.package);
  return out;
}
bool Kit::has_package(const std::string& name) const {
  return packages_.contains(name);
}
bool Kit::has_interface(const Interface& of) const {
  return std::any_of(interfaces_.begin(), interfaces_.end(), [&](const Interface& i) {
    return i.package == of.package && i.kind == of.kind && i.name == of.name;
  });
}
bool Kit::has_header(const std::string& name) const {
  std::error_code error;
  if (message_headers_.contains(name) || fs::is_regular_file(folder_ / "include" / name, error)) return true;
  // ROS installs a package's headers below its name: "angles/angles/angles.h" is "angles/angles.h", too.
  const auto slash = name.find('/');
  return slash != std::string::npos && name.compare(slash + 1, slash + 1, name, 0, slash + 1) == 0 &&
         has_header(name.substr(slash + 1));
}

const std::set<std::string>& Kit::words(const std::string& package) const {
  const auto [at, made] = words_.try_emplace(package);
  if (!made) return at->second;
  std::error_code error;
  for (const fs::path& folder : {folder_ / "include" / package, folder_ / "include" / "polyarm_ros"})
    for (const auto& file : fs::recursive_directory_iterator(folder, error))
      if (file.is_regular_file(error))
        for (const auto& [word, line] : identifiers(read_file(file.path(), kLargestSource)))
          at->second.insert(word);
  return at->second;
}

namespace {
/// The longest key that `name` begins with.
std::optional<Source> longest(const std::map<std::string, Source>& all, const std::string& name) {
  std::optional<Source> out;
  std::size_t best = 0;
  for (const auto& [key, source] : all)
    if (name.starts_with(key) && key.size() > best) best = key.size(), out = source;
  return out;
}
}  // namespace

std::optional<Source> Kit::source_of_header(const std::string& name) const {
  return longest(header_sources_, name);
}
std::optional<Source> Kit::source_of_package(const std::string& name) const {
  const auto found = package_sources_.find(name);
  if (found == package_sources_.end()) return std::nullopt;
  return found->second;
}

std::map<std::string, int> identifiers(const std::string& code) {
  std::map<std::string, int> out;
  int line = 1;
  const auto skip_to = [&](std::size_t& i, const char* end) {
    const auto found = std::min(code.find(end, i), code.size());
    for (; i < found; ++i) line += code[i] == '\n';
  };
  for (std::size_t i = 0; i < code.size();) {
    const char c = code[i];
    if (c == '\n') ++line;
    if (code.compare(i, 2, "//") == 0) {
      skip_to(i, "\n");
    } else if (code.compare(i, 2, "/*") == 0) {
      skip_to(i, "*/");
    } else if (c == '"') {
      for (++i; i < code.size() && code[i] != '"' && code[i] != '\n'; ++i)
        if (code[i] == '\\') ++i;
      ++i;
    } else if (std::isalpha(static_cast<unsigned char>(c)) || c == '_') {
      const std::size_t begin = i;
      while (i < code.size() && (std::isalnum(static_cast<unsigned char>(code[i])) || code[i] == '_')) ++i;
      out.try_emplace(code.substr(begin, i - begin), line);
    } else {
      ++i;
    }
  }
  return out;
}

}  // namespace polyarm::ros_packages
