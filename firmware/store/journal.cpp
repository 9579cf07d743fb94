#include "firmware/store/journal.h"

#include <algorithm>
#include <cmath>

namespace thimble::firmware {
namespace {

// Little-endian words between number and CRC: time, flags with crashes and starts, three times scene and parameters, heat (two bytes each).
constexpr std::size_t kHeatAt = 36;
// Three places an arm. The motors of an arm with more share the last one, which has the hottest of them: stored heat is never less than it is.
constexpr std::size_t kPlaces = 3;
static_assert(kHeatAt + 2 * 2 * kPlaces * kMaxArms == kRecordCrcAt);
constexpr std::uint32_t kMotorsOn = 1, kOnTrial = 2;
constexpr float kPerKelvin = 64;  // of a stored temperature: up to 1023 K
constexpr float kMostHeat = 65535;

// Never less than it is.
std::uint32_t stored(float kelvin) noexcept {
  return static_cast<std::uint32_t>(std::clamp(std::ceil(kelvin * kPerKelvin), 0.0F, kMostHeat));
}
float kelvin_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  return static_cast<float>(word_at(bytes, at, 2)) / kPerKelvin;
}

void put_in_use(RecordBytes& bytes, std::size_t at, const JournalRecord::InUse& used) noexcept {
  put_word(bytes, at, used.scene);
  put_word(bytes, at + 4, used.params);
}
JournalRecord::InUse in_use_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  return {word_at(bytes, at), word_at(bytes, at + 4)};
}

RecordBytes encode(const JournalRecord& record) noexcept {
  RecordBytes bytes{};
  put_word(bytes, 4, record.utc_s);
  put_word(bytes, 8,
           (record.motors_on ? kMotorsOn : 0) | (record.on_trial ? kOnTrial : 0) |
               static_cast<std::uint32_t>(record.crashes) << 8U |
               static_cast<std::uint32_t>(record.starts) << 16U);
  put_in_use(bytes, 12, record.used);
  put_in_use(bytes, 20, record.set_aside);
  put_in_use(bytes, 28, record.proven);
  std::size_t at = kHeatAt;
  for (const auto& arm : record.heat) {
    std::array<Heat, kPlaces> places{};
    for (std::size_t j = 0; j < arm.size(); ++j) {
      Heat& place = places[std::min(j, kPlaces - 1)];
      place.winding_K = std::max(place.winding_K, arm[j].winding_K);
      place.housing_K = std::max(place.housing_K, arm[j].housing_K);
    }
    for (const Heat& place : places) {
      put_word(bytes, at, stored(place.winding_K), 2);
      put_word(bytes, at + 2, stored(place.housing_K), 2);
      at += 4;
    }
  }
  return bytes;
}

JournalRecord decode(std::span<const std::byte> bytes) noexcept {
  JournalRecord record;
  record.utc_s = word_at(bytes, 4);
  const std::uint32_t flags = word_at(bytes, 8);
  record.motors_on = (flags & kMotorsOn) != 0;
  record.on_trial = (flags & kOnTrial) != 0;
  record.crashes = static_cast<std::uint8_t>(flags >> 8U);
  record.starts = static_cast<std::uint16_t>(flags >> 16U);
  record.used = in_use_at(bytes, 12);
  record.set_aside = in_use_at(bytes, 20);
  record.proven = in_use_at(bytes, 28);
  std::size_t at = kHeatAt;
  for (auto& arm : record.heat) {
    for (std::size_t j = 0; j < arm.size(); ++j) {
      const std::size_t place = at + 4 * std::min(j, kPlaces - 1);
      arm[j] = {kelvin_at(bytes, place), kelvin_at(bytes, place + 2)};
    }
    at += 4 * kPlaces;
  }
  return record;
}

}  // namespace

std::optional<JournalRecord> Journal::open() noexcept {
  const std::span<const std::byte> newest = slots_.open();
  return newest.empty() ? std::nullopt : std::optional(decode(newest));
}

bool Journal::append(const JournalRecord& record) noexcept {
  RecordBytes bytes = encode(record);
  return slots_.append(bytes);
}

}  // namespace thimble::firmware
