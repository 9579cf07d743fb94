#include "host-tools/viewer/web_server.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <csignal>
#include <deque>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "host-tools/viewer/access.h"
#include "host-tools/viewer/page_files.h"

namespace thimble::host {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using Text = std::shared_ptr<const std::string>;

constexpr std::size_t kMostClients = 32;    // connections, of either kind
constexpr std::size_t kMostStrangers = 16;  // of them, those that have not shown the token where it is needed
constexpr std::size_t kMostEvents = 128;    // that wait for a client; one that is so far behind is let go
constexpr std::size_t kLongestRead = 64U << 10U;  // a message beyond it ends the connection
constexpr double kMessagesPerSecond = 200;        // of a page: three times what a hand needs
constexpr int kSendBuffer_bytes = 32 << 10;       // what lies in the kernel is old when it is read
constexpr auto kHttpTimeout = std::chrono::seconds(60);
constexpr auto kStrangerTimeout = std::chrono::seconds(5);
constexpr auto kBeat = std::chrono::seconds(2);  // a page that hears nothing for longer connects anew

constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

std::string make_token() {
  std::random_device random;  // the kernel's
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string token;
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t word = random();
    for (unsigned shift = 0; shift < 32; shift += 4) token += kDigits[word >> shift & 0xFU];
  }
  return token;
}

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

// Allows kMessagesPerSecond, and as many at once.
class Rate {
 public:
  [[nodiscard]] bool allows() {
    const Clock::time_point now = Clock::now();
    left_ = std::min(left_ + kMessagesPerSecond * std::chrono::duration<double>(now - last_).count(),
                     kMessagesPerSecond);
    last_ = now;
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }

 private:
  double left_ = kMessagesPerSecond;
  Clock::time_point last_ = Clock::now();
};

}  // namespace

// One thread runs everything in here but what the public functions post.
class WebServer::Impl {
 public:
  class Live;
  class Http;

  Impl(const WebOptions& options, WebHandlers web_handlers);
  void accept();
  void beat();
  void publish(const Text& text, bool is_state);

  std::size_t clients = 0;  // those that io still holds when it goes count themselves out
  net::io_context io{1};
  tcp::acceptor acceptor{io};
  net::signal_set signals{io};
  net::steady_timer beat_timer{io};
  WebHandlers handlers;
  std::string token = make_token();
  std::string cookie_name;
  bool guarded = false;  // not loopback: everything takes the token
  unsigned port = 0;
  std::string url;
  std::vector<std::weak_ptr<Live>> live;
  std::deque<std::weak_ptr<Http>> strangers;  // the oldest first; some have shown the token since

  // What a new page is told.
  std::optional<Json> last_hello;
  Text last_scene;
  ImageBytes image;
  Text last_state;
  bool up = true;
};

