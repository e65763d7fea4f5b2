#pragma once
/// Makes the type descriptions (type.hpp) of C++ types. Private to the room: only its .cpp files include
/// this.
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

using Json = nlohmann::json;

template <class T>
const Type& description();

/// A type that contains no struct.
class LeafType : public Type {
 public:
  void collect(std::vector<const Type*>&) const override {}
  std::string shape() const override { return word(); }
};

class TextType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "text"; }
  std::string typescript() const override { return "string"; }
};

class FlagType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "flag"; }
  std::string typescript() const override { return "boolean"; }
};

template <class T>
class NumberType : public LeafType {
 public:
  /// Returns false for a fraction, if T is an integer, and for a value beyond the range of T.
  bool read(const Json& from, void* to) const override {
    if (!from.is_number()) return false;
    const double value = from.get<double>();
    if constexpr (std::is_integral_v<T>) {
      using Limits = std::numeric_limits<T>;
      if (value != std::floor(value) || value < static_cast<double>(Limits::min()) ||
          value > std::min(9e15, static_cast<double>(Limits::max())))
        return false;
    }
    *static_cast<T*>(to) = static_cast<T>(value);
    return std::isfinite(value);
  }
  void write(const void* from, Json& to) const override { to = *static_cast<const T*>(from); }
  std::string word() const override { return "number"; }
  std::string typescript() const override { return "number"; }
};

class NamesType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "names"; }
  std::string typescript() const override { return "string | string[]"; }
};

class AnyType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "any"; }
  std::string typescript() const override { return "unknown"; }
};

class MessageType : public AnyType {
 public:
  bool read(const Json& from, void* to) const override;
  std::string word() const override { return "message"; }
};

/// The words of an enumeration.
class WordsType : public LeafType {
 public:
  WordsType(const char* noun, std::vector<std::string> words) : noun_(noun), words_(std::move(words)) {}
  std::string word() const override { return "text"; }
  std::string shape() const override { return join(words_, " | "); }
  std::string typescript() const override;

 protected:
  /// Throws Error("bad-argument") that lists the valid words.
  std::size_t index_of(const std::string& text) const;
  const std::string& at(std::size_t index) const { return words_[index]; }

 private:
  const char* noun_;
  std::vector<std::string> words_;
};

template <class E>
class EnumType : public WordsType {
 public:
  EnumType() : WordsType(Words<E>::kNoun, {std::begin(Words<E>::kWords), std::end(Words<E>::kWords)}) {}
  bool read(const Json& from, void* to) const override {
    if (!from.is_string()) return false;
    *static_cast<E*>(to) = static_cast<E>(index_of(from.get<std::string>()));
    return true;
  }
  void write(const void* from, Json& to) const override {
    to = at(static_cast<std::size_t>(*static_cast<const E*>(from)));
  }
};

/// A type that wraps another type: optional, list, map.
class WrapperType : public Type {
 public:
  explicit WrapperType(const Type& inner) : inner_(inner) {}
  void collect(std::vector<const Type*>& structs) const override { inner_.collect(structs); }

 protected:
  const Type& inner_;
};

template <class Optional>
class OptionalType : public WrapperType {
 public:
  using Inner = typename Optional::value_type;
  static constexpr bool kNull = std::is_same_v<Optional, OrNull<Inner>>;
  OptionalType() : WrapperType(description<Inner>()) {}
  bool read(const Json& from, void* to) const override {
    Optional& out = *static_cast<Optional*>(to);
    out.emplace();
    if (!from.is_null() && inner_.read(from, &*out)) return true;
    out.reset();
    return kNull && from.is_null();
  }
  void write(const void* from, Json& to) const override {
    const Optional& value = *static_cast<const Optional*>(from);
    if (value) inner_.write(&*value, to);
  }
  bool is_absent(const void* value) const override { return !kNull && !*static_cast<const Optional*>(value); }
  bool is_optional() const override { return !kNull; }
  std::string word() const override { return inner_.word(); }
  std::string shape() const override { return kNull ? inner_.shape() + " or null" : inner_.shape(); }
  std::string typescript() const override { return inner_.typescript() + (kNull ? " | null" : ""); }
  const std::vector<Member>& members() const override { return inner_.members(); }
};

