#pragma once
/// The page's files, which are compiled into the command.
#include <map>
#include <string>
#include <string_view>

namespace polyarm::server {

struct Asset {
  std::string_view data;
  bool gzip = false;  ///< it is stored compressed
};
/// By path ("/index.html", "/assets/index-4f3a.js"). Empty where the command was built without a page.
const std::map<std::string, Asset>& embedded_page();
/// The documentation as a site, by path ("/help/index.html"). Empty where the command was built without a page.
const std::map<std::string, Asset>& embedded_help();
/// The page from a folder, read once; for who works on the page. Throws Error("no-file").
std::map<std::string, Asset> page_in(const std::string& folder);
/// What gzip has compressed, as it was. Throws Error("bad-gzip") for what is none, or more than 64 MiB.
std::string unzipped(std::string_view gzip);
/// Compresses with gzip. Throws Error("bad-gzip") when memory runs out.
std::string zipped(std::string_view bytes);
/// What a browser is told a file is, by its ending.
const char* media_type(std::string_view path);

}  // namespace polyarm::server
