#pragma once
/// The services of a simulated controller of UFACTORY: commands at one port, reports at three. One thread;
/// nothing here waits.
#include <string>
#include <vector>

#include "drivers/wire/service.hpp"
#include "drivers/xarm/machine.hpp"

namespace polyarm::xarm {

/// What goes wrong on purpose.
struct FarFaults {
  bool silent = false;          ///< no reports
  bool nonsense = false;        ///< the next report is not valid
  bool short_report = false;    ///< the next report has a length that is too small
  bool not_a_number = false;    ///< the next report has a position that is NaN
  bool mute = false;            ///< no answers
  bool bad_answer = false;      ///< the next answer is no frame
  bool other_register = false;  ///< the next answer is one to something else
  bool twice = false;           ///< each answer comes twice
  bool power_off = false;       ///< nothing answers
  int late = 0;                 ///< reports that are kept back, then sent together
  int late_answers = 0;         ///< answers of so many cycles are kept back, then sent together
};

struct FarPorts {
  int command = kCommandPort, normal = kNormalPort, rich = kRichPort, real = kRealPort;  ///< 0: any
};

class FarUx {
 public:
  FarUx(Machine& machine, FarFaults& faults, int real_cycles, int slow_cycles)
      : machine_(machine), faults_(faults), real_cycles_(real_cycles), slow_cycles_(slow_cycles) {}
  /// Throws Error("no-port").
  void listen(const std::string& address, const FarPorts& ports);
  FarPorts ports() const;
  void descriptors(std::vector<int>& out);
  void serve();
  /// One cycle: the machine moves, and reports go out when they are due.
  void cycle();
  void drop_commands() { commands_.drop_all(); }
  void drop_reports();
  void drop_all();

  /// Reports for motion that went out, and the number of the newest one for its client.
  std::uint64_t reports() const { return reports_; }
  std::uint64_t newest() const { return newest_; }
  std::uint64_t requests() const { return requests_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    UxReader reader;
    std::uint64_t reports = 0;
    std::string kept;  ///< what a fault keeps back
  };
  bool take(Client& client, Bytes bytes);
  bool answer(Client& client, const UxFrame& frame);
  bool send(Client& client, std::vector<std::uint8_t> bytes);
  void send_real(Client& client);
  void send_slow(wire::Service<Client>& service, ReportKind kind);
  void send_kept();

  Machine& machine_;
  FarFaults& faults_;
  int real_cycles_, slow_cycles_, since_real_ = 0, since_slow_ = 0;
  wire::Service<Client> commands_, normal_, rich_, real_;
  std::uint64_t reports_ = 0, newest_ = 0, requests_ = 0;
};

}  // namespace polyarm::xarm
