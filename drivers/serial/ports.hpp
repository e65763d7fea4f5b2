#pragma once
/// Which serial ports a machine has.
#include <filesystem>
#include <string>
#include <vector>

namespace polyarm::serial {

/// Ports that could have a device: names that stay (`serial/by-id/…`) first, then USB adapters and UARTs
/// of boards that have no such name. `dev` is /dev but in tests.
std::vector<std::string> list_ports(const std::filesystem::path& dev = "/dev");

}  // namespace polyarm::serial
