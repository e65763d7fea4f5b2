#include "polyarm/server/site.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/io/free_space.hpp"
#include "polyarm/meshes/robot_meshes.hpp"
#include "polyarm/recording/foxglove_server.hpp"
#include "polyarm/server/documents.hpp"
#include "polyarm/server/project_zip.hpp"
#include "polyarm/server/sessions.hpp"
#include "polyarm/server/viewers.hpp"
#include "polyarm/shapes/robot_shapes.hpp"
#include "polyarm/shapes/tool_shapes.hpp"

namespace polyarm::server {

namespace {

constexpr std::string_view kCatalogue = "/api/catalogue", kProject = "/api/project.zip";
/// Slow jobs run one after another. If more than this wait, further ones are refused.
constexpr int kMostWaiting = bounds::kSlowJobs;
constexpr std::string_view kLogin = "/api/login", kLogout = "/api/logout";
/// Log-ins that wait to be checked; further ones are refused.
constexpr std::size_t kMostLoginsWaiting = bounds::kLoginsWaiting;

constexpr const char* kNoPage =
    "<!doctype html><meta charset=utf-8><title>Polyarm</title><body "
    "style='font-family:sans-serif;margin:3em'>"
    "<h1>The pendant's page is not part of this build</h1>"
    "<p>The server runs: requests at <code>/ws</code>, files at <code>/api/…</code>. For the page install "
    "Node.js 18 or "
    "newer with npm (<code>tools/setup</code> does it) and build again.</p>";

HttpReply document(Text body, const char* type = "application/json") {
  HttpReply out;
  out.type = type;
  out.body = std::move(body);
  out.headers.emplace_back("Cache-Control", "no-store");
  return out;
}

Text text_of(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

}  // namespace

PageSite::PageSite(const PendantOptions& options, Sessions& sessions, Viewers& viewers, Logins& logins,
                   Scrapes& scrapes)
    : options_(options),
      sessions_(sessions),
      viewers_(viewers),
      logins_(logins),
      scrapes_(scrapes),
      page_(options.page_folder.empty() ? embedded_page() : page_in(options.page_folder)),
      documents_(std::make_shared<const Documents>()),
      worker_(std::make_unique<cell::Worker>(false)),
      login_worker_(std::make_unique<cell::Worker>(false)) {
  page_.insert(embedded_help().begin(), embedded_help().end());
}
PageSite::~PageSite() = default;

void PageSite::stop() {
  worker_.reset();
  login_worker_.reset();
}

void PageSite::show(cell::CellView& cell) {
  auto made = std::make_shared<Documents>();
  made->by_path["/api/cell"] = text_of(dump(cell_json(cell)));
  made->by_path["/api/scene"] = text_of(dump(scene_json(cell)));
  for (const auto& robot : cell.robots())
    made->by_path["/api/model/" + robot->entry.name] = text_of(dump(model_json(*robot)));
  made->meshes = meshes_of(cell);
  made->grippers = grippers_of(cell);
  made->mesh_cache = cell.file().folder / ".state" / "meshes";
  made->folder = cell.file().folder;
  made->cell = cell.file().name;
  const std::lock_guard lock(mutex_);
  documents_ = std::move(made);
}

void PageSite::show_nothing() {
  const std::lock_guard lock(mutex_);
  documents_ = std::make_shared<const Documents>();
}

std::shared_ptr<const PageSite::Documents> PageSite::documents() const {
  const std::lock_guard lock(mutex_);
  return documents_;
}

bool PageSite::is_open(const std::string& method, const std::string& path) const {
  if (path == kLogin) return method == "GET" || method == "POST";
  return (method == "GET" || method == "HEAD") && !path.starts_with("/api/") && path != "/ws";
}

std::size_t PageSite::most_body(const std::string& method, const std::string& path) const {
  return method == "PUT" && path == kProject ? bounds::kZipBytes : 0;
}

std::shared_ptr<Client> PageSite::welcome(Client::Side side) {
  return sessions_.welcome(std::move(side));
}

std::string PageSite::viewer_protocol(const std::string& offered) const {
  return recording::foxglove_subprotocol(offered);
}

std::shared_ptr<Stream> PageSite::welcome_viewer() {
  return viewers_.welcome();
}

std::vector<Problem> PageSite::take_problems() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problems_, {});
}