inline std::string in_parentheses(const std::string& type) {
  return type.find(' ') == std::string::npos || type.starts_with('{') ? type : "(" + type + ")";
}

template <class List>
class ListType : public WrapperType {
 public:
  using Item = typename List::value_type;
  ListType() : WrapperType(description<Item>()) {}
  bool read(const Json& from, void* to) const override {
    if (!from.is_array()) return false;
    List& out = *static_cast<List*>(to);
    if constexpr (requires { out.clear(); }) {
      out.clear();
      for (const Json& each : from) {
        Item item{};
        if (!inner_.read(each, &item)) return false;
        out.push_back(std::move(item));
      }
    } else {
      if (from.size() != out.size()) return false;
      for (std::size_t i = 0; i < out.size(); ++i)
        if (!inner_.read(from[i], &out[i])) return false;
    }
    return true;
  }
  void write(const void* from, Json& to) const override {
    to = Json::array();
    for (const Item& each : *static_cast<const List*>(from)) inner_.write(&each, to.emplace_back());
  }
  std::string word() const override { return "list"; }
  std::string shape() const override { return "[" + inner_.shape() + "]"; }
  std::string typescript() const override {
    if constexpr (requires(List & list) { list.clear(); }) return in_parentheses(inner_.typescript()) + "[]";
    std::string out;
    for (std::size_t i = 0; i < List{}.size(); ++i) out += (i ? ", " : "") + inner_.typescript();
    return "[" + out + "]";
  }
};

/// std::vector<bool>: its items have no addresses.
class FlagsType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "list"; }
  std::string shape() const override { return "[flag]"; }
  std::string typescript() const override { return "boolean[]"; }
};

template <class Item>
class MapType : public WrapperType {
 public:
  using Values = std::map<std::string, Item>;
  MapType() : WrapperType(description<Item>()) {}
  bool read(const Json& from, void* to) const override {
    if (!from.is_object()) return false;
    Values& out = *static_cast<Values*>(to);
    for (const auto& [key, value] : from.items())
      if (!inner_.read(value, &out[key])) return false;
    return true;
  }
  void write(const void* from, Json& to) const override {
    to = Json::object();
    for (const auto& [key, value] : *static_cast<const Values*>(from)) inner_.write(&value, to[key]);
  }
  std::string word() const override { return "map"; }
  std::string shape() const override { return "{NAME: " + inner_.shape() + "}"; }
  std::string typescript() const override { return "Record<string, " + inner_.typescript() + ">"; }
};

/// A 3-vector or a quaternion as a list of numbers.
template <class T, std::size_t kCount>
class NumbersType : public LeafType {
 public:
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "list"; }
  std::string shape() const override { return kCount == 3 ? "[x, y, z]" : "[x, y, z, w]"; }
  std::string typescript() const override {
    return kCount == 3 ? "[number, number, number]" : "[number, number, number, number]";
  }
};

/// One of two structs.
template <class First, class Second>
class EitherType : public Type {
 public:
  using Either = std::variant<First, Second>;
  bool read(const Json&, void*) const override { return false; }
  void write(const void* from, Json& to) const override {
    const Either& value = *static_cast<const Either*>(from);
    if (const First* first = std::get_if<First>(&value)) return description<First>().write(first, to);
    description<Second>().write(std::get_if<Second>(&value), to);
  }
  void collect(std::vector<const Type*>& structs) const override {
    description<First>().collect(structs);
    description<Second>().collect(structs);
  }
  std::string word() const override { return "any"; }
  std::string shape() const override {
    return description<First>().shape() + " or " + description<Second>().shape();
  }
  std::string typescript() const override {
    return description<First>().typescript() + " | " + description<Second>().typescript();
  }
};

class StructType : public Type {
 public:
  StructType(std::string name, std::vector<Member> members)
      : name_(std::move(name)), members_(std::move(members)) {}
  bool read(const Json& from, void* to) const override;
  void write(const void* from, Json& to) const override;
  std::string word() const override { return "map"; }
  std::string shape() const override;
  std::string typescript() const override { return name_; }
  void collect(std::vector<const Type*>& structs) const override;
  std::string name() const override { return name_; }
  const std::vector<Member>& members() const override { return members_; }

