/// Tables that POLYARM_PLUGIN does not make, one for each definition.
#include "tests/plugins/things.hpp"

using namespace polyarm::hardware;

namespace {
const PluginEntry kGood = POLYARM_HARDWARE("table/Follower", things::Follower, "");
#if defined(OTHER_MAJOR)
const PluginTable kTable{kPluginMajor + 1, 0, nullptr, nullptr, nullptr, nullptr, nullptr, 77};
#elif defined(NEWER_MINOR)
const PluginTable kTable{kPluginMajor, kPluginMinor + 1, kPluginAbi, kPluginCompiler, "n", "1", &kGood, 1};
#elif defined(OTHER_ABI)
const PluginTable kTable{
    kPluginMajor, kPluginMinor, "Itanium C++ ABI, 64 bit, libc++", "Clang 19.1.7", "abi", "1", &kGood, 1};
#elif defined(OTHER_LAYOUT)
const PluginEntry kOld{"table/Follower",
                       PluginKind::hardware,
                       kComponentLayout + 1,
                       make_hardware<things::Follower>,
                       nullptr,
                       ""};
const PluginTable kTable{kPluginMajor, kPluginMinor, kPluginAbi, kPluginCompiler, "layout", "1", &kOld, 1};
#elif defined(OTHER_CONTROLLER_LAYOUT)
const PluginEntry kOld{
    "table/Holder", PluginKind::controller,          polyarm::controllers::kControllerLayout + 1,
    nullptr,        make_controller<things::Holder>, ""};
const PluginTable kTable{kPluginMajor, kPluginMinor, kPluginAbi, kPluginCompiler, "layout2", "1", &kOld, 1};
#elif defined(NO_FACTORY)
const PluginEntry kHole{"table/Follower", PluginKind::hardware, kComponentLayout, nullptr, nullptr, ""};
const PluginTable kTable{kPluginMajor, kPluginMinor, kPluginAbi, kPluginCompiler, "hole", "1", &kHole, 1};
#elif defined(OTHER_KIND)
const PluginEntry kStrange{"table/Planner", static_cast<PluginKind>(9), 0, nullptr, nullptr, ""};
const PluginTable kTable{kPluginMajor, kPluginMinor, kPluginAbi, kPluginCompiler, "kind", "1", &kStrange, 1};
#endif
}  // namespace

extern "C" const PluginTable* polyarm_plugin() {
#if defined(THROWS)
  throw std::runtime_error("not today");
#elif defined(NO_TABLE)
  return nullptr;
#else
  return &kTable;
#endif
}
