#include "host-tools/arms/commissioned.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <span>

#include "firmware/link/crc32.h"

namespace thimble::host {

std::string commissioned_crc(nlohmann::json arm) {
  for (const char* key : {"$schema", "description", "source", kCommissionedKey}) arm.erase(key);
  const std::string text = arm.dump();
  return fmt::format("{:08x}", firmware::link::crc32(std::as_bytes(std::span(text))));
}

}  // namespace thimble::host
