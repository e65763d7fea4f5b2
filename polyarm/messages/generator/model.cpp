#include "polyarm/messages/generator/model.hpp"

#include <openssl/evp.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace polyarm::messages::generator {

namespace {

struct Primitive {
  int kind;
  std::size_t bytes;
};
const std::map<std::string, Primitive>& primitives() {
  static const std::map<std::string, Primitive> all{
      {"int8", {2, 1}},   {"uint8", {3, 1}}, {"int16", {4, 2}},  {"uint16", {5, 2}},   {"int32", {6, 4}},
      {"uint32", {7, 4}}, {"int64", {8, 8}}, {"uint64", {9, 8}}, {"float32", {10, 4}}, {"float64", {11, 8}},
      {"char", {3, 1}},   {"bool", {15, 1}}, {"byte", {16, 1}},  {"string", {17, 4}},
  };
  return all;
}

/// The hidden member of a struct without fields. It exists only on the wire.
const char* const kNothing = "structure_needs_at_least_one_member";

/// An entry of the list: a name and its lines, separated at ---.
struct Entry {
  std::string package, kind, name;
  std::vector<Type> parts{1};
  std::string distribution;  ///< "": all distributions without their own entry
};

class Reader {
 public:
  explicit Reader(const std::string& file) : file_{file}, in_{file} {
    if (!in_) throw std::runtime_error(file + ": cannot be read");
  }

  Interfaces read() {
    for (std::string line; std::getline(in_, line);) {
      ++line_;
      if (line.empty() || line[0] == '#') continue;
      line[0] == ' ' ? member(line) : begin(line);
    }
    end();
    for (auto& [distribution, varied] : varied_) made_.of_distributions[distribution] = with_users(varied);
    return std::move(made_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(line_) + ": " + what);
  }

  void begin(const std::string& line) {
    end();
    const std::size_t space = line.find(' '), from = space == std::string::npos ? 0 : space + 1;
    const std::size_t first = line.find('/'), last = line.rfind('/');
    if (first == std::string::npos || first == last) fail("a name is package/kind/Name");
    entry_ = {line.substr(from, first - from),
              line.substr(first + 1, last - first - 1),
              line.substr(last + 1),
              {},
              line.substr(0, from == 0 ? 0 : space)};
    entry_.parts.resize(1);
    if (entry_.kind != "msg" && entry_.kind != "srv" && entry_.kind != "action")
      fail("a kind is msg, srv or action");
  }

  void member(const std::string& line) {
    std::istringstream words(line);
    std::string type, name, rest;
    words >> type >> name >> rest;
    if (type == "---") return static_cast<void>(entry_.parts.emplace_back());
    if (entry_.name.empty() || name.empty())
      fail("a field is a type and a name, under the name of its message");
    Type& part = entry_.parts.back();
    if (const std::size_t equals = name.find('='); equals != std::string::npos) {
      part.constants.push_back({type, name.substr(0, equals), name.substr(equals + 1)});
    } else {
      part.fields.push_back(field(type, name, rest));
    }
  }

  Field field(const std::string& word, const std::string& name, const std::string& initial) const {
    const std::size_t bracket = word.find('[');
    Field made{word.substr(0, bracket), name, Shape::single, 0, initial, 0};
    if (const std::size_t bound = made.type.find("<="); bound != std::string::npos) {
      made.text_capacity = static_cast<std::uint32_t>(std::stoul(made.type.substr(bound + 2)));
      made.type.resize(bound);
      if (made.type != "string") fail("only a string has a bound of its own");
    }
    if (bracket != std::string::npos) {
      const std::string inside = word.substr(bracket + 1, word.size() - bracket - 2);
      const bool bounded = inside.substr(0, 2) == "<=";
      made.shape = inside.empty() ? Shape::sequence : bounded ? Shape::bounded : Shape::array;
      if (!inside.empty())
        made.capacity = static_cast<std::uint32_t>(std::stoul(inside.substr(bounded ? 2 : 0)));
    }
    if (is_primitive(made.type)) return made;
    const std::size_t slash = made.type.find('/');
    if (slash == std::string::npos) fail("there is no type " + made.type);
    made.type.insert(slash, "/msg");
    if (!known_.contains(made.type)) fail(made.type + " is not defined before its use");
    return made;
  }

