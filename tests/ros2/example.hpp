#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/support/command.hpp"

namespace polyarm::ros2::test {

/// A copy of an example (or the cell at an absolute path), running in a ROS 2 domain of its own.
class Example {
 public:
  Example(const std::string& name, std::vector<std::string> more = {}) {
    ::setenv("ROS_DOMAIN_ID", std::to_string(domain_).c_str(), 1);
    if (!name.starts_with('/')) copy_.emplace(name);
    const std::string path = copy_ ? copy_->path() : name;
    more.insert(more.begin(), {"run", path, "--ros2", "--no-socket"});
    command_.emplace(more);
    EXPECT_TRUE(command_->wait_for("ROS 2: domain")) << command_->wait().output;
    client.emplace(domain_);
  }

  std::uint32_t domain() const { return domain_; }

 private:
  const std::uint32_t domain_ = test::own_domain();
  std::optional<polyarm::test::ExampleCopy> copy_;
  std::optional<polyarm::test::Command> command_;

 public:
  std::optional<Client> client;
};

}  // namespace polyarm::ros2::test
