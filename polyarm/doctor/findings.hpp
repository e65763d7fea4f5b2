#pragma once
/// Judges a machine: each finding is good, a note, or a problem. Pure functions of the collected data; any
/// thread.
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/doctor/machine.hpp"

namespace polyarm::doctor {

enum class Grade { ok, note, problem };
const char* name(Grade grade);

/// What a finding affects: any cell, a cell with real devices, or a cell with real-time demands.
enum class Concern { simulation, hardware, real_time };
const char* name(Concern concern);

struct Finding {
  Grade grade = Grade::ok;
  Concern concern = Concern::simulation;
  std::string topic;  ///< "kernel", "serial port"
  std::string text;   ///< one line
  std::string mend;   ///< a command that solves it; every problem has one, a note may have one
};

/// The installed parts of Polyarm.
struct Installation {
  std::size_t robots = 0;       ///< of the catalogue
  std::string catalogue_error;  ///< why the catalogue cannot be read; empty: it can
  std::vector<std::string> catalogue_folders;
  std::vector<std::string> driver_folders;  ///< search path of drivers
  struct Module {
    std::string name;
    bool found = false;
    std::string fault;  ///< why it cannot be loaded; empty: it can
  };
  std::vector<Module> modules;
  std::vector<std::string> cells;  ///< running cells
};

/// Free space on the disk for recordings and black boxes.
struct Disk {
  std::string folder;
  std::int64_t free_bytes = 0;
};

std::vector<Finding> judge(const Machine& machine);
std::vector<Finding> judge(const Clock& clock);
std::vector<Finding> judge(const Installation& installation);
std::vector<Finding> judge(const Disk& disk);

/// True if no problem affects simulation.
bool may_simulate(const std::vector<Finding>& findings);

}  // namespace polyarm::doctor
