#include "polyarm/protocol/wire.hpp"

#include <fmt/format.h>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/protocol/describe.hpp"
#include "polyarm/protocol/problem.hpp"

namespace polyarm::protocol {

bool nested_too_deep(const std::string& line) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > bounds::kRequestNesting) return true;
  }
  return false;
}

Any parse_request(const std::string& line) {
  const char* example = "for example {\"request\": \"control.list\"}";
  if (nested_too_deep(line)) throw Error("bad-request", "the request is nested more than 64 deep", example);
  Json request = Json::parse(line, nullptr, false);
  if (request.is_discarded() || !request.is_object())
    throw Error("bad-request", "a request is one JSON object a line", example);
  return Any(std::move(request));
}

Any request_id(const Any& fields) {
  const auto id = fields.json().find("id");
  if (id == fields.json().end()) return {};
  if (!id->is_number() && Any(*id).dump().size() > bounds::kRequestIdBytes)
    throw Error("bad-request", fmt::format("the 'id' has more than {} bytes", bounds::kRequestIdBytes));
  return Any(*id);
}

const RequestType& request_type_of(const Any& fields) {
  const auto name = fields.json().find("request");
  if (name == fields.json().end() || !name->is_string())
    throw Error("bad-argument", "the request needs the text 'request'");
  const std::string wanted = name->get<std::string>();
  if (const RequestType* found = find_request(wanted); found && !found->facts->session) return *found;
  std::vector<std::string> known;
  for (const RequestType* type : request_types())
    if (!type->facts->session) known.emplace_back(type->facts->name);
  throw Error("unknown-request", "there is no request '" + wanted + "'" + did_you_mean(wanted, known),
              "`help` lists them");
}

namespace {

void require_known(const RequestType& type, const Json& fields) {
  std::vector<std::string> known;
  for (const Member& member : type.arguments->members()) known.push_back(member.name);
  for (const auto& [key, value] : fields.items())
    if (key != "request" && key != "id" && std::find(known.begin(), known.end(), key) == known.end())
      throw Error("bad-argument",
                  std::string(type.facts->name) + " has no argument '" + key + "'" + did_you_mean(key, known),
                  known.empty() ? "it takes none" : "it takes " + join(known, ", "));
}

/// Arguments with free content, such as files and programs. The receiver checks values of type "any" and
/// "message".
bool is_content(const std::string& key) {
  return key == "text";
}

/// Refuses control characters: names become file names, lines in files and lines on terminals.
void require_plain(const std::string& text, const std::string& of) {
  if (printable_line(text) == text) return;
  throw Error("bad-argument", of + " has control characters: '" + shortened(printable_line(text)) + "'",
              "a name may have letters, digits, spaces and punctuation");
}

void require_plain_names(const Json& value, const std::string& of) {
  if (value.is_string()) require_plain(value.get_ref<const std::string&>(), of);
  if (!value.is_structured()) return;
  for (const auto& [key, item] : value.items()) {
    if (value.is_object()) require_plain(key, "a key in " + of);
    if (!value.is_object() || !is_content(key)) require_plain_names(item, of);
  }
}

void require_plain_names(const RequestType& type, const Json& fields) {
  for (const Member& member : type.arguments->members()) {
    const auto found = fields.find(member.name);
    const bool free = member.type->shape().find("any") != std::string::npos || member.type->word() == "message";
    if (found == fields.end() || is_content(member.name)) continue;
    const std::string of = "'" + member.name + "' of " + type.facts->name;
    if (!free) require_plain_names(*found, of);
    if (free && found->is_object())
      for (const auto& [key, item] : found->items()) require_plain(key, "a key in " + of);
  }
}

}  // namespace

Request read_request(const RequestType& type, const Any& fields) {
  const std::string request = type.facts->name;
  std::shared_ptr<void> out = type.make();
  for (const Member& member : type.arguments->members()) {
    const auto found = fields.json().find(member.name);
    if (found == fields.json().end() || found->is_null()) {
      if (member.needed)
        throw Error("bad-argument", request + " needs '" + member.name + "' (" + member.type->word() + ")");
    } else if (!member.type->read(*found, static_cast<char*>(out.get()) + member.offset)) {
      throw Error("bad-argument",
                  "'" + member.name + "' of " + request + " is not of type " + member.type->word());
    }
  }
  if (!type.facts->session) require_known(type, fields.json());
  require_plain_names(type, fields.json());
  return {type, std::move(out)};
}

std::string request_line(const Request& request, const Any& id) {
  Json line = request.arguments().json();
  line["request"] = request.facts().name;
  if (!id.is_null()) line["id"] = id.json();
  return Any(std::move(line)).dump();
}

namespace {

Json error_json(const Error& error) {
  Json all = Json::array();
  for (const Problem& problem : error.problems()) {
    if (all.size() >= bounds::kErrorProblems) break;
    all.push_back(any_of(problem_facts(problem)).json());
  }
  Json out = all.front();
  if (all.size() > 1) out["all"] = all;
  return out;
}

std::string line_of(Json line, const Any& id) {
  if (!id.is_null()) line["id"] = id.json();
  return Any(std::move(line)).dump();
}

}  // namespace

std::string reply_line(const Reply& reply, const Any& id) {
  if (!reply.answer) return refusal_line(*reply.refusal, id);
  Json line{{"ok", true}, {"result", reply.answer->any().json()}};
  if (reply.more) line["more"] = true;
  return line_of(std::move(line), id);
}

std::string result_line(const Any& result, const Any& id) {
  return line_of({{"ok", true}, {"result", result.json()}}, id);
}

std::string refusal_line(const Error& error, const Any& id) {
  return line_of({{"ok", false}, {"error", error_json(error)}}, id);
}

}  // namespace polyarm::protocol
