/// Writes the structs of interfaces.list and their wire format: polyarm_message_generator LIST FOLDER makes
/// FOLDER/types.hpp and FOLDER/types.cpp.
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "polyarm/messages/generator/model.hpp"

namespace polyarm::messages::generator {
namespace {

/// "sensor_msgs/msg/JointState" as its three words; a part of a service or action is in a struct of that
/// name.
struct Place {
  std::string package, kind, name;
  std::string space() const { return package + "::" + kind; }
  std::string full() const { return space() + "::" + name; }
};
Place place(const std::string& name) {
  const std::size_t first = name.find('/'), last = name.rfind('/');
  return {name.substr(0, first), name.substr(first + 1, last - first - 1), name.substr(last + 1)};
}

std::string element(const Field& field) {
  static const std::map<std::string, std::string> names{{"bool", "bool"},
                                                        {"byte", "std::uint8_t"},
                                                        {"char", "std::uint8_t"},
                                                        {"int8", "std::int8_t"},
                                                        {"uint8", "std::uint8_t"},
                                                        {"int16", "std::int16_t"},
                                                        {"uint16", "std::uint16_t"},
                                                        {"int32", "std::int32_t"},
                                                        {"uint32", "std::uint32_t"},
                                                        {"int64", "std::int64_t"},
                                                        {"uint64", "std::uint64_t"},
                                                        {"float32", "float"},
                                                        {"float64", "double"},
                                                        {"string", "std::string"}};
  if (field.type == "bool" && field.shape != Shape::single) return "std::uint8_t";
  const auto at = names.find(field.type);
  return at != names.end() ? at->second : "messages::" + place(field.type).full();
}

std::string cpp_type(const Field& field) {
  const std::string one = element(field);
  if (field.shape == Shape::single) return one;
  if (field.shape == Shape::array) return "std::array<" + one + ", " + std::to_string(field.capacity) + ">";
  return "std::vector<" + one + ">";
}

/// C++ names for the ROS names of services and actions: Trigger::Request is Trigger_Request.
std::string aliases(const std::vector<Type>& types) {
  std::map<std::string, std::map<std::string, std::vector<std::string>>> parts;  // space, name, parts
  for (const Type& type : types) {
    const Place at = place(type.name);
    if (at.kind == "msg") continue;
    const std::size_t underscore = at.name.find('_');
    parts[at.space()][at.name.substr(0, underscore)].push_back(at.name.substr(underscore + 1));
  }
  std::string out;
  for (const auto& [space, names] : parts) {
    out += "namespace " + space + " {\n";
    for (const auto& [name, all] : names) {
      out += "struct " + name + " {\n";
      for (const std::string& part : all) out += "  using " + part + " = " + name + "_" + part + ";\n";
      out += "};\n";
    }
    out += "}\n";
  }
  return out;
}

std::string structure(const Type& type) {
  const Place at = place(type.name);
  std::string out = "namespace " + at.space() + " {\nstruct " + at.name + " {\n";
  for (const Constant& constant : type.constants)
    out += "  static constexpr " + element({constant.type, "", Shape::single, 0, "", 0}) + " " +
           constant.name + " = " + constant.value + ";\n";
  for (const Field& field : type.fields)
    out += "  " + cpp_type(field) + " " + field.name + "{" + field.initial + "};\n";
  out += "  friend bool operator==(const " + at.name + "&, const " + at.name + "&) = default;\n};\n}\n";
  const std::string name = at.full();
  return out + "void write(CdrWriter& out, const " + name + "& message);\nvoid read(CdrReader& in, " + name +
         "& message);\ntemplate <>\nconst TypeInfo& type_info<" + name + ">();\n\n";
}

std::string header(const std::vector<Type>& types) {
  std::string out = R"(#pragma once
// Made from polyarm/messages/interfaces.list.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/messages/cdr.hpp"
#include "polyarm/messages/type_info.hpp"

namespace polyarm::messages {

)";
  for (const Type& type : types) out += structure(type);
  return out + aliases(types) + "}\n";
}

std::string writing(const Field& field) {
  const std::string member = "message." + field.name;
  const bool nested = !is_primitive(field.type);
  if (field.shape == Shape::single)
    return nested ? "  write(out, " + member + ");\n" : "  out.write(" + member + ");\n";
  const std::string elements = "  write_elements<" + element(field) + ">(out, " + member + ");\n";
  return field.shape == Shape::array ? elements : "  out.write_length(" + member + ".size());\n" + elements;
}

std::string reading(const Field& field, std::size_t least) {
  const std::string member = "message." + field.name;
  const bool nested = !is_primitive(field.type);
  if (field.shape == Shape::single)
    return nested ? "  read(in, " + member + ");\n" : "  in.read(" + member + ");\n";
  std::string out;
  if (field.shape != Shape::array)
    out += "  " + member + ".resize(in.read_length(" + std::to_string(least) +
           (field.shape == Shape::bounded ? ", " + std::to_string(field.capacity) : "") + "));\n";
  out += "  read_elements<" + element(field) + ">(in, " + member + ");\n";
  if (field.type == "bool")
    out +=
        "  for (const std::uint8_t byte : " + member + ")\n    if (byte > 1) in.fail(CdrError::boolean);\n";
  return out;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '\n' ? "\\n\"\n    \"" : std::string(1, c);
  return out + "\"";
}

std::string dds_name(const std::string& name) {
  const Place at = place(name);
  return at.package + "::" + at.kind + "::dds_::" + at.name + "_";
}

/// The smallest size of one element of the field, bytes.
std::size_t element_bytes(const Field& field, const std::map<std::string, const Type*>& all) {
  return least_bytes({"", {}, {{field.type, "", Shape::single, 0, "", 0}}}, all);
}

/// "sensor_msgs/msg/JointState" of humble → "humble_sensor_msgs_msg_JointState".
std::string function_name(const std::string& distribution, std::string type) {
  for (char& c : type)
    if (c == '/') c = '_';
  return distribution + "_" + type;
}

/// Writes the function `head` with the type information; `varied` are the names of types that differ in the
/// distribution.
std::string information(const Type& type, const std::map<std::string, const Type*>& all,
                        const std::string& head, const std::string& distribution,
                        const std::set<std::string>& varied) {
  static constexpr const char* shapes[] = {"single", "array", "bounded", "sequence"};
  std::string fields;
  for (const Field& field : type.fields)
    fields += "      {\"" + field.name + "\", static_cast<FieldKind>(" + std::to_string(field_kind(field)) +
              "), FieldShape::" + shapes[static_cast<std::size_t>(field.shape)] + ", " +
              std::to_string(field.capacity) + ", " + std::to_string(element_bytes(field, all)) + ", " +
              std::to_string(field.text_capacity) + ", " +
              (is_primitive(field.type)      ? "nullptr"
               : varied.contains(field.type) ? "&" + function_name(distribution, field.type) + "()"
                                             : "&type_info<" + place(field.type).full() + ">()") +
              "},\n";
  std::string out = head + " {\n";
  const std::string count = std::to_string(type.fields.size());
  out += "  static const std::array<FieldInfo, " + count + "> fields{{\n" + fields + "  }};\n";
  out += "  static const TypeInfo info{\"" + type.name + "\", \"" + dds_name(type.name) + "\", \"" +
         type_hash(type, all) + "\",\n    " + quoted(schema(type, all)) + ", fields};\n  return info;\n}\n";
  return out;
}

std::string functions(const Type& type, const std::map<std::string, const Type*>& all) {
  const std::string name = place(type.name).full();
  std::string out = "void write(CdrWriter& out, const " + name + "& message) {\n";
  for (const Field& field : type.fields) out += writing(field);
  if (type.fields.empty()) out += "  static_cast<void>(message);\n  out.write(std::uint8_t{0});\n";
  out += "}\nvoid read(CdrReader& in, " + name + "& message) {\n";
  for (const Field& field : type.fields) out += reading(field, element_bytes(field, all));
  if (type.fields.empty())
    out += "  static_cast<void>(message);\n  std::uint8_t nothing = 0;\n  in.read(nothing);\n";
  return out + "}\n" +
         information(type, all, "template <>\nconst TypeInfo& type_info<" + name + ">()", "", {}) + "\n";
}

/// Writes the types that differ in a distribution, and the list of them: humble_types().
std::string varied(const std::string& distribution, const std::vector<Type>& types,
                   std::map<std::string, const Type*> all) {
  std::set<std::string> names;
  std::string out = "namespace {\n", list;
  for (const Type& type : types) {
    names.insert(type.name);
    all[type.name] = &type;
  }
  for (const Type& type : types) {
    const std::string name = function_name(distribution, type.name) + "()";
    out += information(type, all, "const TypeInfo& " + name, distribution, names) + "\n";
    list += "      &" + name + ",\n";
  }
  return out + "}\n\nstd::span<const TypeInfo* const> " + distribution +
         "_types() {\n  static const std::array<const TypeInfo*, " + std::to_string(types.size()) +
         "> all{{\n" + list + "  }};\n  return all;\n}\n\n";
}

std::string source(const Interfaces& interfaces) {
  const std::vector<Type>& types = interfaces.types;
  std::map<std::string, const Type*> all;
  for (const Type& type : types) all.emplace(type.name, &type);
  std::string out = R"(// Made from polyarm/messages/interfaces.list.
#include "polyarm/messages/types.hpp"

namespace polyarm::messages {

)";
  std::string list;
  for (const Type& type : types) {
    out += functions(type, all);
    list += "      &type_info<" + place(type.name).full() + ">(),\n";
  }
  out += "std::span<const TypeInfo* const> types() {\n  static const std::array<const TypeInfo*, " +
         std::to_string(types.size()) + "> all{{\n" + list + "  }};\n  return all;\n}\n\n";
  for (const auto& [distribution, own] : interfaces.of_distributions) out += varied(distribution, own, all);
  return out + "}\n";
}

void save(const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(file + ": cannot be written");
}

}  // namespace
}  // namespace polyarm::messages::generator

int main(int argc, char** argv) {
  using namespace polyarm::messages::generator;
  try {
    if (argc != 3) throw std::runtime_error("usage: polyarm_message_generator LIST FOLDER");
    const Interfaces interfaces = read_interfaces(argv[1]);
    save(std::string(argv[2]) + "/types.hpp", header(interfaces.types));
    save(std::string(argv[2]) + "/types.cpp", source(interfaces));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "polyarm_message_generator: " << error.what() << "\n";
    return 1;
  }
}
