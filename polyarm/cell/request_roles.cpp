#include "polyarm/cell/request_roles.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {
constexpr const char* kRoleNames[] = {"watch", "operate", "program", "administer"};
constexpr auto kMayWatch = Role::watch, kMayOperate = Role::operate, kMayProgram = Role::program,
               kMayAdminister = Role::administer;
}  // namespace

const char* name(Role role) {
  return kRoleNames[static_cast<std::size_t>(role)];
}

std::optional<Role> role_named(std::string_view text) {
  for (std::size_t i = 0; i < std::size(kRoleNames); ++i)
    if (text == kRoleNames[i]) return static_cast<Role>(i);
  return std::nullopt;
}

const std::vector<RequestRole>& request_roles() {
  static const std::vector<RequestRole> table = {
      // telling
      {"help", kMayWatch},
      {"control.list", kMayWatch},
      {"control.types", kMayWatch},
      {"control.chains", kMayWatch},
      {"tags.list", kMayWatch},
      {"tags.history", kMayWatch},
      {"hardware.list", kMayWatch},
      {"interfaces", kMayWatch},
      {"health", kMayWatch},
      {"limits", kMayWatch},
      {"param.list", kMayWatch},
      {"param.get", kMayWatch},
      {"query", kMayWatch},
      {"watch", kMayWatch},
      {"jog.state", kMayWatch},
      {"events", kMayWatch},
      {"program", kMayWatch},
      {"program.watch", kMayWatch},
      {"program.check", kMayWatch},
      {"program.steps", kMayWatch},
      {"program.names", kMayWatch},
      {"program.dry", kMayWatch},
      {"record", kMayWatch},
      {"points", kMayWatch},
      {"points.here", kMayWatch},
      {"points.outside", kMayWatch},
      {"points.history", kMayWatch},
      {"plan.preview", kMayWatch},
      {"files", kMayWatch},
      {"files.read", kMayWatch},
      {"files.versions", kMayWatch},
      {"files.version", kMayWatch},
      {"language.words", kMayWatch},
      {"cell.check", kMayWatch},
      {"contacts", kMayWatch},
      {"cells", kMayWatch},
      {"session.hello", kMayWatch},
      {"session.watch", kMayWatch},
      {"session.end", kMayWatch},
      // bringing to rest, and answering for one's own keys and control
      {"control.hold", kMayWatch},
      {"control.stop", kMayWatch},
      {"jog.beat", kMayWatch},
      {"jog.end", kMayWatch},
      {"session.take", kMayWatch},
      {"session.release", kMayWatch},
      {"session.answer", kMayWatch},
      // operating
      {"control.resume", kMayOperate},
      {"control.back", kMayOperate},
      {"control.override", kMayOperate, nullptr, "percent"},
      {"control.discard", kMayOperate},
      {"control.recover", kMayOperate},
      {"control.arm", kMayOperate, nullptr, "confirmed"},
      {"hardware.recover", kMayOperate},
      {"tags.set", kMayOperate},
      {"tags.force", kMayOperate},
      {"tags.release", kMayOperate},
      {"send", kMayOperate},
      {"goal.cancel", kMayOperate},
      {"jog", kMayOperate},
      {"jog.begin", kMayOperate},
      {"jog.goto", kMayOperate, "dry"},
      {"jog.step", kMayOperate},
      {"target", kMayOperate},
      {"profile", kMayOperate, nullptr, "name"},
      {"move", kMayOperate},
      {"program.load", kMayOperate},
      {"program.start", kMayOperate},
      {"program.answer", kMayOperate},
      {"program.pause", kMayOperate},
      {"program.go", kMayOperate},
      {"program.step", kMayOperate},
      {"program.from", kMayOperate},
      {"program.stop", kMayOperate},
      {"record.start", kMayOperate},
      {"record.stop", kMayOperate},
      // programming
      {"program.break", kMayProgram},
      {"program.edited", kMayProgram},
      {"points.teach", kMayProgram},
      {"points.set", kMayProgram},
      {"points.shift", kMayProgram},
      {"points.group", kMayProgram},
      {"points.rename", kMayProgram},
      {"points.delete", kMayProgram},
      {"points.take", kMayProgram},
      {"points.undo", kMayProgram},
      {"points.frame", kMayProgram, "dry"},
      {"points.tool", kMayProgram, "dry"},
      {"files.draft", kMayProgram},
      {"files.write", kMayProgram},
      {"files.delete", kMayProgram},
      {"files.rename", kMayProgram},
      // administering
      {"control.switch", kMayAdminister, "dry"},
      {"control.load", kMayAdminister},
      {"control.configure", kMayAdminister},
      {"control.cleanup", kMayAdminister},
      {"control.unload", kMayAdminister},
      {"control.state", kMayAdminister},
      {"param.set", kMayAdminister},
      {"hardware.state", kMayAdminister},
      {"hardware.reload", kMayAdminister},
      {"cell.restart", kMayAdminister},
      {"cell.reach", kMayAdminister, nullptr, "allow"},
      {"cell.save_as", kMayAdminister},
      {"cell.new", kMayAdminister},
      {"cell.connect", kMayAdminister, nullptr, "real"},
      {"cell.change", kMayAdminister},
      {"cell.open", kMayAdminister},
      {"cell.reset", kMayAdminister},
  };
  return table;
}

Role role_needed(const std::string& request_name, const nlohmann::json& request) {
  const auto& table = request_roles();
  const auto row =
      std::find_if(table.begin(), table.end(), [&](const auto& each) { return request_name == each.request; });
  if (row == table.end()) return Role::administer;
  const auto given = [&](const char* key) {
    const auto found = request.find(key);
    return found != request.end() && !found->is_null() ? &*found : nullptr;
  };
  if (row->tells_with) {
    const nlohmann::json* flag = given(row->tells_with);
    if (flag && flag->is_boolean() && flag->get<bool>()) return Role::watch;
  }
  if (row->tells_without && !given(row->tells_without)) return Role::watch;
  return row->role;
}

std::string role_reference() {
  std::string out = "| role | requests |\n|---|---|\n";
  for (const Role role : {kMayWatch, kMayOperate, kMayProgram, kMayAdminister}) {
    std::vector<std::string> names;
    for (const RequestRole& row : request_roles()) {
      if (row.role != role) continue;
      std::string text = std::string("`") + row.request + "`";
      if (row.tells_with) text += std::string(" (with `") + row.tells_with + "`: watch)";
      if (row.tells_without) text += std::string(" (without `") + row.tells_without + "`: watch)";
      names.push_back(std::move(text));
    }
    out += std::string("| ") + name(role) + " | " + join(names, ", ") + " |\n";
  }
  return out;
}

}  // namespace polyarm::cell
