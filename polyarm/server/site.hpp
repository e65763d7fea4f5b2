#pragma once
/// The HTTP side of the pendant: the page, and the files and JSON documents of its API.
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "polyarm/access/logins.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/server/assets.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/server/port.hpp"
#include "polyarm/server/scrapes.hpp"

namespace polyarm::server {

class Sessions;
class Viewers;

class PageSite : public Site {
 public:
  /// The arguments must outlive this.
  PageSite(const PendantOptions& options, Sessions& sessions, Viewers& viewers, Logins& logins,
           Scrapes& scrapes);
  ~PageSite() override;
  void set_port(std::uint16_t port) { port_ = port; }
  /// After this, no other thread than the port's answers requests.
  void stop();

  /// Cell thread.
  void show(cell::CellView& cell);
  void show_nothing();

  bool is_open(const std::string& method, const std::string& path) const override;
  std::size_t most_body(const std::string& method, const std::string& path) const override;
  void handle(HttpRequest request, std::function<void(HttpReply)> reply) override;
  std::shared_ptr<Client> welcome(Client::Side side) override;
  std::string viewer_protocol(const std::string& offered) const override;
  std::shared_ptr<Stream> welcome_viewer() override;
  /// Problems while making documents, each returned once. Cell thread.
  std::vector<Problem> take_problems();

 private:
  using Reply = std::function<void(HttpReply)>;
  struct Documents {
    std::map<std::string, Text> by_path;
    std::map<std::string, description::RobotModel> meshes;
    std::map<std::string, description::Tool> grippers;  ///< with a generated look, by its address
    std::filesystem::path mesh_cache;
    std::filesystem::path folder;  ///< of the cell
    std::string cell;              ///< its name
    /// Meshes that could not be read completely, by address, so that each problem is reported once. Used by
    /// the worker only.
    mutable std::map<std::string, Text> patched;
    /// Generated shapes of robots and grippers, by address, compressed. Used by the worker only.
    mutable std::map<std::string, Text> made;
  };
  std::shared_ptr<const Documents> documents() const;
  HttpReply page(const HttpRequest& request) const;
  Text plain_of(const std::string& path, const Asset& asset) const;
  bool later(const HttpRequest& request, const Reply& reply);
  void post(std::function<HttpReply()> job, const Reply& reply);
  void log_in(const HttpRequest& request, const Reply& reply);
  nlohmann::json who_may_log_in(const HttpRequest& request);
  HttpReply try_log_in(const HttpRequest& request, const std::string& name, const std::string& password);
  HttpReply log_out(const HttpRequest& request);
  void log(const HttpRequest& request, const std::string& who, const std::string& what,
           const std::string& outcome);
  std::string cookie(const HttpRequest& request, const std::string& token, const char* more = "") const;
  void project(HttpRequest request, const Reply& reply);
  HttpReply catalogue();
  HttpReply picture(const std::string& path);
  HttpReply meshes(const Documents& shown, const std::string& path);
  HttpReply made_shapes(const Documents& shown, const std::string& path, bool gzip);

  const PendantOptions& options_;
  Sessions& sessions_;
  Viewers& viewers_;
  Logins& logins_;
  Scrapes& scrapes_;
  std::uint16_t port_ = 0;
  std::map<std::string, Asset> page_;
  mutable std::map<std::string, Text> plain_;  // decompressed copies of compressed files; I/O thread
  mutable std::mutex mutex_;
  std::shared_ptr<const Documents> documents_;
  std::vector<Problem> problems_;
  // used by the worker only
  Text catalogue_;
  std::map<std::string, Text> pictures_;
  std::unique_ptr<cell::Worker> worker_;
  std::atomic<int> waiting_{0};
  std::unique_ptr<cell::Worker> login_worker_;  // passwords are checked one after another
  bool begin_log_in(const std::string& from);
  void end_log_in(const std::string& from);
  std::map<std::string, std::size_t> logins_waiting_;  ///< by network; guarded by mutex_
};

}  // namespace polyarm::server
