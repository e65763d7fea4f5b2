#pragma once
/// What HTTP serves: the page, and what a page asks for beside requests.
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "polyarm/io/worker.hpp"
#include "polyarm/server/assets.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/server/port.hpp"

namespace polyarm::server {

class Sessions;
class Viewers;

class PageSite : public Site {
 public:
  /// All outlive this.
  PageSite(const PendantOptions& options, Sessions& sessions, Viewers& viewers);
  ~PageSite() override;
  void set_port(std::uint16_t port) { port_ = port; }
  /// Nothing more is answered from other threads than the port's.
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
  /// What went wrong on the way to a document, once; cell thread.
  std::vector<Problem> take_problems();

 private:
  using Reply = std::function<void(HttpReply)>;
  struct Documents {
    std::map<std::string, Text> by_path;
    std::map<std::string, description::RobotModel> meshes;
    std::filesystem::path mesh_cache;
    std::filesystem::path folder;  ///< of the cell
    /// Meshes of which not all could be read, by address, so that each problem is reported once. Used by the
    /// worker only.
    mutable std::map<std::string, Text> patched;
    /// Shapes made for robots, by address, compressed. Used by the worker only.
    mutable std::map<std::string, Text> made;
  };
  std::shared_ptr<const Documents> documents() const;
  HttpReply page(const HttpRequest& request) const;
  Text plain_of(const std::string& path, const Asset& asset) const;
  bool later(const HttpRequest& request, const Reply& reply);
  void post(std::function<HttpReply()> job, const Reply& reply);
  void project(HttpRequest request, const Reply& reply);
  HttpReply catalogue();
  HttpReply picture(const std::string& path);
  HttpReply meshes(const Documents& shown, const std::string& path);
  HttpReply made_shapes(const Documents& shown, const std::string& path, bool gzip);

  const PendantOptions& options_;
  Sessions& sessions_;
  Viewers& viewers_;
  std::uint16_t port_ = 0;
  std::map<std::string, Asset> page_;
  mutable std::map<std::string, Text> plain_;  // of what is stored compressed; the I/O thread's
  mutable std::mutex mutex_;
  std::shared_ptr<const Documents> documents_;
  std::vector<Problem> problems_;
  // the worker's
  Text catalogue_;
  std::map<std::string, Text> pictures_;
  std::unique_ptr<cell::Worker> worker_;
  std::atomic<int> waiting_{0};
};

}  // namespace polyarm::server