// A page's WebSocket.
class WebServer::Impl::Live : public std::enable_shared_from_this<Live> {
 public:
  Live(Impl* server, tcp::socket&& socket, bool may_control)
      : server_(server), stream_(std::move(socket)), may_control_(may_control) {
    ++server_->clients;
  }
  ~Live() { --server_->clients; }
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  void begin(const http::request<http::string_body>& request) {
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = std::chrono::seconds(10);
    timeout.idle_timeout = std::chrono::seconds(30);
    timeout.keep_alive_pings = true;
    stream_.set_option(timeout);
    stream_.read_message_max(kLongestRead);
    stream_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->server_->live.push_back(self);
      self->greet();
      self->read();
    });
  }

  void greet() {
    if (server_->last_hello) tell_hello(*server_->last_hello);
    if (server_->last_scene) tell(server_->last_scene);
    if (!server_->up) tell(std::make_shared<const std::string>(to_text(link_json(false))));
    if (server_->last_state) show(server_->last_state);
  }

  void tell_hello(Json hello) {
    hello["may_control"] = may_control_;
    tell(std::make_shared<const std::string>(to_text(hello)));
  }

  // In its turn, and surely.
  void tell(const Text& text) {
    if (events_.size() >= kMostEvents) {
      beast::get_lowest_layer(stream_).close();
      return;
    }
    events_.push_back(text);
    write();
  }

  // Only to a page that reads: others have something to read.
  void beat(const Text& text) {
    if (events_.empty()) tell(text);
  }

  // The newest, when there is time.
  void show(const Text& state) {
    state_ = state;
    write();
  }

 private:
  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return;
      self->hear();
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }

  void hear() {
    if (!rate_.allows()) {
      const Clock::time_point now = Clock::now();
      if (now - last_complaint_ < std::chrono::seconds(1)) return;
      last_complaint_ = now;
      complain({ExitCode::kRefused, "too-many-messages", "the page sends more than 200 messages a second",
                "they were passed over; reload the page"});
      return;
    }
    try {
      if (!stream_.got_text())
        throw Error(ExitCode::kUsage, "bad-message", "the page sent bytes instead of text",
                    "reload the page");
      PageMessage message = parse_page_message(beast::buffers_to_string(buffer_.data()));
      if (!may_control_) {
        throw Error(ExitCode::kPermission, "read-only", "this page may look, and change nothing",
                    "open the address that `thimble view` printed: it has the token");
      }
      server_->handlers.message(std::move(message));
    } catch (const Error& error) {
      complain(error);
    }
  }

  void complain(const Error& error) { tell(std::make_shared<const std::string>(to_text(event_json(error)))); }

  void write() {
    if (writing_) return;
    if (!events_.empty()) {
      writing_ = std::move(events_.front());
      events_.pop_front();
    } else {
      writing_ = std::move(state_);
      state_.reset();
    }
    if (!writing_) return;
    stream_.text(true);
    stream_.async_write(net::buffer(*writing_), [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return;
      self->writing_.reset();
      self->write();
    });
  }

  Impl* server_;
  websocket::stream<beast::tcp_stream> stream_;
  bool may_control_;
  beast::flat_buffer buffer_;
  Rate rate_;
  Clock::time_point last_complaint_{};
  Text writing_;
  std::deque<Text> events_;
  Text state_;
};

// A connection before it becomes a WebSocket, if it does.
class WebServer::Impl::Http : public std::enable_shared_from_this<Http> {
 public:
  Http(Impl* server, tcp::socket&& socket)
      : server_(server), stream_(std::move(socket)), known_(!server->guarded) {
    ++server_->clients;
  }
  ~Http() { --server_->clients; }
  Http(const Http&) = delete;
  Http& operator=(const Http&) = delete;

