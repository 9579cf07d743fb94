#include <cstdint>

#include "host-tools/viewer/page_files.h"
#include "host-tools/viewer/web_connections.h"

namespace thimble::host {
namespace {

constexpr std::uint64_t kMostBody = 1U << 10U;  // but of a file
constexpr std::string_view kFiles = "/files/";

constexpr auto kHttpTimeout = std::chrono::seconds(60);
constexpr auto kStrangerTimeout =
    std::chrono::seconds(5);  // for a request, from its first byte or none to its last

constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

void HttpConnection::read() {
  constexpr std::uint32_t kMostHeader = 8U << 10U;
  parser_.emplace();
  parser_->header_limit(kMostHeader);
  parser_->body_limit(kMostFileBytes);
  if (is_owner_) {
    stream_.expires_after(kHttpTimeout);
  } else {
    stream_.expires_after(kStrangerTimeout);
  }
  http::async_read_header(stream_, buffer_, *parser_,
                          [self = shared_from_this()](error_code error, std::size_t) {
                            if (!error) self->read_body();
                          });
}

// Only who has the token sends more than a few bytes.
void HttpConnection::read_body() {
  const Request& head = parser_->get();
  const Target target = parse_target(view_of(head.target()));
  const bool is_file = head.method() == http::verb::put && target.path.starts_with(kFiles) &&
                       may_come(head) && same_secret(target.token, server_->token);
  if (!is_file) {
    if (parser_->content_length().value_or(0) > kMostBody) return drop();
    parser_->body_limit(kMostBody);
  }
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (!error) self->answer(self->parser_->release());
  });
}

bool HttpConnection::may_come(const Request& request) const {
  const std::string_view host = view_of(request[http::field::host]);
  return (server_->guarded || is_loopback_host(host, server_->port)) &&
         is_own_origin(view_of(request[http::field::origin]), host);
}

void HttpConnection::take_file(const Request& request, const Target& target) {
  try {
    server_->handlers.message(file_message(std::string(target.path.substr(kFiles.size())), request.body()));
    send(request, http::status::ok, "text/plain; charset=utf-8", "", nullptr);
  } catch (const Error& error) {
    const auto text = std::make_shared<const std::string>(error.cause);
    send(request, http::status::bad_request, "text/plain; charset=utf-8", *text, text);
  }
}

void HttpConnection::answer(Request request) {
  const std::string_view host = view_of(request[http::field::host]);
  const Target target = parse_target(view_of(request.target()));
  const bool has_token = same_secret(target.token, server_->token);
  if (has_token || same_secret(cookie(view_of(request[http::field::cookie]), server_->cookie_name),
                               server_->cookie_secret))
    is_owner_ = true;
  if (!server_->guarded && !is_loopback_host(host, server_->port)) {
    refuse(request, http::status::forbidden, "This server is for this machine: ask for 127.0.0.1.\n");
  } else if (!is_own_origin(view_of(request[http::field::origin]), host)) {
    refuse(request, http::status::forbidden, "Another site's page may not come here.\n");
  } else if (server_->guarded && !is_owner_) {
    refuse(request, http::status::unauthorized,
           "A token is needed: open the address that the command printed.\n");
  } else if (websocket::is_upgrade(request)) {
    if (target.path != "/live") {
      refuse(request, http::status::not_found, "There is no such socket.\n");
      return;
    }
    stream_.expires_never();
    const auto page = std::make_shared<PageSocket>(server_, stream_.release_socket(), has_token, is_owner_);
    std::erase_if(server_->places,
                  [this](const std::weak_ptr<Client>& one) { return one.lock().get() == this; });
    server_->add(page);
    page->begin(request);
  } else if (request.method() == http::verb::put && target.path.starts_with(kFiles) && has_token) {
    take_file(request, target);
  } else if (request.method() != http::verb::get && request.method() != http::verb::head) {
    refuse(request, http::status::method_not_allowed, "Only GET and HEAD.\n");
  } else {
    serve(request, target, has_token);
  }
}

void HttpConnection::serve(const Request& request, const Target& target, bool has_token) {
  if (target.path == "/scene.thim") {
    if (!server_->image) {
      refuse(request, http::status::not_found, "The scene that runs is not known here.\n");
      return;
    }
    const std::vector<std::byte>& bytes = *server_->image;
    send(request, http::status::ok, "application/octet-stream",
         {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, server_->image);
  } else if (target.path == "/last.rec" && server_->recording) {
    send(request, http::status::ok, "application/octet-stream", *server_->recording, server_->recording);
  } else if (target.path == "/scenes.json") {
    const auto text = std::make_shared<const std::string>(to_text(server_->handlers.scenes()));
    send(request, http::status::ok, "application/json", *text, text);
  } else if (const PageFile* file = find_page_file(target.path)) {
    std::string set_cookie;
    // So that the files which the page loads come in the owner's places too.
    if (has_token)
      set_cookie =
          server_->cookie_name + "=" + server_->cookie_secret + "; Path=/; HttpOnly; SameSite=Strict";
    send(request, http::status::ok, file->type, file->bytes, nullptr,
         target.path.starts_with("/assets/") ? "public, max-age=31536000, immutable" : "no-store",
         set_cookie);
  } else {
    refuse(request, http::status::not_found, "There is no such thing.\n");
  }
}

void HttpConnection::refuse(const Request& request, http::status status, std::string_view why) {
  send(request, status, "text/plain; charset=utf-8", why, nullptr);
}

void HttpConnection::send(const Request& request, http::status status, std::string_view type,
                          std::string_view bytes, std::shared_ptr<const void> owner, std::string_view cache,
                          const std::string& set_cookie) {
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

}  // namespace thimble::host
