#pragma once
/// How a struct of the protocol lists its members. The name of a member is its key in JSON. A trailing
/// underscore, used where the key is a C++ keyword, is not part of the key.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/protocol/any.hpp"

namespace polyarm::protocol {

// The type of a member decides how its key is used:
//   std::optional<T>  may be omitted from a request; omitted from an answer if empty
//   bool              may be omitted from a request, and is then false
//   OrNull<T>         null if empty
//   Names             one text, or a list of texts
//   Merged<T>         the members of T appear among those of this struct; omitted if empty
// A key of any other type is required.

template <class T>
struct OrNull : std::optional<T> {
  using std::optional<T>::optional;
};

template <class T>
struct Merged : std::optional<T> {
  using std::optional<T>::optional;
};

struct Names : std::vector<std::string> {
  using std::vector<std::string>::vector;
  Names(std::vector<std::string> names) : std::vector<std::string>(std::move(names)) {}
};

/// A ROS message: a map, or a text in YAML or JSON.
struct Message : Any {
  using Any::Any;
};

/// The words of an enumeration, in the order of its values from 0, for reading, writing and docs. Each
/// enumeration specialises it with `kNoun` ("step") and `kWords` (an array of const char*).
template <class E>
struct Words;

}  // namespace polyarm::protocol

#define POLYARM_PARENTHESES ()
#define POLYARM_EXPAND(...) POLYARM_EXPAND_3(POLYARM_EXPAND_3(POLYARM_EXPAND_3(__VA_ARGS__)))
#define POLYARM_EXPAND_3(...) POLYARM_EXPAND_2(POLYARM_EXPAND_2(POLYARM_EXPAND_2(__VA_ARGS__)))
#define POLYARM_EXPAND_2(...) POLYARM_EXPAND_1(POLYARM_EXPAND_1(POLYARM_EXPAND_1(__VA_ARGS__)))
#define POLYARM_EXPAND_1(...) __VA_ARGS__
#define POLYARM_EACH(macro, self, ...) __VA_OPT__(POLYARM_EXPAND(POLYARM_EACH_STEP(macro, self, __VA_ARGS__)))
#define POLYARM_EACH_STEP(macro, self, first, ...) \
  macro(self, first) __VA_OPT__(POLYARM_EACH_AGAIN POLYARM_PARENTHESES(macro, self, __VA_ARGS__))
#define POLYARM_EACH_AGAIN() POLYARM_EACH_STEP

#define POLYARM_MEMBER(self, name) visit(#name, &self::name);
/// Lists the members of a struct, in the order of the reference: POLYARM_MEMBERS(Struct, first, second).
#define POLYARM_MEMBERS(self, ...)                       \
  static constexpr const char* kStruct = #self;          \
  template <class Visitor>                               \
  static void members([[maybe_unused]] Visitor& visit) { \
    POLYARM_EACH(POLYARM_MEMBER, self, __VA_ARGS__)      \
  }
/// The same for a struct that derives from `base`, whose members come first.
#define POLYARM_MORE_MEMBERS(self, base, ...)       \
  static constexpr const char* kStruct = #self;     \
  template <class Visitor>                          \
  static void members(Visitor& visit) {             \
    base::members(visit);                           \
    POLYARM_EACH(POLYARM_MEMBER, self, __VA_ARGS__) \
  }
