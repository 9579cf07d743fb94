// Access control of the viewer's server: decisions from headers and addresses, without I/O.
#pragma once

#include <string>
#include <string_view>

namespace thimble::host {

// What an address asks for: "/live?token=abc".
struct Target {
  std::string path;
  std::string token;
};
[[nodiscard]] Target parse_target(std::string_view target);

// In constant time: the time does not depend on where they differ.
[[nodiscard]] bool same_secret(std::string_view a, std::string_view b);

// "127.0.0.1:8000", "localhost:8000" or "[::1]:8000" with this port: a name that somebody's DNS turns into 127.0.0.1 is none.
[[nodiscard]] bool is_loopback_host(std::string_view host, unsigned port);

// A request without Origin is not from a browser; the Origin of a browser must be this server's own.
[[nodiscard]] bool is_own_origin(std::string_view origin, std::string_view host);

// The value of a cookie in a Cookie header; empty: none.
[[nodiscard]] std::string cookie(std::string_view header, std::string_view name);

}  // namespace thimble::host
