#pragma once
/// Describes a C++ type of the protocol: how its values are read from and written to JSON, and its names in
/// the reference and in TypeScript.
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
  std::string name;  ///< key in JSON
  bool needed = false, merged = false;
  std::size_t offset = 0;  ///< within the struct, bytes
  const Type* type = nullptr;
};

/// Immutable; any thread. Values are passed by address, which must point to the described type.
class Type {
 public:
  virtual ~Type() = default;
  /// Returns false if the JSON value has another type; `to` must not be used then. Throws Error if a more
  /// specific reason is known.
  virtual bool read(const nlohmann::json& from, void* to) const = 0;
  virtual void write(const void* from, nlohmann::json& to) const = 0;
  /// True if this value's key is omitted.
  virtual bool is_absent(const void* /*value*/) const { return false; }
  /// True if the key of such a member may be omitted.
  virtual bool is_optional() const { return false; }
  /// One word for an argument of this type: "text", "number", "flag", "names", "list", "map", "message",
  /// "any".
  virtual std::string word() const = 0;
  /// The type with its content: "[{name: text, rate: number}]".
  virtual std::string shape() const = 0;
  /// The type in TypeScript; structs by the name of their interface.
  virtual std::string typescript() const = 0;
  /// Adds all structs in the type, including itself.
  virtual void collect(std::vector<const Type*>& structs) const = 0;
  /// Name and members of a struct; empty for other types.
  virtual std::string name() const { return {}; }
  virtual const std::vector<Member>& members() const;
};

/// Defined in the room for the types that other rooms convert themselves.
template <class T>
const Type& type_of();

/// The value in the JSON; nothing if it has another type.
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