  void read() {
    constexpr std::uint32_t kMostHeader = 8U << 10U;
    constexpr std::uint64_t kMostBody = 1U << 10U;
    parser_.emplace();
    parser_->header_limit(kMostHeader);
    parser_->body_limit(kMostBody);
    if (known_) {
      stream_.expires_after(kHttpTimeout);
    } else {
      stream_.expires_after(kStrangerTimeout);
    }
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (!error) self->answer(self->parser_->release());
    });
  }

  [[nodiscard]] bool known() const { return known_; }
  void drop() { stream_.close(); }

 private:
  using Request = http::request<http::string_body>;
  using Response = http::response<http::span_body<const char>>;

  void answer(const Request& request) {
    const std::string_view host = view_of(request[http::field::host]);
    const Target target = parse_target(view_of(request.target()));
    const bool has_token = same_secret(target.token, server_->token);
    known_ = !server_->guarded || has_token ||
             same_secret(cookie(view_of(request[http::field::cookie]), server_->cookie_name), server_->token);
    if (!server_->guarded && !is_loopback_host(host, server_->port)) {
      refuse(request, http::status::forbidden, "This server is for this machine: ask for 127.0.0.1.\n");
    } else if (!is_own_origin(view_of(request[http::field::origin]), host)) {
      refuse(request, http::status::forbidden, "Another site's page may not come here.\n");
    } else if (!known_) {
      refuse(request, http::status::unauthorized,
             "A token is needed: open the address that `thimble view` printed.\n");
    } else if (websocket::is_upgrade(request)) {
      if (target.path != "/live") {
        refuse(request, http::status::not_found, "There is no such socket.\n");
        return;
      }
      stream_.expires_never();
      std::make_shared<Live>(server_, stream_.release_socket(), has_token)->begin(request);
    } else if (request.method() != http::verb::get && request.method() != http::verb::head) {
      refuse(request, http::status::method_not_allowed, "Only GET and HEAD.\n");
    } else {
      serve(request, target, has_token);
    }
  }

  void serve(const Request& request, const Target& target, bool has_token) {
    if (target.path == "/scene.thim") {
      if (!server_->image) {
        refuse(request, http::status::not_found, "The scene that runs is not known here.\n");
        return;
      }
      const std::vector<std::byte>& bytes = *server_->image;
      send(request, http::status::ok, "application/octet-stream",
           {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, server_->image);
    } else if (target.path == "/scenes.json") {
      const auto text = std::make_shared<const std::string>(to_text(server_->handlers.scenes()));
      send(request, http::status::ok, "application/json", *text, text);
    } else if (const PageFile* file = find_page_file(target.path)) {
      std::string set_cookie;
      // So that what the page loads itself has the token, too.
      if (server_->guarded && has_token)
        set_cookie = server_->cookie_name + "=" + server_->token + "; Path=/; HttpOnly; SameSite=Strict";
      send(request, http::status::ok, file->type, file->bytes, nullptr,
           target.path.starts_with("/assets/") ? "public, max-age=31536000, immutable" : "no-store",
           set_cookie);
    } else {
      refuse(request, http::status::not_found, "There is no such thing.\n");
    }
  }

  void refuse(const Request& request, http::status status, std::string_view why) {
    send(request, status, "text/plain; charset=utf-8", why, nullptr);
  }

  // owner: keeps the bytes; null where they stay.
  void send(const Request& request, http::status status, std::string_view type, std::string_view bytes,
            std::shared_ptr<const void> owner, std::string_view cache = "no-store",
            const std::string& set_cookie = {}) {
    owner_ = std::move(owner);
    response_.emplace(status, request.version());
    const auto set = [this](http::field field, std::string_view value) {
      response_->set(field, beast::string_view(value.data(), value.size()));
    };
    set(http::field::server, "thimble");
    set(http::field::content_type, type);
    set(http::field::cache_control, cache);
    response_->set("Content-Security-Policy", beast::string_view(kPolicy.data(), kPolicy.size()));
    response_->set("X-Content-Type-Options", "nosniff");
    response_->set("Referrer-Policy", "no-referrer");  // the address has the token
    response_->set("Cross-Origin-Resource-Policy", "same-origin");
    if (!set_cookie.empty()) set(http::field::set_cookie, set_cookie);
    const bool head = request.method() == http::verb::head;
    response_->body() =
        head ? boost::beast::span<const char>() : boost::beast::span<const char>(bytes.data(), bytes.size());
    response_->keep_alive(request.keep_alive());
    if (head) {
      response_->content_length(bytes.size());
    } else {
      response_->prepare_payload();
    }
    stream_.expires_after(kHttpTimeout);
    serializer_.emplace(*response_);
    const auto done = [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return;
      if (self->response_->need_eof()) {
        error_code ignored;
        self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        return;
      }
      self->owner_.reset();
      self->read();
    };
    if (head) {
      http::async_write_header(stream_, *serializer_, done);
    } else {
      http::async_write(stream_, *serializer_, done);
    }
  }

  Impl* server_;
  beast::tcp_stream stream_;
  bool known_;  // may be here: has shown the token, where it is needed
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<Response> response_;
  std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
  std::shared_ptr<const void> owner_;
};

WebServer::Impl::Impl(const WebOptions& options, WebHandlers web_handlers)
    : handlers(std::move(web_handlers)) {
  error_code error;
  const net::ip::address address = options.listen.empty() ? net::ip::address(net::ip::address_v4::loopback())
                                                          : net::ip::make_address(options.listen, error);
  if (error) {
    throw Error(ExitCode::kUsage, "bad-address", "'" + options.listen + "' is not an IP address",
                "--listen takes an address of this machine, or 0.0.0.0 for all");
  }
  guarded = !options.listen.empty();
  const tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  // Not into the browser that is started: it would keep the port.
  if (!error) fcntl(acceptor.native_handle(), F_SETFD, FD_CLOEXEC);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(net::socket_base::max_listen_connections, error);
  if (error) {
    const std::string cause = "cannot listen on " + address.to_string() + " port " +
                              std::to_string(options.port) + ": " + error.message();
    if (error == net::error::address_in_use) {
      throw Error(ExitCode::kRefused, "port-in-use", cause,
                  "end what uses it, choose another with --port, or leave --port out for any free one");
    }
    if (error == net::error::access_denied)
      throw Error(ExitCode::kPermission, "permission", cause, "choose a port above 1023");
    throw Error(ExitCode::kUsage, "cannot-listen", cause, "--listen takes an address of this machine");
  }
  port = acceptor.local_endpoint().port();
  cookie_name = "thimble-" + std::to_string(port);
  std::string host = address.to_string();
  if (address.is_unspecified()) {
    std::array<char, 256> name{};
    host = gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
  } else if (address.is_v6()) {
    host = "[" + host + "]";
  }
  url = "http://" + host + ":" + std::to_string(port) + "/?token=" + token;
}

