#pragma once
/// Our texts for a KUKA controller: the context and the Ethernet configuration of RSI, and the KRL programs
/// with their configuration of EthernetKRL.
#include <string>
#include <vector>

namespace polyarm::kuka {

struct KrlSettings {
  std::string own_address = "172.31.1.148";  ///< of the computer with the driver, in the network of RSI
  int rsi_port = 59152, eki_port = 54600;
  int rsi = 5;              ///< version of RSI: 3, 4 or 5
  int cycle_ms = 4;         ///< 4 or 12
  int late_limit = 25;      ///< late answers in a row, until RSI ends
  double correction = 360;  ///< degrees of each axis away from where RSI began
  bool relative = false;
};

struct KrlFile {
  std::string folder, name, text;  ///< folder: where it belongs at the controller
};
/// All files, and a text that says what to do with them. Lines end as Windows has it.
std::vector<KrlFile> krl_files(const KrlSettings& settings);

}  // namespace polyarm::kuka
