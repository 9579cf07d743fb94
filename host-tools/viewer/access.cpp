#include "host-tools/viewer/access.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace thimble::host {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

}  // namespace

Target parse_target(std::string_view target) {
  const std::size_t question = target.find('?');
  Target parsed{std::string(target.substr(0, question)), {}};
  if (question == std::string_view::npos) return parsed;
  std::string_view query = target.substr(question + 1);
  constexpr std::string_view kToken = "token=";
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    if (pair.starts_with(kToken)) parsed.token = pair.substr(kToken.size());
    query.remove_prefix(std::min(end + 1, query.size()));
  }
  return parsed;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs |= static_cast<unsigned>(static_cast<unsigned char>(a[i])) ^ static_cast<unsigned char>(b[i]);
  return differs == 0;
}

bool is_loopback_host(std::string_view host, unsigned port) {
  const std::string name = lower(host);
  const std::string with_port = ":" + std::to_string(port);
  for (const std::string own : {"127.0.0.1", "localhost", "[::1]"}) {
    if (name == own + with_port || (port == 80 && name == own)) return true;
  }
  return false;
}

bool is_own_origin(std::string_view origin, std::string_view host) {
  return origin.empty() || lower(origin) == "http://" + lower(host);
}

std::string cookie(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    if (pair.starts_with(name) && pair.size() > name.size() && pair[name.size()] == '=')
      return std::string(pair.substr(name.size() + 1));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return {};
}

}  // namespace thimble::host
