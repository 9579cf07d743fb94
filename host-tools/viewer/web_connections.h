// The connections of WebServer, one thread: HttpConnection answers requests for files and turns into a PageSocket when a page
// asks for a WebSocket. Used by web_server.cpp only.
#pragma once

// clang-format off
#include <utility>  // Asio of Boost 1.74 uses std::exchange and does not include it
// clang-format on
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/viewer/access.h"
#include "host-tools/viewer/web_server.h"

namespace thimble::host {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using Text = std::shared_ptr<const std::string>;

// What takes one of the server's places.
class Client {
 public:
  Client() = default;
  virtual ~Client() = default;
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  virtual void drop() = 0;
  // It has shown the token, or the cookie that those who have shown it get.
  [[nodiscard]] virtual bool is_owner() const = 0;
  [[nodiscard]] virtual bool is_page() const = 0;
};

class PageSocket;

// One thread runs all of it, except what the public functions of WebServer post.
class WebServerImpl {
 public:
  WebServerImpl(const WebOptions& options, WebHandlers web_handlers);
  void accept();
  void add(const std::shared_ptr<Client>& client);
  void beat();
  void publish(const Text& text, bool is_state);

  net::io_context io{1};
  tcp::acceptor acceptor{io};
  net::signal_set signals{io};
  net::steady_timer beat_timer{io};
  WebHandlers handlers;
  std::string token;
  // Shows that the token was shown, and gives no control: browsers send it to every port of this machine.
  std::string cookie_secret;
  std::string cookie_name;
  bool guarded = false;  // not loopback: every request needs the token
  unsigned port = 0;
  std::string url;
  std::vector<std::weak_ptr<PageSocket>> pages;
  std::deque<std::weak_ptr<Client>> places;  // the oldest first

  // What a new page is sent.
  std::optional<Json> last_hello;
  Text last_scene;
  ImageBytes image;
  Text recording;  // the last one
  Text last_state;
  bool up = true;
};

// Allows 200 messages a second, and a burst of as many: three times what a hand needs.
class MessageRate {
 public:
  [[nodiscard]] bool allows();

 private:
  static constexpr double kMessagesPerSecond = 200;
  double left_ = kMessagesPerSecond;
  Clock::time_point last_ = Clock::now();
};

// A page's WebSocket.
class PageSocket final : public Client, public std::enable_shared_from_this<PageSocket> {
 public:
  PageSocket(WebServerImpl* server, tcp::socket&& socket, bool may_control, bool is_owner)
      : server_(server), stream_(std::move(socket)), may_control_(may_control), is_owner_(is_owner) {}
  void drop() override { beast::get_lowest_layer(stream_).close(); }
  [[nodiscard]] bool is_owner() const override { return is_owner_; }
  [[nodiscard]] bool is_page() const override { return true; }

  void begin(const http::request<http::string_body>& request);
  void tell_hello(Json hello);
  // Queued, and guaranteed to be sent while the connection lasts. A page that is kMostEvents behind is disconnected.
  void tell(const Text& text);
  // Sent only if nothing else is queued.
  void beat(const Text& text);
  // Replaces a state that has not been sent yet.
  void show(const Text& state);

 private:
  void greet();
  void read();
  void hear();
  [[nodiscard]] bool hears_stop();
  void complain(const Error& error);
  void write();

  WebServerImpl* server_;
  websocket::stream<beast::tcp_stream> stream_;
  bool may_control_;
  bool is_owner_;
  beast::flat_buffer buffer_;
  MessageRate rate_;
  Clock::time_point last_complaint_{};
  Text writing_;
  std::deque<Text> events_;
  Text state_;
};

// A connection until it becomes a WebSocket, if it does.
class HttpConnection final : public Client, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(WebServerImpl* server, tcp::socket&& socket) : server_(server), stream_(std::move(socket)) {}
  void drop() override { stream_.close(); }
  [[nodiscard]] bool is_owner() const override { return is_owner_; }
  [[nodiscard]] bool is_page() const override { return false; }

  void read();

 private:
  using Request = http::request<http::string_body>;
  using Response = http::response<http::span_body<const char>>;

  void read_body();
  void answer(Request request);
  void take_file(const Request& request, const Target& target);
  [[nodiscard]] bool may_come(const Request& request) const;
  void serve(const Request& request, const Target& target, bool has_token);
  void refuse(const Request& request, http::status status, std::string_view why);
  // owner keeps the bytes alive; null for bytes that are static.
  void send(const Request& request, http::status status, std::string_view type, std::string_view bytes,
            std::shared_ptr<const void> owner, std::string_view cache = "no-store",
            const std::string& set_cookie = {});

  WebServerImpl* server_;
  beast::tcp_stream stream_;
  bool is_owner_ = false;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<Response> response_;
  std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
  std::shared_ptr<const void> owner_;
};

}  // namespace thimble::host
