#include "polyarm/protocol/type.hpp"

#include "polyarm/protocol/describe.hpp"

namespace polyarm::protocol {

const std::vector<Member>& Type::members() const {
  static const std::vector<Member> none;
  return none;
}

Any written(const Type& type, const void* value) {
  Json out;
  type.write(value, out);
  return Any(std::move(out));
}

bool read_value(const Type& type, const Any& any, void* to) {
  return type.read(any.json(), to);
}

bool TextType::read(const Json& from, void* to) const {
  if (!from.is_string()) return false;
  *static_cast<std::string*>(to) = from.get<std::string>();
  return true;
}
void TextType::write(const void* from, Json& to) const {
  to = *static_cast<const std::string*>(from);
}

bool FlagType::read(const Json& from, void* to) const {
  if (!from.is_boolean()) return false;
  *static_cast<bool*>(to) = from.get<bool>();
  return true;
}
void FlagType::write(const void* from, Json& to) const {
  to = *static_cast<const bool*>(from);
}

bool NamesType::read(const Json& from, void* to) const {
  Names& out = *static_cast<Names*>(to);
  out.clear();
  if (from.is_string()) out.push_back(from.get<std::string>());
  if (from.is_array())
    for (const Json& each : from)
      if (each.is_string()) out.push_back(each.get<std::string>());
  return from.is_string() || (from.is_array() && out.size() == from.size());
}
void NamesType::write(const void* from, Json& to) const {
  to = static_cast<const std::vector<std::string>&>(*static_cast<const Names*>(from));
}

bool AnyType::read(const Json& from, void* to) const {
  *static_cast<Any*>(to) = Any(from);
  return true;
}
void AnyType::write(const void* from, Json& to) const {
  to = static_cast<const Any*>(from)->json();
}

bool MessageType::read(const Json& from, void* to) const {
  return (from.is_string() || from.is_structured() || from.is_number()) && AnyType::read(from, to);
}

bool FlagsType::read(const Json& from, void* to) const {
  if (!from.is_array()) return false;
  for (const Json& each : from)
    if (!each.is_boolean()) return false;
  *static_cast<std::vector<bool>*>(to) = from.get<std::vector<bool>>();
  return true;
}
void FlagsType::write(const void* from, Json& to) const {
  to = *static_cast<const std::vector<bool>*>(from);
}

std::string WordsType::typescript() const {
  std::string out;
  for (const std::string& word : words_) out += (out.empty() ? "'" : " | '") + word + "'";
  return out;
}

std::size_t WordsType::index_of(const std::string& text) const {
  const auto at = std::find(words_.begin(), words_.end(), text);
  if (at != words_.end()) return static_cast<std::size_t>(at - words_.begin());
  const std::vector<std::string> before(words_.begin(), words_.end() - 1);
  throw Error("bad-argument",
              std::string("there is no ") + noun_ + " '" + text + "'" + did_you_mean(text, words_),
              before.empty() ? words_.back() : join(before, ", ") + " or " + words_.back());
}

namespace {

void read_numbers(const Json& from, Vec3& to) {
  to = {from[0], from[1], from[2]};
}
void read_numbers(const Json& from, Quaternion& to) {
  to = {from[0], from[1], from[2], from[3]};
}
void write_numbers(const Vec3& from, Json& to) {
  to = {from.x, from.y, from.z};
}
void write_numbers(const Quaternion& from, Json& to) {
  to = {from.x, from.y, from.z, from.w};
}

}  // namespace

template <class T, std::size_t kCount>
bool NumbersType<T, kCount>::read(const Json& from, void* to) const {
  const auto finite = [](const Json& each) { return each.is_number() && std::isfinite(each.get<double>()); };
  if (!from.is_array() || from.size() != kCount || !std::all_of(from.begin(), from.end(), finite))
    return false;
  read_numbers(from, *static_cast<T*>(to));
  return true;
}
template <class T, std::size_t kCount>
void NumbersType<T, kCount>::write(const void* from, Json& to) const {
  write_numbers(*static_cast<const T*>(from), to);
}
template class NumbersType<Vec3, 3>;
template class NumbersType<Quaternion, 4>;

bool StructType::read(const Json& from, void* to) const {
  if (!from.is_object()) return false;
  for (const Member& member : members_) {
    void* const here = static_cast<char*>(to) + member.offset;
    if (member.merged) {
      member.type->read(from, here);
      continue;
    }
    const auto found = from.find(member.name);
    if (found == from.end() ? member.needed : !member.type->read(*found, here)) return false;
  }
  return true;
}

void StructType::write(const void* from, Json& to) const {
  if (!to.is_object()) to = Json::object();  // merged members are added to the existing object
  for (const Member& member : members_) {
    const void* const value = static_cast<const char*>(from) + member.offset;
    if (member.type->is_absent(value)) continue;
    member.type->write(value, member.merged ? to : to[member.name]);
  }
}

std::string StructType::shape() const {
  std::vector<std::string> all;
  for (const Member& member : members_) {
    std::string inside = member.type->shape();
    if (member.merged)
      all.push_back("or also " + inside);
    else
      all.push_back(member.name + (member.type->is_optional() ? "?" : "") + ": " + inside);
  }
  return "{" + join(all, ", ") + "}";
}

void StructType::collect(std::vector<const Type*>& structs) const {
  if (std::find(structs.begin(), structs.end(), this) != structs.end()) return;
  structs.push_back(this);
  for (const Member& member : members_) member.type->collect(structs);
}

}  // namespace polyarm::protocol
