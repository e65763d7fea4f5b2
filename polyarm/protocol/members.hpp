#pragma once
/// How a struct of the protocol says what its members are. The name of a member is its key in JSON; a
/// trailing underscore, for names that C++ keeps for itself, is left out of the key.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/protocol/any.hpp"

namespace polyarm::protocol {

// What a member's type says:
//   std::optional<T>  may be left out, and is left out of an answer where it is empty
//   bool              may be left out of a request: then it is false
//   OrNull<T>         null where it is empty
//   Names             one text, or a list of texts
//   Merged<T>         the members of T stand among those of this struct; all are left out where it is empty
// Everything else is needed.

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

/// A message of ROS: a map, or a text in YAML or JSON.
struct Message : Any {
  using Any::Any;
};

/// The words of an enumeration, in the order of its values from 0 on: one list for reading, writing and docs.
/// Specialised by each enumeration: `kNoun` ("step") and `kWords` (an array of const char*).
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
/// The members of a struct, in the order of the reference: POLYARM_MEMBERS(Struct, first, second).
#define POLYARM_MEMBERS(self, ...)                       \
  static constexpr const char* kStruct = #self;          \
  template <class Visitor>                               \
  static void members([[maybe_unused]] Visitor& visit) { \
    POLYARM_EACH(POLYARM_MEMBER, self, __VA_ARGS__)      \
  }
/// The same of a struct that has all the members of `base` first.
#define POLYARM_MORE_MEMBERS(self, base, ...)       \
  static constexpr const char* kStruct = #self;     \
  template <class Visitor>                          \
  static void members(Visitor& visit) {             \
    base::members(visit);                           \
    POLYARM_EACH(POLYARM_MEMBER, self, __VA_ARGS__) \
  }
