#pragma once
/// What a shared library exports so that its hardware and controllers are found by name: one C function that
/// returns a table. Standard types only, and few of them: plugins include this.
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

/// The interface between this program and its plugins. The major number changes when a plugin must be
/// changed or built again; the minor one when something was added that older plugins do not know of.
inline constexpr std::uint32_t kPluginMajor = 1, kPluginMinor = 0;

/// What two libraries must share to hand each other C++ objects: the rules for classes and exceptions, the
/// size of a pointer, and the standard library with the form of its strings and containers.
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

/// Told in lists and refusals; compilers of one ABI may be mixed.
#if defined(__clang__)
inline constexpr const char* kPluginCompiler = __VERSION__;
#else
inline constexpr const char* kPluginCompiler = "GCC " __VERSION__;
#endif

/// A number that changes with the size of any of the types: a guard against headers of another version.
template <typename... Types>
constexpr std::uint32_t layout_of() {
  std::uint32_t out = 2166136261u;
  ((out = (out ^ static_cast<std::uint32_t>(sizeof(Types))) * 16777619u), ...);
  return out;
}

enum class PluginKind : std::uint32_t { hardware = 1, controller = 2 };

/// One thing that a plugin makes. The factories may throw; exactly the one of the kind is there.
struct PluginEntry {
  const char* name;  ///< "vendor/Type", as users write it
  PluginKind kind;
  std::uint32_t layout;  ///< kComponentLayout or kControllerLayout, as the plugin was built with
  Component* (*make_hardware)();
  controllers::Controller* (*make_controller)();
  const char* help;  ///< one line, for lists
};

/// All of it. The numbers stay the first two members of every later table; nothing after them is read before
/// they have been accepted.
struct PluginTable {
  std::uint32_t major, minor;  ///< kPluginMajor and kPluginMinor, as the plugin was built with
  const char* abi;
  const char* compiler;
  const char* name;     ///< of the plugin, unlike that of any other
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

/// The one function, `const PluginTable* polyarm_plugin()`. NAME and VERSION are texts; what follows are
/// entries.
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
/// A component under a name; needs polyarm/hardware/component.hpp.
#define POLYARM_HARDWARE(NAME, TYPE, HELP)                                              \
  {                                                                                     \
    NAME, polyarm::hardware::PluginKind::hardware, polyarm::hardware::kComponentLayout, \
        &polyarm::hardware::make_hardware<TYPE>, nullptr, HELP                          \
  }
/// A controller under a name; needs polyarm/controllers/controller.hpp.
#define POLYARM_CONTROLLER(NAME, TYPE, HELP)                                                           \
  {                                                                                                    \
    NAME, polyarm::hardware::PluginKind::controller, polyarm::controllers::kControllerLayout, nullptr, \
        &polyarm::hardware::make_controller<TYPE>, HELP                                                \
  }
/// A driver that is part of Polyarm, in `polyarm_driver_<name>.so`: its name is that of its file, so that it
/// is found without being loaded.
#define POLYARM_DRIVER(TYPE) POLYARM_PLUGIN("", "", POLYARM_HARDWARE("", TYPE, ""))
