#pragma once
/// The interface of plugins: a shared library exports one C function that returns a table of its hardware and
/// controllers. Uses few types, all standard, because plugins include this file.
///
///   #include "polyarm/hardware/component.hpp"
///   class Arm : public polyarm::hardware::Component { … };
///   POLYARM_PLUGIN("acme", "1.0.0", POLYARM_HARDWARE("acme/Arm", Arm, "the arm of Acme over its serial
///   bus"))
#include <cstdint>

namespace polyarm::controllers {
class Controller;
}

namespace polyarm::hardware {
class Component;

/// Version of the interface between this program and its plugins. The major number changes if plugins must be
/// changed or rebuilt; the minor number if something was added that older plugins do not use.
inline constexpr std::uint32_t kPluginMajor = 1, kPluginMinor = 0;

/// What two libraries must have in common to exchange C++ objects: the ABI for classes and exceptions, the
/// pointer size, and the standard library with the layout of its strings and containers.
#if defined(_LIBCPP_VERSION)
#define POLYARM_STANDARD_LIBRARY_ "libc++"
#elif !defined(__GLIBCXX__)
#define POLYARM_STANDARD_LIBRARY_ "another standard library"
#elif defined(_GLIBCXX_DEBUG)
#define POLYARM_STANDARD_LIBRARY_ "libstdc++ with debug containers"
#elif _GLIBCXX_USE_CXX11_ABI
#define POLYARM_STANDARD_LIBRARY_ "libstdc++"
#else
#define POLYARM_STANDARD_LIBRARY_ "libstdc++ with strings of before C++11"
#endif
#if defined(__LP64__)
#define POLYARM_WORD_ "64 bit"
#else
#define POLYARM_WORD_ "32 bit"
#endif
inline constexpr const char* kPluginAbi = "Itanium C++ ABI, " POLYARM_WORD_ ", " POLYARM_STANDARD_LIBRARY_;

/// Shown in lists and refusals; compilers with the same ABI may be mixed.
#if defined(__clang__)
inline constexpr const char* kPluginCompiler = __VERSION__;
#else
inline constexpr const char* kPluginCompiler = "GCC " __VERSION__;
#endif

/// A hash of the sizes of the types; detects headers of another version.
template <typename... Types>
constexpr std::uint32_t layout_of() {
  std::uint32_t out = 2166136261u;
  ((out = (out ^ static_cast<std::uint32_t>(sizeof(Types))) * 16777619u), ...);
  return out;
}

enum class PluginKind : std::uint32_t { hardware = 1, controller = 2 };

/// One type that a plugin provides. The factories may throw; only the one of its kind is set.
struct PluginEntry {
  const char* name;  ///< "vendor/Type", as users write it
  PluginKind kind;
  std::uint32_t layout;  ///< kComponentLayout or kControllerLayout, as the plugin was built with
  Component* (*make_hardware)();
  controllers::Controller* (*make_controller)();
  const char* help;  ///< one line, for lists
};

/// The plugin's table. The numbers stay the first two members in all versions; nothing after them is read
/// before they are accepted.
struct PluginTable {
  std::uint32_t major, minor;  ///< kPluginMajor and kPluginMinor, as the plugin was built with
  const char* abi;
  const char* compiler;
  const char* name;     ///< of the plugin; must be unique
  const char* version;  ///< of the plugin; any text
  const PluginEntry* entries;
  std::uint32_t count;
};

template <typename Type>
Component* make_hardware() {
  return new Type;
}
template <typename Type>
controllers::Controller* make_controller() {
  return new Type;
}

}  // namespace polyarm::hardware

/// Defines the exported function `const PluginTable* polyarm_plugin()`. NAME and VERSION are texts, followed
/// by the entries.
#define POLYARM_PLUGIN(NAME, VERSION, ...)                                                                   \
  extern "C" __attribute__((visibility("default"))) const polyarm::hardware::PluginTable* polyarm_plugin() { \
    static const polyarm::hardware::PluginEntry entries[] = {__VA_ARGS__};                                   \
    static const polyarm::hardware::PluginTable table = {polyarm::hardware::kPluginMajor,                    \
                                                         polyarm::hardware::kPluginMinor,                    \
                                                         polyarm::hardware::kPluginAbi,                      \
                                                         polyarm::hardware::kPluginCompiler,                 \
                                                         NAME,                                               \
                                                         VERSION,                                            \
                                                         entries,                                            \
                                                         sizeof entries / sizeof entries[0]};                \
    return &table;                                                                                           \
  }
/// An entry for a component; needs polyarm/hardware/component.hpp.
#define POLYARM_HARDWARE(NAME, TYPE, HELP)                                              \
  {                                                                                     \
    NAME, polyarm::hardware::PluginKind::hardware, polyarm::hardware::kComponentLayout, \
        &polyarm::hardware::make_hardware<TYPE>, nullptr, HELP                          \
  }
/// An entry for a controller; needs polyarm/controllers/controller.hpp.
#define POLYARM_CONTROLLER(NAME, TYPE, HELP)                                                           \
  {                                                                                                    \
    NAME, polyarm::hardware::PluginKind::controller, polyarm::controllers::kControllerLayout, nullptr, \
        &polyarm::hardware::make_controller<TYPE>, HELP                                                \
  }
/// A driver of Polyarm, in `polyarm_driver_<name>.so`. Its name is part of the file name, so it is found
/// without loading the file.
#define POLYARM_DRIVER(TYPE) POLYARM_PLUGIN("", "", POLYARM_HARDWARE("", TYPE, ""))
