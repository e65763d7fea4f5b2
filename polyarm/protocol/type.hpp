#pragma once
/// A description of a C++ type of the protocol: how its values are read and written, and what they are
/// called.
#include <cstddef>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/protocol/any.hpp"

namespace polyarm::protocol {

class Type;

/// A member of a struct.
struct Member {
  std::string name;  ///< its key in JSON
  bool needed = false, merged = false;
  std::size_t offset = 0;  ///< within the struct, bytes
  const Type* type = nullptr;
};

/// Immutable; any thread. Values are passed by their address, which must be of the described type.
class Type {
 public:
  virtual ~Type() = default;
  /// False where JSON has a value of another kind there; then `to` is not to be used. Throws Error where more
  /// can be said.
  virtual bool read(const nlohmann::json& from, void* to) const = 0;
  virtual void write(const void* from, nlohmann::json& to) const = 0;
  /// The key of such a member is left out.
  virtual bool is_absent(const void* /*value*/) const { return false; }
  /// The key of such a member may be left out.
  virtual bool is_optional() const { return false; }
  /// One word for an argument of this type: "text", "number", "flag", "names", "map", "message", "any".
  virtual std::string word() const = 0;
  /// With everything that is in it: "[{name: text, rate: number}]".
  virtual std::string shape() const = 0;
  /// In TypeScript; structs by the name of their interface.
  virtual std::string typescript() const = 0;
  /// The structs in it, itself included.
  virtual void collect(std::vector<const Type*>& structs) const = 0;
  /// Of a struct: its name and members.
  virtual std::string name() const { return {}; }
  virtual const std::vector<Member>& members() const;
};

/// Defined in the room for each type of the protocol that another room writes by itself.
template <class T>
const Type& type_of();

/// The value that JSON says; nothing where it says none of this type.
template <class T>
std::optional<T> value_of(const Any& any);
bool read_value(const Type& type, const Any& any, void* to);
template <class T>
std::optional<T> value_of(const Any& any) {
  std::optional<T> out(std::in_place);
  if (!read_value(type_of<T>(), any, &*out)) out.reset();
  return out;
}

/// The value as JSON.
template <class T>
Any any_of(const T& value);
Any written(const Type& type, const void* value);
template <class T>
Any any_of(const T& value) {
  return written(type_of<T>(), &value);
}

}  // namespace polyarm::protocol