  void add(const std::string& name, Type type) {
    type.name = name;
    if (!entry_.distribution.empty()) {
      if (!known_.contains(name)) fail(name + " differs from nothing");
      varied_[entry_.distribution].emplace(name, std::move(type));
      return;
    }
    known_.insert(name);
    made_.types.push_back(std::move(type));
  }

  void end() {
    if (entry_.name.empty()) return;
    const std::string full = entry_.package + "/" + entry_.kind + "/" + entry_.name;
    const std::size_t parts = entry_.kind == "msg" ? 1 : entry_.kind == "srv" ? 2 : 3;
    if (entry_.parts.size() != parts) fail(full + " has " + std::to_string(entry_.parts.size()) + " parts");
    if (entry_.kind == "msg") add(full, std::move(entry_.parts[0]));
    if (entry_.kind == "srv") {
      add(full + "_Request", std::move(entry_.parts[0]));
      add(full + "_Response", std::move(entry_.parts[1]));
    }
    if (entry_.kind == "action") action(full);
    entry_ = {};
  }

  /// An action on the wire: two services and a topic around its three parts (ROS 2 design, actions).
  void action(const std::string& full) {
    const Field id{"unique_identifier_msgs/msg/UUID", "goal_id", Shape::single, 0, "", 0};
    add(full + "_Goal", std::move(entry_.parts[0]));
    add(full + "_Result", std::move(entry_.parts[1]));
    add(full + "_Feedback", std::move(entry_.parts[2]));
    add(full + "_SendGoal_Request", {"", {}, {id, {full + "_Goal", "goal", Shape::single, 0, "", 0}}});
    add(full + "_SendGoal_Response", {"",
                                      {},
                                      {{"bool", "accepted", Shape::single, 0, "", 0},
                                       {"builtin_interfaces/msg/Time", "stamp", Shape::single, 0, "", 0}}});
    add(full + "_GetResult_Request", {"", {}, {id}});
    add(full + "_GetResult_Response", {"",
                                       {},
                                       {{"int8", "status", Shape::single, 0, "", 0},
                                        {full + "_Result", "result", Shape::single, 0, "", 0}}});
    add(full + "_FeedbackMessage", {"", {}, {id, {full + "_Feedback", "feedback", Shape::single, 0, "", 0}}});
  }

  /// The types that differ in a distribution and all types that use one of them, in the order of the list.
  std::vector<Type> with_users(const std::map<std::string, Type>& varied) const {
    std::vector<Type> out;
    std::set<std::string> names;
    for (const Type& type : made_.types) {
      const auto own = varied.find(type.name);
      const Type& taken = own == varied.end() ? type : own->second;
      bool uses = own != varied.end();
      for (const Field& field : taken.fields) uses |= names.contains(field.type);
      if (!uses) continue;
      names.insert(type.name);
      out.push_back(taken);
    }
    return out;
  }

