#pragma once
/// A client of a cell's port: documents over HTTP, requests over a WebSocket. Each call has a time limit. One
/// thread.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/fleet/site_file.hpp"

namespace polyarm::fleet {

inline constexpr std::size_t kMostAnswer = bounds::kSiteAnswerBytes;  ///< bytes of one document or message

/// JSON of a stranger: what is nested deeper than a cell nests it is left out. A discarded value if it is no
/// JSON.
nlohmann::json parse_answer(const std::string& text);

/// All functions throw Error("no-cell-answer") with the reason; the next call connects again.
class CellClient {
 public:
  explicit CellClient(SiteCell cell, double timeout_s = 5);
  ~CellClient();
  /// The body of a document. Throws Error("refused") for any status but 200.
  std::string get(const std::string& path);
  /// Sends a request and returns the `result` of its answer. Throws Error with the code of a refusal.
  nlohmann::json ask(nlohmann::json request);
  /// Closes the WebSocket, and with it gives up control.
  void close() noexcept;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::fleet
