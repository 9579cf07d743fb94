#include "host-tools/viewer/web_connections.h"

namespace thimble::host {
namespace {

constexpr std::size_t kMostEvents = 128;  // queued for a page; one that is further behind is disconnected
// A longer message ends the connection. Only a page that may control sends drafts.
constexpr std::size_t kLongestRead = 64U << 10U;
constexpr std::size_t kLongestDraft = kMostDraftMessageBytes + (64U << 10U);

}  // namespace

bool MessageRate::allows() {
  const Clock::time_point now = Clock::now();
  left_ = std::min(left_ + kMessagesPerSecond * std::chrono::duration<double>(now - last_).count(),
                   kMessagesPerSecond);
  last_ = now;
  if (left_ < 1) return false;
  left_ -= 1;
  return true;
}

void PageSocket::begin(const http::request<http::string_body>& request) {
  stream_.auto_fragment(
      false);  // of a hello, which is longer than a frame's default, too: a message is a frame
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = std::chrono::seconds(10);
  timeout.idle_timeout = std::chrono::seconds(30);
  timeout.keep_alive_pings = true;
  stream_.set_option(timeout);
  stream_.read_message_max(may_control_ ? kLongestDraft : kLongestRead);
  stream_.async_accept(request, [self = shared_from_this()](error_code error) {
    if (error) return;
    self->server_->pages.push_back(self);
    self->greet();
    self->read();
  });
}

void PageSocket::greet() {
  if (server_->last_hello) tell_hello(*server_->last_hello);
  if (server_->last_scene) tell(server_->last_scene);
  if (!server_->up) tell(std::make_shared<const std::string>(to_text(link_json(false))));
  if (server_->last_state) show(server_->last_state);
}

void PageSocket::tell_hello(Json hello) {
  hello["may_control"] = may_control_;
  tell(std::make_shared<const std::string>(to_text(hello)));
}

void PageSocket::tell(const Text& text) {
  if (events_.size() >= kMostEvents) {
    drop();
    return;
  }
  events_.push_back(text);
  write();
}

void PageSocket::beat(const Text& text) {
  if (events_.empty()) tell(text);
}

void PageSocket::show(const Text& state) {
  state_ = state;
  write();
}

void PageSocket::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return;
    self->hear();
    self->buffer_.consume(self->buffer_.size());
    self->read();
  });
}

// Anybody may stop, at any time.
bool PageSocket::hears_stop() {
  constexpr std::size_t kShort = 64;
  if (!stream_.got_text() || buffer_.size() > kShort) return false;
  try {
    const PageMessage message = parse_page_message(beast::buffers_to_string(buffer_.data()));
    const auto* command = std::get_if<CommandMessage>(&message);
    if (command == nullptr || command->verb != ViewCommand::kStop) return false;
    server_->handlers.message(message);
    return true;
  } catch (const Error&) {
    return false;
  }
}

void PageSocket::hear() {
  if (hears_stop()) return;
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
      throw Error(ExitCode::kUsage, "bad-message", "the page sent bytes instead of text", "reload the page");
    PageMessage message = parse_page_message(beast::buffers_to_string(buffer_.data()));
    if (!may_control_) {
      throw Error(ExitCode::kPermission, "read-only", "this page may look, and change nothing",
                  "open the address that the command printed: it has the token");
    }
    server_->handlers.message(std::move(message));
  } catch (const Error& error) {
    complain(error);
  }
}

void PageSocket::complain(const Error& error) {
  tell(std::make_shared<const std::string>(to_text(event_json(error))));
}

void PageSocket::write() {
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

}  // namespace thimble::host
