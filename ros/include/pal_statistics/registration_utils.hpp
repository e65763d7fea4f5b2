#pragma once
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "pal_statistics/pal_statistics.hpp"

namespace pal_statistics {

/// Overloads for types of one's own are found by their namespace.
template <typename T>
IdType customRegister(StatisticsRegistry& registry, const std::string& name, const T* variable,
                      RegistrationsRAII* bookkeeping = nullptr, bool enabled = true) {
  return registry.registerFunction(
      name, [variable] { return static_cast<double>(*variable); }, bookkeeping, enabled);
}
inline IdType customRegister(StatisticsRegistry& registry, const std::string& name,
                             const std::function<double()>& value, RegistrationsRAII* bookkeeping = nullptr,
                             bool enabled = true) {
  return registry.registerFunction(name, value, bookkeeping, enabled);
}
template <typename T>
IdType customRegister(StatisticsRegistry& registry, const std::string& name, const std::vector<T>* variable,
                      RegistrationsRAII* bookkeeping = nullptr, bool enabled = true) {
  IdType id = 0;
  for (std::size_t i = 0; i < variable->size(); ++i)
    id = registry.registerFunction(
        name + "[" + std::to_string(i) + "]",
        [variable, i] { return i < variable->size() ? static_cast<double>((*variable)[i]) : 0.0; },
        bookkeeping, enabled);
  return id;
}

}  // namespace pal_statistics
