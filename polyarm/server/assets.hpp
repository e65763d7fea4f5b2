#pragma once
/// Files of the pendant's page and help, compiled into the command. Also compresses and decompresses gzip.
#include <map>
#include <string>
#include <string_view>

namespace polyarm::server {

struct Asset {
  std::string_view data;
  bool gzip = false;  ///< stored compressed
};
/// Keys are paths ("/index.html", "/assets/index-4f3a.js"). Empty if the command was built without a page.
const std::map<std::string, Asset>& embedded_page();
/// The documentation as a site; keys are paths ("/help/index.html"). Empty if the command was built without a
/// page.
const std::map<std::string, Asset>& embedded_help();
/// Reads the page from a folder, once; for people who develop the page. Throws Error("no-file").
std::map<std::string, Asset> page_in(const std::string& folder);
/// Decompresses gzip data. Throws Error("bad-gzip") if the input is not gzip, or unpacks to more than 64 MiB.
std::string unzipped(std::string_view gzip);
/// Compresses with gzip. Throws Error("bad-gzip") when memory runs out.
std::string zipped(std::string_view bytes);
/// The media type (Content-Type) of a file, by its extension.
const char* media_type(std::string_view path);

}  // namespace polyarm::server