  std::string file_;
  std::ifstream in_;
  int line_ = 0;
  Entry entry_;
  Interfaces made_;
  std::map<std::string, std::map<std::string, Type>> varied_;
  std::set<std::string> known_;
};

std::string short_name(const std::string& name) {
  const std::size_t at = name.find("/msg/");
  return at == std::string::npos ? name : name.substr(0, at) + name.substr(at + 4);
}

std::string brackets(const Field& field) {
  const std::string count = std::to_string(field.capacity);
  switch (field.shape) {
    case Shape::single:
      return "";
    case Shape::array:
      return "[" + count + "]";
    case Shape::bounded:
      return "[<=" + count + "]";
    case Shape::sequence:
      return "[]";
  }
  return "";
}

std::string lines(const Type& type) {
  std::string out;
  for (const Constant& constant : type.constants)
    out += constant.type + " " + constant.name + "=" + constant.value + "\n";
  for (const Field& field : type.fields)
    out += short_name(field.type) +
           (field.text_capacity > 0 ? "<=" + std::to_string(field.text_capacity) : "") + brackets(field) +
           " " + field.name + (field.initial.empty() ? "" : " " + field.initial) + "\n";
  return out;
}

/// Every type that `type` uses, in the order of first use.
void collect(const Type& type, const std::map<std::string, const Type*>& all, std::vector<const Type*>& out) {
  for (const Field& field : type.fields) {
    if (is_primitive(field.type)) continue;
    const Type* used = all.at(field.type);
    bool there = false;
    for (const Type* other : out) there |= other == used;
    if (there) continue;
    out.push_back(used);
    collect(*used, all, out);
  }
}

/// A type description as in REP 2016, with the spaces of its reference implementation.
std::string description(const Type& type) {
  static constexpr std::array<int, 4> shapes{0, 48, 96, 144};
  std::vector<Field> fields = type.fields;
  if (fields.empty()) fields.push_back({"uint8", kNothing, Shape::single, 0, "", 0});
  std::string out = "{\"type_name\": \"" + type.name + "\", \"fields\": [";
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Field& field = fields[i];
    constexpr int kBoundedText = 21;
    const int id = (field.text_capacity > 0 ? kBoundedText : field_kind(field)) +
                   shapes[static_cast<std::size_t>(field.shape)];
    out += (i > 0 ? ", " : "") + std::string("{\"name\": \"") + field.name +
           "\", \"type\": {\"type_id\": " + std::to_string(id) +
           ", \"capacity\": " + std::to_string(field.capacity) +
           ", \"string_capacity\": " + std::to_string(field.text_capacity) + ", \"nested_type_name\": \"" +
           (is_primitive(field.type) ? "" : field.type) + "\"}}";
  }
  return out + "]}";
}

std::string sha256(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 failed");
  std::string out;
  for (unsigned i = 0; i < size; ++i) {
    std::array<char, 3> hex{};
    std::snprintf(hex.data(), hex.size(), "%02x", digest[i]);
    out += hex.data();
  }
  return out;
}

}  // namespace

Interfaces read_interfaces(const std::string& file) {
  return Reader(file).read();
}

bool is_primitive(const std::string& type) {
  return primitives().contains(type);
}

int field_kind(const Field& field) {
  const auto at = primitives().find(field.type);
  return at == primitives().end() ? 1 : at->second.kind;
}

std::size_t least_bytes(const Type& type, const std::map<std::string, const Type*>& all) {
  std::size_t sum = type.fields.empty() ? 1 : 0;
  for (const Field& field : type.fields) {
    if (field.shape == Shape::bounded || field.shape == Shape::sequence) {
      sum += 4;
      continue;
    }
    const std::size_t one =
        is_primitive(field.type) ? primitives().at(field.type).bytes : least_bytes(*all.at(field.type), all);
    sum += one * (field.shape == Shape::array ? field.capacity : 1);
  }
  return sum;
}

std::string schema(const Type& type, const std::map<std::string, const Type*>& all) {
  std::vector<const Type*> used;
  collect(type, all, used);
  std::string out = lines(type);
  for (const Type* other : used)
    out += std::string(80, '=') + "\nMSG: " + short_name(other->name) + "\n" + lines(*other);
  return out;
}

std::string type_hash(const Type& type, const std::map<std::string, const Type*>& all) {
  std::vector<const Type*> used;
  collect(type, all, used);
  std::map<std::string, const Type*> sorted;
  for (const Type* other : used) sorted.emplace(other->name, other);
  std::string text = "{\"type_description\": " + description(type) + ", \"referenced_type_descriptions\": [";
  bool first = true;
  for (const auto& [name, other] : sorted)
    text += (std::exchange(first, false) ? "" : ", ") + description(*other);
  return "RIHS01_" + sha256(text + "]}");
}

}  // namespace polyarm::messages::generator
