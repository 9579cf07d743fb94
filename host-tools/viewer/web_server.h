// The page side of a viewer: HTTP and WebSocket on one port, one thread. Serves the built-in page, and forwards the results of the
// device's thread.
//
// Who may do what:
//   on 127.0.0.1 (or ::1): anyone may look; a WebSocket with the token may control. Host must name this machine's loopback.
//   on another address: everything takes the token, or for looking the cookie that who has shown the token gets.
//   always: an Origin that is not this server is refused.
// Of 32 connections 16 are for those that have shown the token or have the cookie; of the others the oldest is dropped for a new one.
// A client that reads slowly misses states: at most one is queued, and the newest replaces it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host-tools/viewer/device_session.h"

namespace thimble::host {

struct WebOptions {
  std::string listen;      // an address; empty: loopback only
  std::uint16_t port = 0;  // 0: any free one
};

struct WebHandlers {
  std::function<void(PageMessage)>
      message;                   // of a page that may control; may throw Error, which the page gets
  std::function<Json()> scenes;  // what /scenes.json says
};

class WebServerImpl;  // web_connections.h

class WebServer final : public ViewSink {
 public:
  // Takes the port. Error: kRefused (in use), kPermission, kUsage (no address of this machine).
  WebServer(const WebOptions& options, WebHandlers handlers);
  ~WebServer() override;

  [[nodiscard]] const std::string& url() const;  // with the token

  void take_signals();  // from now on SIGINT, SIGTERM and SIGHUP end run(), and nothing else
  void run();           // until then, or stop()
  void stop();          // from any thread

  // From any thread.
  void hello(Json hello) override;
  void scene(std::string scene, ImageBytes image) override;
  void state(std::string state) override;
  void event(const Json& event) override;
  void link(bool up) override;
  void recording(const Json& about, std::shared_ptr<const std::string> file) override;

 private:
  std::unique_ptr<WebServerImpl> impl_;
};

}  // namespace thimble::host