/// The uncompressed file, for clients that do not accept gzip; cached. I/O thread.
Text PageSite::plain_of(const std::string& path, const Asset& asset) const {
  Text& kept = plain_[path];
  if (!kept) kept = text_of(unzipped(asset.data));
  return kept;
}

HttpReply PageSite::page(const HttpRequest& request) const {
  if (request.token == Shown::query) {
    HttpReply out = plain(302, "continue at /");
    out.headers.emplace_back("Location", "/");
    out.headers.emplace_back("Set-Cookie", cookie(request, query_value(request.target, "token")));
    return out;
  }
  if (request.token == Shown::wrong && request.target.find("token=") != std::string::npos)
    return plain(403, "the token is wrong: open the link that polyarm printed last");
  if (request.path == "/help") {
    HttpReply out = plain(302, "continue at /help/");
    out.headers.emplace_back("Location", "/help/");
    return out;
  }
  const auto found = page_.find(request.path.ends_with('/') ? request.path + "index.html" : request.path);
  if (found == page_.end() && request.path == "/")
    return document(text_of(kNoPage), "text/html; charset=utf-8");
  if (found == page_.end()) return plain(404, "there is no such file");
  HttpReply out;
  out.type = media_type(found->first);
  out.gzip = found->second.gzip && request.gzip;
  out.body = found->second.gzip && !request.gzip ? plain_of(found->first, found->second)
                                                 : text_of(std::string(found->second.data));
  if (found->second.gzip) out.headers.emplace_back("Vary", "Accept-Encoding");
  out.headers.emplace_back("Cache-Control", request.path.starts_with("/assets/")
                                                ? "public, max-age=31536000, immutable"
                                                : "no-cache");
  return out;
}

std::string PageSite::cookie(const HttpRequest& request, const std::string& token, const char* more) const {
  return "polyarm_token_" + std::to_string(port_) + "=" + token + "; HttpOnly; SameSite=Strict; Path=/" +
         more + (request.secure ? "; Secure" : "");
}

void PageSite::log(const HttpRequest& request, const std::string& who, const std::string& what,
                   const std::string& outcome) {
  if (!options_.audit) return;
  users::AuditEntry entry;
  const auto shown = documents();
  entry.cell = shown->cell;
  entry.actor.name = who;
  entry.actor.from = request.from;
  entry.actor.door = "pendant";
  entry.request = what;
  entry.outcome = outcome;
  options_.audit->add(std::move(entry));
}

/// GET: whether there are users. POST: logs in with `Authorization: Basic …`; the answer sets the cookie.
void PageSite::log_in(const HttpRequest& request, const Reply& reply) {
  if (request.method == "GET") return reply(document(text_of(dump(who_may_log_in(request)))));
  const auto credentials = basic_credentials(request.authorization);
  if (!credentials) return reply(plain(400, "send name and password as Authorization: Basic"));
  if (!login_worker_ || !begin_log_in(network_of(request.from)))
    return reply(plain(503, "too many log in at once: try again"));
  login_worker_->post([this, request, reply, name = credentials->first, password = credentials->second] {
    HttpReply out;
    try {
      out = try_log_in(request, name, password);
    } catch (...) {
      out = plain(500, what_was_thrown());
    }
    end_log_in(network_of(request.from));
    reply(std::move(out));
  });
}

/// False if too many wait already, of all or of this address.
bool PageSite::begin_log_in(const std::string& from) {
  const std::lock_guard lock(mutex_);
  std::size_t all = 0;
  for (const auto& [network, count] : logins_waiting_) all += count;
  const auto own = logins_waiting_.find(from);
  if (all >= kMostLoginsWaiting ||
      (own != logins_waiting_.end() && own->second >= bounds::kLoginsWaitingOfAddress))
    return false;
  ++logins_waiting_[from];
  return true;
}

void PageSite::end_log_in(const std::string& from) {
  const std::lock_guard lock(mutex_);
  if (const auto own = logins_waiting_.find(from); own != logins_waiting_.end() && --own->second == 0)
    logins_waiting_.erase(own);
}

