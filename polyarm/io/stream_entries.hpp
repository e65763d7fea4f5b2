#pragma once
/// The streams of a cell file: lines of text to and from cameras, scanners and scales.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

struct StreamEntry {
  enum class Kind { connect, listen, device } kind = Kind::connect;
  std::string name;
  std::string host = "127.0.0.1";  ///< an address
  int port = 0;
  std::string device;
  int baud = 9600;
  std::string ends_with = "\n";  ///< what ends a line
  Location where;
};

/// `streams: {scanner: {connect: "192.168.1.5:2000"}}`.
std::vector<StreamEntry> read_streams(const Yaml& yaml, Problems& problems);

}  // namespace polyarm::cell
