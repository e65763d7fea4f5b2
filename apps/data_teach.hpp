#pragma once
/// `polyarm data teach`, `frame` and `tool`: teaches the robot's present position as a point, and computes
/// frames and tools from touched points.
#include <string>
#include <vector>

#include "apps/options.hpp"

namespace polyarm::apps {

struct TeachArguments {
  std::string file, name, in, cell, robot;
  std::vector<std::string> from;
  double most_mm = 1;
  bool yes = false;
};

void add_teaching(CommandLine& app, TeachArguments& arguments);
int run_teaching(const std::string& action, const TeachArguments& arguments);

}  // namespace polyarm::apps