/// `enters`: it may connect, by a log-in or a link. The name only for a client that is logged in; why it
/// ended for one that was.
Json PageSite::who_may_log_in(const HttpRequest& request) {
  Json out{{"users", logins_.offered(steady_seconds())}};
  if (request.token != Shown::nothing && request.token != Shown::wrong) out["enters"] = true;
  if (request.login) out["name"] = request.login->user;
  if (const std::string why = request.login ? "" : logins_.why_ended(request.shown, steady_seconds());
      !why.empty()) {
    out["ended"] = why;
    out["hours"] = logins_.longest_s() / 3600;
  }
  return out;
}

HttpReply PageSite::try_log_in(const HttpRequest& request, const std::string& name,
                               const std::string& password) {
  const Logins::Result result = logins_.log_in(name, password, request.from, steady_seconds());
  log(request, printable_line(name.substr(0, users::kMostName)), "log-in",
      result.login ? "done" : result.why);
  if (result.login) {
    HttpReply out = document(text_of(dump({{"name", name}, {"role", protocol::name(result.login->role)}})));
    out.headers.emplace_back("Set-Cookie", cookie(request, result.token));
    return out;
  }
  if (result.wait_s > 0) {
    HttpReply out = plain(429, "too many wrong passwords: wait, then try again");
    out.headers.emplace_back("Retry-After", std::to_string(static_cast<int>(result.wait_s) + 1));
    return out;
  }
  return plain(403, result.why == "no-users" ? "there are no users: add them with polyarm users add"
                                             : "the name or the password is wrong");
}

HttpReply PageSite::log_out(const HttpRequest& request) {
  if (request.login) {
    logins_.log_out(request.shown);
    log(request, request.login->user, "log-out", "done");
  }
  HttpReply out = document(text_of("{}"));
  out.headers.emplace_back("Set-Cookie", cookie(request, "", "; Max-Age=0"));
  return out;
}

void PageSite::handle(HttpRequest request, Reply reply) {
  if (request.path == kLogin) return log_in(request, reply);
  if (request.path == kLogout && request.method == "POST") return reply(log_out(request));
  if (is_open(request.method, request.path)) return reply(page(request));
  if (request.path == kProject && (request.method == "GET" || request.method == "PUT"))
    return project(std::move(request), reply);
  if (request.method != "GET" && request.method != "HEAD")
    return reply(plain(405, "only GET is served here"));
  if (request.path == "/api/summary") return scrapes_.ask(Scrapes::Kind::summary, reply);
  if (request.path == "/api/requests") return reply(document(text_of(dump(requests_json()))));
  const auto shown = documents();
  if (const auto found = shown->by_path.find(request.path); found != shown->by_path.end())
    return reply(document(found->second));
  if (request.path == "/api/cell") return reply(plain(503, "no cell is running now"));
  if (!later(request, reply)) reply(plain(404, "there is no such file"));
}

/// Hands slow requests to the worker. Returns false if the path is not one of these.
bool PageSite::later(const HttpRequest& request, const Reply& reply) {
  const std::string& path = request.path;
  std::function<HttpReply()> job;
  if (options_.catalogue && path == kCatalogue) job = [this] { return catalogue(); };
  if (options_.catalogue && options_.picture && path.starts_with("/api/catalogue/") && path.ends_with(".svg"))
    job = [this, path] { return picture(path); };
  const auto shown = documents();
  const auto meshed = shown->meshes.find(path);
  if (meshed != shown->meshes.end() && !shapes::has_no_look(meshed->second))
    job = [this, shown, path] { return meshes(*shown, path); };
  else if (meshed != shown->meshes.end() || shown->grippers.contains(path))
    job = [this, shown, path, gzip = request.gzip] { return made_shapes(*shown, path, gzip); };
  if (!job) return false;
  post(std::move(job), reply);
  return true;
}

void PageSite::post(std::function<HttpReply()> job, const Reply& reply) {
  if (waiting_ >= kMostWaiting || !worker_) return reply(plain(503, "too many requests at once"));
  ++waiting_;
  worker_->post([this, job = std::move(job), reply] {
    HttpReply out;
    try {
      out = job();
    } catch (const Error& e) {
      out = plain(400, e.what());
    } catch (...) {
      out = plain(500, what_was_thrown());
    }
    --waiting_;
    reply(std::move(out));
  });
}

