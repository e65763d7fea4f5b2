#include "polyarm/io/stream_entries.hpp"

#include <arpa/inet.h>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {
constexpr std::size_t kMostStreams = 32;

/// "HOST:PORT", or "PORT" on loopback.
void read_address(const Yaml& y, const char* key, StreamEntry& out) {
  const std::string text = y[key].text();
  const auto colon = text.rfind(':');
  if (colon != std::string::npos) out.host = text.substr(0, colon);
  if (out.host == "localhost") out.host = "127.0.0.1";
  const auto port = parse_number(colon == std::string::npos ? text : text.substr(colon + 1));
  if (!port || !(*port >= 1 && *port <= 65535) || *port != static_cast<int>(*port))
    throw Error(Problem{"bad-value", y[key].where(), "'" + text + "' has no port from 1 to 65535",
                        std::string("write such as ") + key + ": \"192.168.1.5:2000\""});
  out.port = static_cast<int>(*port);
  in_addr address{};
  if (inet_pton(AF_INET, out.host.c_str(), &address) != 1)
    throw Error(
        Problem{"bad-value", y[key].where(), "'" + out.host + "' is no IPv4 address",
                "write the address in numbers, such as 192.168.1.5: a name could take seconds to look up"});
}

StreamEntry read_stream(const std::string& name, const Yaml& y, Problems& problems) {
  y.check_keys({"connect", "listen", "device", "baud", "ends_with"}, problems);
  StreamEntry out;
  out.name = name;
  out.where = y.where();
  if (y.has("connect") + y.has("listen") + y.has("device") != 1)
    throw Error(Problem{"bad-value", y.where(),
                        "the stream '" + name + "' needs one of connect, listen and device",
                        "write such as connect: \"192.168.1.5:2000\", listen: 2000 or device: /dev/ttyUSB0"});
  if (y.has("connect")) read_address(y, "connect", out);
  if (y.has("listen")) out.kind = StreamEntry::Kind::listen, read_address(y, "listen", out);
  if (y.has("device")) out.kind = StreamEntry::Kind::device, out.device = y["device"].text();
  out.baud = static_cast<int>(y["baud"].number(Dimension::none, out.baud));
  out.ends_with = y["ends_with"].text(out.ends_with);
  constexpr std::size_t kLongestEnd = 8;
  if (out.ends_with.empty() || out.ends_with.size() > kLongestEnd)
    problems.error("bad-value", y["ends_with"].where(), "what ends a line has 1 to 8 characters",
                   "write such as ends_with: \"\\r\\n\"");
  return out;
}
}  // namespace

std::vector<StreamEntry> read_streams(const Yaml& yaml, Problems& problems) {
  std::vector<StreamEntry> out;
  if (!yaml.defined()) return out;
  if (!yaml.is_map()) {
    problems.error("bad-type", yaml.where(), "'streams' has no names of streams",
                   "write 'streams: {scanner: {connect: \"192.168.1.5:2000\"}}'");
    return out;
  }
  if (yaml.keys().size() > kMostStreams) {
    problems.error("too-many", yaml.where(),
                   "the cell has more than " + std::to_string(kMostStreams) + " streams",
                   "divide it into several cells");
    return out;
  }
  for (const std::string& name : yaml.keys())
    collect(problems, [&] { out.push_back(read_stream(name, yaml[name], problems)); });
  return out;
}

}  // namespace polyarm::cell
