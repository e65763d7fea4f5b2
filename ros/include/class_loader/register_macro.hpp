#pragma once
#include "pluginlib/class_list_macros.hpp"
#define CLASS_LOADER_REGISTER_CLASS(TYPE, BASE) PLUGINLIB_EXPORT_CLASS(TYPE, BASE)
