#include "host-tools/viewer/web_server.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <random>

#include "host-tools/viewer/web_connections.h"

namespace thimble::host {
namespace {

constexpr std::size_t kMostClients = 32;       // connections of either kind
constexpr std::ptrdiff_t kMostStrangers = 16;  // of them, those that have not shown the token
constexpr int kSendBuffer_bytes =
    32 << 10;  // small, because a state that waits in the kernel is old when it is read
constexpr auto kBeat = std::chrono::seconds(2);  // a page that hears nothing for longer connects anew

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

}  // namespace

WebServerImpl::WebServerImpl(const WebOptions& options, WebHandlers web_handlers)
    : handlers(std::move(web_handlers)), token(make_token()), cookie_secret(make_token()) {
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
  // The browser that is started must not inherit the port.
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

void WebServerImpl::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == net::error::operation_aborted) return;
    if (!error) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      socket.set_option(net::socket_base::send_buffer_size(kSendBuffer_bytes), ignored);
      const auto client = std::make_shared<HttpConnection>(this, std::move(socket));
      add(client);
      client->read();
      accept();
      return;
    }
    // For example no free descriptor: retry after a pause.
    auto timer = std::make_shared<net::steady_timer>(io, std::chrono::milliseconds(100));
    timer->async_wait([this, timer](error_code) { accept(); });
  });
}

// Every connection begins as a stranger, and the oldest stranger has had the longest time to show the token. Among the others, those that
// only fetch files can come again.
void WebServerImpl::add(const std::shared_ptr<Client>& client) {
  std::erase_if(places, [](const std::weak_ptr<Client>& weak) { return weak.expired(); });
  const auto is_stranger = [](const std::weak_ptr<Client>& weak) {
    const auto one = weak.lock();
    return one && !one->is_owner();
  };
  const auto fetches_files = [](const std::weak_ptr<Client>& weak) {
    const auto one = weak.lock();
    return one && !one->is_page();
  };
  auto last = places.end();
  if (std::ranges::count_if(places, is_stranger) >= kMostStrangers) {
    last = std::ranges::find_if(places, is_stranger);
  } else if (places.size() >= kMostClients) {
    last = std::ranges::find_if(places, fetches_files);
    if (last == places.end()) last = places.begin();
  }
  if (last != places.end()) {
    if (const auto one = last->lock()) one->drop();
    places.erase(last);
  }
  places.push_back(client);
}

// Lets a page distinguish a silent server from an unreachable one.
void WebServerImpl::beat() {
  beat_timer.expires_after(kBeat);
  beat_timer.async_wait([this](error_code error) {
    if (error) return;
    const auto text = std::make_shared<const std::string>(to_text(link_json(up)));
    for (const auto& weak : pages) {
      if (const auto page = weak.lock()) page->beat(text);
    }
    beat();
  });
}

void WebServerImpl::publish(const Text& text, bool is_state) {
  std::erase_if(pages, [](const std::weak_ptr<PageSocket>& page) { return page.expired(); });
  for (const std::weak_ptr<PageSocket>& weak : pages) {
    if (const std::shared_ptr<PageSocket> page = weak.lock()) is_state ? page->show(text) : page->tell(text);
  }
}

WebServer::WebServer(const WebOptions& options, WebHandlers handlers)
    : impl_(std::make_unique<WebServerImpl>(options, std::move(handlers))) {
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
    for (const auto& weak : impl->pages) {
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

void WebServer::recording(const Json& about, std::shared_ptr<const std::string> file) {
  net::post(impl_->io, [impl = impl_.get(), text = std::make_shared<const std::string>(to_text(about)),
                        file = std::move(file)]() mutable {
    impl->recording = std::move(file);
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
