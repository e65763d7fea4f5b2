#pragma once
/// ROS 2 domains of tests that run at the same time on one machine.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "polyarm/base/descriptor.hpp"

namespace polyarm::ros2::test {

/// The domain of this process: no other test process of this machine has it until this one ends. Between 20 and 99:
/// the ports of higher domains belong to the system.
inline std::uint32_t own_domain() {
  constexpr std::uint32_t kFirst = 20, kCount = 80;
  static std::uint32_t domain = 0;
  static Descriptor lock;
  if (domain != 0) return domain;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t wanted = kFirst + (static_cast<std::uint32_t>(::getpid()) + i) % kCount;
    const auto file =
        std::filesystem::temp_directory_path() / ("polyarm_test_domain_" + std::to_string(wanted));
    Descriptor held(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    if (!held || ::flock(held.number(), LOCK_EX | LOCK_NB) != 0) continue;
    lock = std::move(held);
    return domain = wanted;
  }
  throw std::runtime_error("all ROS 2 domains for tests are in use");
}

}  // namespace polyarm::ros2::test