/// GET: sends a backup of the cell's folder. PUT: unpacks a project beside that folder.
void PageSite::project(HttpRequest request, const Reply& reply) {
  const protocol::Role needed =
      request.method == "GET" ? protocol::Role::program : protocol::Role::administer;
  if (request.role < needed)
    return reply(plain(403, (request.login ? request.login->user : std::string("this link")) +
                                " has the role " + protocol::name(request.role) +
                                ", and this needs the role " + protocol::name(needed)));
  const std::filesystem::path folder = documents()->folder;
  if (folder.empty()) return reply(plain(503, "no cell is running now"));
  log(request, request.login ? request.login->user : std::string("link to ") + protocol::name(request.role),
      request.method == "GET" ? "project.backup" : "project.restore", "asked");
  if (request.method == "GET")
    return post(
        [folder] {
          HttpReply out = document(text_of(zip_of(folder)), "application/zip");
          out.headers.emplace_back("Content-Disposition", "attachment");
          return out;
        },
        reply);
  const std::string name = query_value(request.target, "name");
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (name.empty() || name.size() > 60 || !std::all_of(name.begin(), name.end(), good))
    return reply(plain(400, "?name= must be letters, digits, _ and -"));
  post(
      [folder, name, zip = std::move(request.body)] {
        const std::filesystem::path into = place_beside(folder, name);
        cell::require_free_space(into.parent_path(), bounds::kUnzippedBytes);
        unzip_into(zip, into);
        return document(text_of(dump({{"folder", into.string()}})));
      },
      reply);
}

/// The generated shapes of a robot or gripper; kept compressed while the cell is shown.
HttpReply PageSite::made_shapes(const Documents& shown, const std::string& path, bool gzip) {
  Text& kept = shown.made[path];
  if (!kept) {
    const auto gripper = shown.grippers.find(path);
    kept = text_of(zipped(gripper != shown.grippers.end() ? shapes::tool_glb(gripper->second)
                                                          : shapes::robot_glb(shown.meshes.at(path))));
  }
  HttpReply out = document(gzip ? kept : text_of(unzipped(*kept)), "model/gltf-binary");
  out.gzip = gzip;
  out.headers = {{"Cache-Control", "private, max-age=31536000, immutable"}, {"Vary", "Accept-Encoding"}};
  return out;
}

HttpReply PageSite::meshes(const Documents& shown, const std::string& path) {
  Text glb;
  if (const auto patched = shown.patched.find(path); patched != shown.patched.end()) {
    glb = patched->second;
  } else {
    meshes::RobotMeshes made = meshes::robot_meshes(shown.meshes.at(path), shown.mesh_cache);
    glb = text_of(std::move(made.glb));
    if (!made.warnings.empty()) shown.patched[path] = glb;
    const std::lock_guard lock(mutex_);
    problems_.insert(problems_.end(), made.warnings.begin(), made.warnings.end());
    problems_.insert(problems_.end(), made.notes.begin(), made.notes.end());
  }
  HttpReply out = document(std::move(glb), "model/gltf-binary");
  out.headers = {{"Cache-Control", "private, max-age=31536000, immutable"}};
  return out;
}

HttpReply PageSite::catalogue() {
  if (!catalogue_) {
    Json list = Json::array();
    const auto maybe = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
    for (const description::CatalogueEntry& each : options_.catalogue->entries())
      list.push_back({{"id", each.name},
                      {"maker", each.maker},
                      {"model", each.model},
                      {"title", each.maker + " " + each.model},
                      {"axes", each.axes},
                      {"reach", maybe(each.reach_m)},
                      {"payload", maybe(each.payload_kg)},
                      {"mass", maybe(each.mass_kg)},
                      {"picture", std::string(kCatalogue) + "/" + each.name + ".svg"}});
    catalogue_ = text_of(dump(list));
  }
  return document(catalogue_);
}

HttpReply PageSite::picture(const std::string& path) {
  Text& kept = pictures_[path];
  if (!kept) {
    const std::string name = path.substr(kCatalogue.size() + 1, path.size() - kCatalogue.size() - 5);
    const auto names = options_.catalogue->names();
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      pictures_.erase(path);
      return plain(404, "there is no robot " + name);
    }
    kept = text_of(options_.picture(options_.catalogue->load(name)));
  }
  HttpReply out = document(kept, "image/svg+xml");
  out.headers = {{"Cache-Control", "private, max-age=3600"}};
  return out;
}

}  // namespace polyarm::server
