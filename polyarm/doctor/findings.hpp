#pragma once
/// What is to be said of a machine: good, worth knowing, or in the way. Pure functions of what was found.
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/doctor/machine.hpp"

namespace polyarm::doctor {

enum class Grade { ok, note, problem };
const char* name(Grade grade);

/// What a finding matters to: any cell, one with real devices, or one that must keep time.
enum class Concern { simulation, hardware, real_time };
const char* name(Concern concern);

struct Finding {
  Grade grade = Grade::ok;
  Concern concern = Concern::simulation;
  std::string topic;  ///< "kernel", "serial port"
  std::string text;   ///< one line
  std::string mend;   ///< a command; every problem has one, a note may
};

/// What of Polyarm itself is installed.
struct Installation {
  std::size_t robots = 0;       ///< of the catalogue
  std::string catalogue_error;  ///< why the catalogue cannot be read; empty: it can
  std::vector<std::string> catalogue_folders;
  std::vector<std::string> driver_folders;  ///< where drivers are looked for
  struct Module {
    std::string name;
    bool found = false;
    std::string fault;  ///< why it cannot be loaded; empty: it can
  };
  std::vector<Module> modules;
  std::vector<std::string> cells;  ///< that are running
};

/// Room on the disk that recordings and black boxes go to.
struct Disk {
  std::string folder;
  std::int64_t free_bytes = 0;
};

std::vector<Finding> judge(const Machine& machine);
std::vector<Finding> judge(const Clock& clock);
std::vector<Finding> judge(const Installation& installation);
std::vector<Finding> judge(const Disk& disk);

/// No problem concerns simulation.
bool may_simulate(const std::vector<Finding>& findings);

}  // namespace polyarm::doctor
