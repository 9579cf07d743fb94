// HTTP and WebSocket of the viewer, over a pair of sockets. The first byte says what goes before the bytes: nothing, or the request
// that makes a WebSocket of the connection, with the token or without. Only who has the token changes anything, anybody may stop, and a
// connection leaves nothing behind.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "board/posix/descriptor.h"
#include "host-tools/viewer/web_connections.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace thimble;

constexpr std::string_view kToken = "secret";

std::string upgrade(unsigned port, bool with_token) {
  std::string request = "GET /live";
  if (with_token) request.append("?token=").append(kToken);
  return request + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

struct Site {
  bool trusted = false;  // what is heard may come from one who has the token
  host::WebServerImpl server{{},
                             {[this](const host::PageMessage& message) {
                                const auto* command = std::get_if<host::CommandMessage>(&message);
                                const bool stop =
                                    command != nullptr && command->verb == host::ViewCommand::kStop;
                                fuzz::demand(trusted || stop, "who has no token changes nothing");
                              },
                              [] { return host::Json::array({"walls"}); }}};
  Site() {
    server.port = 8000;
    server.cookie_name = "thimble-8000";
    server.token = kToken;
    server.last_hello = host::Json::object({{"type", "hello"}});
    server.last_scene = std::make_shared<const std::string>("{\"type\":\"scene\"}");
    server.image = std::make_shared<const std::vector<std::byte>>(100);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Site site;
  if (size == 0) return 0;
  const unsigned kind = data[0];
  std::string bytes;
  if ((kind & 1U) != 0) bytes = upgrade(site.server.port, (kind & 2U) != 0);
  bytes.append(fuzz::text_of({data + 1, size - 1}));
  site.trusted = bytes.find(kToken) != std::string::npos;
  site.server.guarded = (kind & 4U) != 0;

  std::array<int, 2> ends{};
  fuzz::demand(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) == 0,
               "there is a pair of sockets");
  host::tcp::socket socket(site.server.io);
  socket.assign(host::tcp::v4(), ends[0]);
  {
    const auto connection = std::make_shared<host::HttpConnection>(&site.server, std::move(socket));
    site.server.add(connection);
    connection->read();
  }
  {
    const board::Descriptor page(ends[1]);
    const auto hear = [&] {
      std::array<char, 65536> answer{};
      std::size_t heard = 0;
      do {
        site.server.io.restart();
        heard = site.server.io.poll();
        for (ssize_t got = 1; got > 0;) {
          got = ::read(page.get(), answer.data(), answer.size());
          if (got > 0) ++heard;
        }
      } while (heard != 0);
    };
    for (std::string_view rest = bytes; !rest.empty();) {
      const ssize_t put = send(page.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
      if (put <= 0) break;  // it has closed the connection
      rest.remove_prefix(static_cast<std::size_t>(put));
      hear();
    }
    hear();
  }
  site.server.io.restart();
  while (site.server.io.poll() != 0) {
  }
  site.server.pages.clear();
  fuzz::demand(std::ranges::all_of(site.server.places, [](const auto& client) { return client.expired(); }),
               "a connection that has ended is gone");
  return 0;
}
