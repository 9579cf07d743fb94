#include "firmware/services/host_table.h"

namespace thimble::firmware {

static_assert(link::kLastHostAddress - link::kFirstHostAddress >= link::kMaxHosts,
              "next_address() always finds one that is free");

std::optional<HostTable::Claimed> HostTable::claim(std::uint64_t key, link::Micros now) noexcept {
  std::optional<std::size_t> place = with_key(key);
  const bool is_new = !place;
  if (is_new) {
    place = free_place();
    if (!place) return std::nullopt;
    places_[*place] = {next_address(), key, now};
  }
  heard(*place, now);
  return Claimed{*place, is_new};
}

std::optional<HostTable::Claimed> HostTable::tester(link::Micros now) noexcept {
  std::optional<std::size_t> place = with_address(link::kTesterAddress);
  const bool is_new = !place;
  if (is_new) {
    place = free_place();
    if (!place) return std::nullopt;
    places_[*place] = {link::kTesterAddress, kNoKey, now};
  }
  heard(*place, now);
  return Claimed{*place, is_new};
}

std::optional<std::size_t> HostTable::with_key(std::uint64_t key) const noexcept {
  for (std::size_t i = 0; i < kPlaces; ++i)
    if (taken(i) && places_[i].key != kNoKey && places_[i].key == key) return i;
  return std::nullopt;
}

std::optional<std::size_t> HostTable::with_address(std::uint8_t address) const noexcept {
  for (std::size_t i = 0; i < kPlaces; ++i)
    if (taken(i) && places_[i].address == address) return i;
  return std::nullopt;
}

bool HostTable::expired(std::size_t place, link::Micros now) const noexcept {
  return taken(place) && now - places_[place].heard_us > link::kHostTimeout_us;
}

std::optional<std::size_t> HostTable::free_place() const noexcept {
  for (std::size_t i = 0; i < kPlaces; ++i)
    if (!taken(i)) return i;
  return std::nullopt;
}

std::uint8_t HostTable::next_address() noexcept {
  do {
    last_address_ = last_address_ == link::kLastHostAddress ? link::kFirstHostAddress
                                                            : static_cast<std::uint8_t>(last_address_ + 1);
  } while (with_address(last_address_));
  return last_address_;
}

}  // namespace thimble::firmware
