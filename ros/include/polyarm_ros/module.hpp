#pragma once
/// What the table of a module needs; see `polyarm plugin build`.
#include "ament_index_cpp/get_package_share_directory.hpp"
#include "pluginlib/class_loader.hpp"
#include "polyarm/hardware/plugin.hpp"
