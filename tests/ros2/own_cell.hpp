#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/support/command.hpp"

namespace polyarm::ros2::test {

/// A cell of its own folder, in a domain of its own.
class OwnCell {
 public:
  using Files = std::vector<std::pair<std::string, std::string>>;  ///< names and texts
  explicit OwnCell(const Files& files, std::vector<std::string> more = {}) {
    std::filesystem::create_directories(folder_);
    for (const auto& [name, text] : files) std::ofstream(folder_ / name) << text;
    ::setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
    more.insert(more.begin(), {"run", folder_.string(), "--ros2", "--no-socket"});
    command_.emplace(more);
    EXPECT_TRUE(command_->wait_for("ROS 2: domain")) << command_->wait().output;
    client.emplace(domain);
  }
  ~OwnCell() {
    client.reset();
    command_.reset();
    std::filesystem::remove_all(folder_);
  }
  json call(const std::string& service, const std::string& type, const json& request = json::object()) {
    return client->call(service, type, request);
  }

  const std::uint32_t domain = test::own_domain();
  std::optional<Client> client;

 private:
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("polyarm_ros2_own_" + std::to_string(::getpid()));
  std::optional<polyarm::test::Command> command_;
};

}  // namespace polyarm::ros2::test
