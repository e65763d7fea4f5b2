#include "polyarm/base/reach.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>

#include "polyarm/base/error.hpp"
#include "polyarm/base/shell_word.hpp"

namespace polyarm {

namespace fs = std::filesystem;

namespace {
thread_local int as_user = 0;

bool inside_any(const fs::path& path, const std::vector<fs::path>& roots) {
  return std::any_of(roots.begin(), roots.end(), [&](const fs::path& root) { return inside(path, root); });
}

fs::path plain(const fs::path& path) {
  std::error_code error;
  return fs::absolute(path, error).lexically_normal();
}

void add(std::vector<fs::path>& to, const fs::path& path) {
  if (!path.empty() && std::find(to.begin(), to.end(), path) == to.end()) to.push_back(path);
}
}  // namespace

namespace {
/// Replaces the first symbolic link in `path` by its target. Returns `path` unchanged if it contains no link.
fs::path without_first_link(const fs::path& path) {
  std::error_code error;
  fs::path before;
  for (auto part = path.begin(); part != path.end(); ++part) {
    const fs::path here = before / *part;
    if (!fs::is_symlink(fs::symlink_status(here, error))) {
      before = here;
      continue;
    }
    fs::path out = before / fs::read_symlink(here, error);  // an absolute target replaces what is before it
    for (auto rest = std::next(part); rest != path.end(); ++rest) out /= *rest;
    return error ? path : out;
  }
  return path;
}
}  // namespace

fs::path resolved(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as Linux follows
  fs::path out = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(out, error);
    if (error) return plain(path);
    // A link whose target does not exist is left as it is: whoever creates the file creates the target.
    out = without_first_link(fs::absolute(real, error).lexically_normal());
    if (out == real) return out;
  }
  return out;
}

bool inside(const fs::path& path, const fs::path& root) {
  auto at = path.begin();
  for (const fs::path& part : root) {
    if (part.empty()) continue;  // of a '/' at the end
    if (at == path.end() || *at != part) return false;
    ++at;
  }
  return true;
}

fs::path project_root(const fs::path& cell_folder) {
  fs::path root = resolved(cell_folder.empty() ? fs::path(".") : cell_folder);
  std::error_code error;
  while (root.has_relative_path() && fs::is_regular_file(root / "cell.yaml", error) &&
         fs::is_regular_file(root.parent_path() / "cell.yaml", error))
    root = root.parent_path();
  return root;
}

void ReachGrant::allow(const fs::path& path) {
  const fs::path real = resolved(path);
  const std::lock_guard lock(mutex_);
  add(allowed_, real);
}

void ReachGrant::allow_reading(const fs::path& folder) {
  if (folder.empty()) return;
  const fs::path named = plain(folder), real = resolved(folder);
  const std::lock_guard lock(mutex_);
  add(readable_, named);
  add(readable_, real);
}

void ReachGrant::allow_host(const std::string& host) {
  const std::lock_guard lock(mutex_);
  hosts_.insert(host);
}

void ReachGrant::allow_secret(const std::string& name) {
  const std::lock_guard lock(mutex_);
  secrets_.insert(name);
}

bool ReachGrant::has_path(const fs::path& path, const fs::path& real, bool writes) const {
  const std::lock_guard lock(mutex_);
  if ((!cell_.empty() && inside(real, cell_)) || inside_any(real, allowed_)) return true;
  return !writes && (inside_any(real, readable_) || inside_any(plain(path), readable_));
}

bool ReachGrant::has_host(const std::string& host) const {
  const std::lock_guard lock(mutex_);
  return hosts_.contains(host) || hosts_.contains("all");
}

bool ReachGrant::has_secret(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return secrets_.contains(name);
}

fs::path ReachGrant::cell() const {
  const std::lock_guard lock(mutex_);
  return cell_;
}

void Reach::confine() {
  const std::lock_guard lock(mutex_);
  confined_ = true;
}

std::shared_ptr<ReachGrant> Reach::open_cell(const fs::path& cell_folder) {
  if (AsUser::active()) return std::make_shared<ReachGrant>();
  const fs::path root = project_root(cell_folder);
  auto out = grant();
  {
    const std::lock_guard lock(out->mutex_);
    out->cell_ = root;
  }
  const std::lock_guard lock(mutex_);
  any_cell_ = true;
  return out;
}

std::shared_ptr<ReachGrant> Reach::grant() {
  auto out = std::make_shared<ReachGrant>();
  const std::lock_guard lock(mutex_);
  std::erase_if(open_, [](const auto& each) { return each.expired(); });
  open_.push_back(out);
  return out;
}

std::vector<std::shared_ptr<const ReachGrant>> Reach::open() const {
  std::vector<std::shared_ptr<const ReachGrant>> out;
  const std::lock_guard lock(mutex_);
  for (const auto& each : open_)
    if (auto grant = each.lock()) out.push_back(std::move(grant));
  return out;
}

bool Reach::host_allowed(const std::string& host, const ReachGrant* grant) const {
  if (is_loopback(host) || all_.has_host(host) || (grant && grant->has_host(host))) return true;
  const std::lock_guard lock(mutex_);
  return !confined_;
}

bool Reach::secret_allowed(const std::string& name, const ReachGrant* grant) const {
  if (all_.has_secret(name) || (grant && grant->has_secret(name))) return true;
  const std::lock_guard lock(mutex_);
  return !confined_;
}

bool Reach::confined() const {
  const std::lock_guard lock(mutex_);
  return confined_ && any_cell_;
}

bool Reach::allows(const fs::path& path, const fs::path& real, Use use) const {
  if (!confined() || all_.has_path(path, real, use == Use::write)) return true;
  const auto grants = open();
  return std::any_of(grants.begin(), grants.end(),
                     [&](const auto& grant) { return grant->has_path(path, real, use == Use::write); });
}

namespace {
/// " /their/cell", the newest of the open cells.
std::string newest_cell(const std::vector<std::shared_ptr<const ReachGrant>>& grants) {
  for (auto grant = grants.rbegin(); grant != grants.rend(); ++grant)
    if (const fs::path cell = (*grant)->cell(); !cell.empty()) return " " + cell.string();
  return {};
}
}  // namespace

void Reach::check(const fs::path& path, const fs::path& real, Use use) const {
  if (AsUser::active() || allows(path, real, use)) return;
  const bool link = real != plain(path);
  throw Error(Problem{"outside-cell",
                      {path.string()},
                      std::string("a cell may not ") + (use == Use::read ? "read" : "write") +
                          " this file, which is outside its folder" + newest_cell(open()) +
                          (link ? ": links lead to " + real.string() : ""),
                      "copy it into the cell's folder; or, if you trust the cell, add --allow " +
                          shell_word(real.string()) + " to the command"});
}

Reach& reach() {
  static Reach only;
  return only;
}

AsUser::AsUser() {
  ++as_user;
}
AsUser::~AsUser() {
  --as_user;
}
bool AsUser::active() {
  return as_user > 0;
}

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "::1" || host == "[::1]") return true;
  return host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos;
}

namespace {
/// As the XDG Base Directory Specification has it.
fs::path folder_of_user(const char* variable, const char* below_home) {
  const char* set = std::getenv(variable);
  if (set && *set == '/') return fs::path(set) / "polyarm";
  const char* home = std::getenv("HOME");
  return home && *home ? fs::path(home) / below_home / "polyarm" : fs::path();
}
}  // namespace

fs::path config_folder() {
  return folder_of_user("XDG_CONFIG_HOME", ".config");
}

fs::path cache_folder() {
  return folder_of_user("XDG_CACHE_HOME", ".cache");
}

}  // namespace polyarm
