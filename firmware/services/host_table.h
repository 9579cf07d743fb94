// Which host has which place, and the address that belongs to it (link/host_address.h). A place is free again
// link::kHostTimeout_us after the last frame of its host, or when the host releases it.
//
// Who calls it: the router. No frames, no I/O. Nothing can fail but a claim while all places are taken.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/link/host_address.h"

namespace thimble::firmware {

class HostTable {
 public:
  static constexpr std::size_t kPlaces = link::kMaxHosts;

  struct Claimed {
    std::size_t place = 0;
    bool is_new = false;  // the place had another host, or none
  };

  // The place of this key, or a free one, with an address that nobody has; nothing when all are taken.
  [[nodiscard]] std::optional<Claimed> claim(std::uint64_t key, link::Micros now) noexcept;
  // The same for a tester, a host that claims no address: there is at most one, known by link::kTesterAddress.
  [[nodiscard]] std::optional<Claimed> tester(link::Micros now) noexcept;

  [[nodiscard]] std::optional<std::size_t> with_key(std::uint64_t key) const noexcept;
  [[nodiscard]] std::optional<std::size_t> with_address(std::uint8_t address) const noexcept;
  [[nodiscard]] std::uint8_t address(std::size_t place) const noexcept { return places_[place].address; }
  [[nodiscard]] std::uint64_t key(std::size_t place) const noexcept { return places_[place].key; }
  [[nodiscard]] bool taken(std::size_t place) const noexcept { return places_[place].address != 0; }

  void heard(std::size_t place, link::Micros now) noexcept { places_[place].heard_us = now; }
  [[nodiscard]] bool expired(std::size_t place, link::Micros now) const noexcept;
  void free(std::size_t place) noexcept { places_[place] = {}; }

 private:
  static constexpr std::uint64_t kNoKey = 0;

  struct Place {
    std::uint8_t address = 0;  // 0: free
    std::uint64_t key = kNoKey;
    link::Micros heard_us = 0;
  };

  [[nodiscard]] std::optional<std::size_t> free_place() const noexcept;
  [[nodiscard]] std::uint8_t next_address() noexcept;

  std::array<Place, kPlaces> places_;
  std::uint8_t last_address_ = link::kLastHostAddress;  // the one granted last: they are granted in turn
};

}  // namespace thimble::firmware