void WebServer::Impl::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == net::error::operation_aborted) return;
    if (!error && clients < kMostClients) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      socket.set_option(net::socket_base::send_buffer_size(kSendBuffer_bytes), ignored);
      const auto client = std::make_shared<Http>(this, std::move(socket));
      if (!client->known()) {
        // Everyone begins as one of them. The oldest has had the longest time to show the token.
        std::erase_if(strangers, [](const std::weak_ptr<Http>& weak) {
          const auto stranger = weak.lock();
          return !stranger || stranger->known();
        });
        if (strangers.size() >= kMostStrangers) {
          if (const auto oldest = strangers.front().lock()) oldest->drop();
          strangers.pop_front();
        }
        strangers.push_back(client);
      }
      client->read();
    }
    if (!error) {
      accept();
      return;
    }
    // No descriptors left, say: not again at once.
    auto timer = std::make_shared<net::steady_timer>(io, std::chrono::milliseconds(100));
    timer->async_wait([this, timer](error_code) { accept(); });
  });
}

// So that a page can tell a server that has nothing to say from one that is not reached.
void WebServer::Impl::beat() {
  beat_timer.expires_after(kBeat);
  beat_timer.async_wait([this](error_code error) {
    if (error) return;
    const auto text = std::make_shared<const std::string>(to_text(link_json(up)));
    for (const auto& weak : live) {
      if (const auto page = weak.lock()) page->beat(text);
    }
    beat();
  });
}

void WebServer::Impl::publish(const Text& text, bool is_state) {
  std::erase_if(live, [](const std::weak_ptr<Live>& page) { return page.expired(); });
  for (const std::weak_ptr<Live>& weak : live) {
    if (const std::shared_ptr<Live> page = weak.lock()) is_state ? page->show(text) : page->tell(text);
  }
}

WebServer::WebServer(const WebOptions& options, WebHandlers handlers)
    : impl_(std::make_unique<Impl>(options, std::move(handlers))) {
  impl_->accept();
  impl_->beat();
}

WebServer::~WebServer() = default;

const std::string& WebServer::url() const { return impl_->url; }

void WebServer::take_signals() {
  impl_->signals.add(SIGINT);
  impl_->signals.add(SIGTERM);
  impl_->signals.add(SIGHUP);
  impl_->signals.async_wait([io = &impl_->io](error_code error, int) {
    if (!error) io->stop();
  });
}

void WebServer::run() {
  impl_->io.run();
  error_code ignored;
  impl_->signals.clear(ignored);  // a second Ctrl-C does not wait
}

void WebServer::stop() { impl_->io.stop(); }

void WebServer::hello(Json hello) {
  net::post(impl_->io, [impl = impl_.get(), hello = std::move(hello)]() mutable {
    impl->last_hello = std::move(hello);
    for (const auto& weak : impl->live) {
      if (const auto page = weak.lock()) page->tell_hello(*impl->last_hello);
    }
  });
}

void WebServer::scene(std::string scene, ImageBytes image) {
  net::post(impl_->io, [impl = impl_.get(), scene = std::make_shared<const std::string>(std::move(scene)),
                        image = std::move(image)]() mutable {
    impl->last_scene = scene;
    impl->image = std::move(image);
    impl->publish(scene, false);
  });
}

void WebServer::state(std::string state) {
  net::post(impl_->io, [impl = impl_.get(), state = std::make_shared<const std::string>(std::move(state))] {
    impl->last_state = state;
    impl->publish(state, true);
  });
}

void WebServer::event(const Json& event) {
  net::post(impl_->io, [impl = impl_.get(), text = std::make_shared<const std::string>(to_text(event))] {
    impl->publish(text, false);
  });
}

void WebServer::link(bool up) {
  net::post(impl_->io, [impl = impl_.get(), up] {
    impl->up = up;
    impl->publish(std::make_shared<const std::string>(to_text(link_json(up))), false);
  });
}

}  // namespace thimble::host
