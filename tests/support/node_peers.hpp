#pragma once
/// Readers and clients of other projects from npm, in tests/recording/peers.
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/wait.h>

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace polyarm::test {

struct Shell {
  int code = -1;
  std::string output;
};

inline Shell shell(const std::string& command) {
  Shell out;
  std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return out;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    out.output.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  out.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return out;
}

/// Installs the packages and returns their folder; empty, with the reason in `why`, if that is not possible.
inline std::filesystem::path peers(std::string& why) {
  const std::filesystem::path source = std::filesystem::path(POLYARM_SOURCE_DIR) / "tests/recording/peers";
  const std::filesystem::path made =
      std::filesystem::path(POLYARM_COMMAND).parent_path() / "recording_peers";  // in the build folder
  if (shell("node --version").code != 0 || shell("npm --version").code != 0) {
    why = "Node.js or npm is missing: readers of others are not asked";
    return {};
  }
  std::error_code error;
  std::filesystem::create_directories(made, error);
  for (const auto& entry : std::filesystem::directory_iterator(source))
    if (entry.is_regular_file())
      std::filesystem::copy_file(entry.path(), made / entry.path().filename(),
                                 std::filesystem::copy_options::overwrite_existing, error);
  // Several test programs may install at the same time: the lock lets one do it.
  const Shell got = shell("cd '" + made.string() +
                          "' && flock .lock sh -c 'test -f node_modules/.package-lock.json || "
                          "timeout 300 npm ci --no-audit --no-fund'");
  if (got.code != 0) {
    why = "npm gets no packages here: readers of others are not asked\n" + got.output;
    return {};
  }
  return made;
}

inline nlohmann::json node(const std::filesystem::path& folder, const std::string& arguments) {
  const Shell said = shell("cd '" + folder.string() + "' && node " + arguments);
  const nlohmann::json out = nlohmann::json::parse(said.output, nullptr, false);
  EXPECT_EQ(said.code, 0) << said.output;
  EXPECT_FALSE(out.is_discarded()) << said.output;
  return out;
}

}  // namespace polyarm::test
