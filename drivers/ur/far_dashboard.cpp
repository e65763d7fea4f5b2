#include <fmt/format.h>

#include "drivers/ur/far_services.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

void FarDashboard::serve() {
  service_.serve(
      [](Client& client) {
        client.gone |=
            !wire::send_frame(client.socket.number(), "Connected: Universal Robots Dashboard Server\n");
      },
      [this](Client& client, Bytes bytes) {
        client.text.append(bytes.begin(), bytes.end());
        if (client.text.size() > 4096) return false;
        for (std::size_t end; (end = client.text.find('\n')) != std::string::npos;) {
          const std::string line(trim(client.text.substr(0, end)));
          client.text.erase(0, end + 1);
          if (!wire::send_frame(client.socket.number(), answer(line) + "\n")) return false;
          if (line == "quit") return false;
        }
        return true;
      });
}

std::string FarDashboard::answer(const std::string& line) {
  const bool plays = machine_.program() == Machine::Program::playing;
  const std::string refused = "Command is not allowed: the robot is not in remote control";
  const auto remote = [&](const auto& act) { return machine_.remote() ? act() : refused; };
  const MachineOptions& o = machine_.options();
  if (line == "quit") return "Disconnected";
  if (line == "robotmode") return std::string("Robotmode: ") + robot_mode_name(machine_.robot_mode());
  if (line == "safetymode") return std::string("Safetymode: ") + safety_mode_name(machine_.safety_mode());
  if (line == "safetystatus") return std::string("Safetystatus: ") + safety_mode_name(machine_.safety_mode());
  if (line == "running") return plays ? "Program running: true" : "Program running: false";
  if (line == "programState")
    return (plays                                            ? "PLAYING "
            : machine_.program() == Machine::Program::paused ? "PAUSED "
                                                             : "STOPPED ") +
           program_.name();
  if (line == "is in remote control") return machine_.remote() ? "true" : "false";
  if (line == "PolyscopeVersion")
    return fmt::format("URSoftware {}.{}.{}.0 (Jan 01 2026)", o.major, o.minor, o.bugfix);
  if (line == "version" && o.major >= 5) return fmt::format("{}.{}.{}.0", o.major, o.minor, o.bugfix);
  if (line == "get robot model") return o.facts.model;
  if (line == "get serial number") return "20260000001";
  if (line == "get operational mode") return "NONE";
  if (line == "get loaded program") return "No program loaded";
  if (line.starts_with("popup ")) return "showing popup";
  if (line == "close popup") return "closing popup";
  if (line == "close safety popup") return "closing safety popup";
  if (line.starts_with("addToLog ")) return "Added log message";
  if (line == "power on")
    return remote(
        [&] { return machine_.switch_on() ? "Powering on" : "Safety stop: it cannot be powered on"; });
  if (line == "power off")
    return remote([&] {
      machine_.switch_off();
      return "Powering off";
    });
  if (line == "brake release")
    return remote([&]() -> const char* {
      machine_.switch_on();
      machine_.release_brakes();
      return "Brake releasing";
    });
  if (line == "unlock protective stop")
    return remote([&] {
      return machine_.unlock() ? "Protective stop releasing"
                               : "Cannot unlock protective stop until 5s after occurrence.";
    });
  if (line == "restart safety") {
    machine_.safety(safety_normal);
    machine_.switch_off();
    return "Restarting safety";
  }
  if (line == "stop") {
    if (program_.runs()) {
      program_.stop();
      primary_.program_ended();
    }
    return "Stopped";
  }
  if (line == "pause") return remote([&] { return program_.pause(true), "Pausing program"; });
  if (line == "play")
    return remote([&] {
      if (!machine_.may_move()) return "Failed to execute: play";
      program_.play();
      return "Starting program";
    });
  return "could not understand: '" + line + "'";
}

}  // namespace polyarm::ur
