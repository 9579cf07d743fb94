#include "firmware/link/proof.h"

#include <bearssl_hmac.h>

#include <string_view>

namespace thimble::firmware::link {
namespace {

class Hmac {
 public:
  Hmac(const Key& key, std::string_view purpose) noexcept {
    br_hmac_key_init(&key_, &br_sha256_vtable, key.data(), key.size());
    br_hmac_init(&context_, &key_, 0);
    br_hmac_update(&context_, purpose.data(), purpose.size());
  }
  void take(std::span<const std::uint8_t> bytes) noexcept {
    br_hmac_update(&context_, bytes.data(), bytes.size());
  }
  void take(std::uint64_t number) noexcept {
    std::array<std::uint8_t, 8> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(number >> (8 * i));
    take(bytes);
  }
  [[nodiscard]] std::array<std::uint8_t, br_sha256_SIZE> out() noexcept {
    std::array<std::uint8_t, br_sha256_SIZE> out{};
    br_hmac_out(&context_, out.data());
    return out;
  }

 private:
  br_hmac_key_context key_;
  br_hmac_context context_;
};

}  // namespace

Proof proof_of(const Key& key, std::uint8_t node, std::uint8_t address, const Challenge& challenge) noexcept {
  Hmac hmac(key, "thimble proof");
  hmac.take(std::array<std::uint8_t, 2>{node, address});
  hmac.take(challenge);
  return hmac.out();
}

Challenge challenge_of(const Key& key, std::uint32_t start, std::uint32_t count, std::uint64_t now) noexcept {
  Hmac hmac(key, "thimble challenge");
  hmac.take(start);
  hmac.take(count);
  hmac.take(now);
  return hmac.out();
}

bool same(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) noexcept {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) differs |= static_cast<unsigned>(a[i] ^ b[i]);
  return differs == 0;
}

}  // namespace thimble::firmware::link
