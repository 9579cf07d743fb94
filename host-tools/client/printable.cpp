#include "host-tools/client/printable.h"

#include <cstddef>

namespace thimble::host {

std::string printable(std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto before = static_cast<unsigned char>(i == 0 ? 0 : text[i - 1]);
    const bool c1 = byte >= 0x80 && byte < 0xA0 && before == 0xC2;
    if (c1 || byte == 0x7F || (byte < 0x20 && byte != '\n' && byte != '\t')) {
      if (c1) shown.pop_back();
      shown += {'\\', 'x', kHex[byte >> 4U], kHex[byte & 0xFU]};
    } else {
      shown += text[i];
    }
  }
  return shown;
}

}  // namespace thimble::host
