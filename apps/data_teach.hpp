#pragma once
/// `polyarm data teach`, `frame` and `tool`: where a robot stands as a point, frames and tools from points
/// that were touched.
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
