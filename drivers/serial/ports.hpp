#pragma once
/// Lists the serial ports of a machine. Reads the disk.
#include <filesystem>
#include <string>
#include <vector>

namespace polyarm::serial {

/// Ports that may have a device: permanent names (`serial/by-id/…`) first, then USB adapters and UARTs
/// without such a name. `dev` is /dev except in tests.
std::vector<std::string> list_ports(const std::filesystem::path& dev = "/dev");

}  // namespace polyarm::serial