 private:
  std::string name_;
  std::vector<Member> members_;
};

template <class S>
struct MemberList {
  const S sample{};
  std::vector<Member> list;
  template <class Owner, class T>
  void operator()(const char* name, T Owner::*member) {
    const auto* begin = reinterpret_cast<const char*>(&sample);
    const auto* here = reinterpret_cast<const char*>(&(sample.*static_cast<T S::*>(member)));
    std::string key = name;
    if (key.ends_with('_')) key.pop_back();
    constexpr bool kOptional = requires(T & value) {
      value.has_value();
    };
    list.push_back({std::move(key), !kOptional && !std::is_same_v<T, bool>, is_merged<T>(),
                    static_cast<std::size_t>(here - begin), &description<T>()});
  }
  template <class T>
  static constexpr bool is_merged() {
    if constexpr (requires { typename T::value_type; })
      return std::is_same_v<T, Merged<typename T::value_type>>;
    return false;
  }
};

template <class T>
struct IsVariant : std::false_type {};
template <class A, class B>
struct IsVariant<std::variant<A, B>> : std::true_type {
  using Type = EitherType<A, B>;
};

/// The answer of a request is named after the request; any other struct after itself.
template <class S>
std::string struct_name() {
  if constexpr (requires { S::kOf; }) return std::string(S::kOf) + S::kStruct;
  return S::kStruct;
}

template <class T>
const Type& description() {
  if constexpr (requires(T value, MemberList<T> members) { T::members(members); }) {
    static const StructType type = [] {
      MemberList<T> members;
      T::members(members);
      return StructType(struct_name<T>(), std::move(members.list));
    }();
    return type;
  } else if constexpr (std::is_same_v<T, std::string>) {
    static const TextType type;
    return type;
  } else if constexpr (std::is_same_v<T, bool>) {
    static const FlagType type;
    return type;
  } else if constexpr (std::is_arithmetic_v<T>) {
    static const NumberType<T> type;
    return type;
  } else if constexpr (std::is_enum_v<T>) {
    static const EnumType<T> type;
    return type;
  } else if constexpr (std::is_same_v<T, Names>) {
    static const NamesType type;
    return type;
  } else if constexpr (std::is_same_v<T, Message>) {
    static const MessageType type;
    return type;
  } else if constexpr (std::is_same_v<T, Any>) {
    static const AnyType type;
    return type;
  } else if constexpr (std::is_same_v<T, Vec3>) {
    static const NumbersType<Vec3, 3> type;
    return type;
  } else if constexpr (std::is_same_v<T, Quaternion>) {
    static const NumbersType<Quaternion, 4> type;
    return type;
  } else if constexpr (std::is_same_v<T, std::vector<bool>>) {
    static const FlagsType type;
    return type;
  } else if constexpr (IsVariant<T>::value) {
    static const typename IsVariant<T>::Type type;
    return type;
  } else if constexpr (requires { typename T::mapped_type; }) {
    static const MapType<typename T::mapped_type> type;
    return type;
  } else if constexpr (requires(T value) { value.has_value(); }) {
    static const OptionalType<T> type;
    return type;
  } else {
    static const ListType<T> type;
    return type;
  }
}

template <class T>
const Type& type_of() {
  return description<T>();
}

template <class R>
const RequestType& request_type() {
  static const RequestType type{&R::kFacts, R::kStruct, &description<R>(), &description<typename R::Answer>(),
                                [] { return std::shared_ptr<void>(std::make_shared<R>()); }};
  return type;
}

}  // namespace polyarm::protocol

#define POLYARM_DEFINE_REQUEST(family, name) template const RequestType& request_type<name>();
#define POLYARM_REQUEST_ADDRESS(family, name) &request_type<name>(),
/// Defines the requests of a family, in the order of the reference. Use it in one .cpp file.
#define POLYARM_REQUESTS(family, ...)                                \
  POLYARM_EACH(POLYARM_DEFINE_REQUEST, family, __VA_ARGS__)          \
  const std::vector<const RequestType*>& family() {                  \
    static const std::vector<const RequestType*> list = {            \
        POLYARM_EACH(POLYARM_REQUEST_ADDRESS, family, __VA_ARGS__)}; \
    return list;                                                     \
  }
