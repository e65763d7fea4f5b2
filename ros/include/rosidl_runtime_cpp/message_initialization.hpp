#pragma once
namespace rosidl_runtime_cpp {
/// Messages always start from their initial values.
enum class MessageInitialization { ALL, SKIP, ZERO, DEFAULTS_ONLY };
}  // namespace rosidl_runtime_cpp
