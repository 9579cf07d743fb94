#include "board/sim/arm_image_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "board/files/text_file.h"
#include "firmware/arm/arm_image.h"
#include "firmware/link/crc32.h"

namespace thimble::board {
namespace {

// Why an arm image was refused, for people. The remedy is the same for all.
[[noreturn]] void refuse_arm(const std::string& name, const std::string& cause) {
  throw ArmImageError(name + ": " + cause,
                      "make it anew with `thimble model compile ARM --output " + name + '`');
}

// The image without the trailer that `thimble model compile` writes behind it (docs/cli.md). A flipped bit in a number gives another arm that no
// check of the numbers can tell, so a file without the trailer is refused.
std::span<const std::byte> without_trailer(const std::string& name, std::span<const std::byte> bytes) {
  constexpr std::string_view kTrailer = "CRC1";
  constexpr std::size_t kTrailerBytes = kTrailer.size() + sizeof(std::uint32_t);
  if (bytes.empty()) refuse_arm(name, "the file is empty");
  if (bytes.size() > firmware::kMaxArmImageBytes + kTrailerBytes)
    refuse_arm(name,
               "is no arm image: larger than " + std::to_string(firmware::kMaxArmImageBytes) + " bytes");
  const std::size_t size = bytes.size() - std::min(bytes.size(), kTrailerBytes);
  const std::span<const std::byte> trailer = bytes.subspan(size);
  if (trailer.size() < kTrailerBytes || std::memcmp(trailer.data(), kTrailer.data(), kTrailer.size()) != 0)
    refuse_arm(name, "is no arm image, or its end is missing: it does not end with CRC1 and a CRC-32");
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < sizeof crc; ++i)
    crc |= std::to_integer<std::uint32_t>(trailer[kTrailer.size() + i]) << (8U * i);
  if (firmware::link::crc32(bytes.first(size)) != crc)
    refuse_arm(name, "is damaged: its contents do not match its CRC-32");
  return bytes.first(size);
}

}  // namespace

std::optional<kinematics::ArmData> arm_of_image(const std::string& name) {
  if (!name.ends_with(".tarm")) return std::nullopt;
  const std::string bytes = read_text(name);
  std::vector<std::uint64_t> aligned(bytes.size() / 8 + 1);
  std::memcpy(aligned.data(), bytes.data(), bytes.size());
  const auto image = without_trailer(name, std::as_bytes(std::span(aligned)).first(bytes.size()));
  kinematics::ArmData arm;
  const firmware::ArmStatus status = firmware::read_arm_image(image, arm);
  if (status != firmware::ArmStatus::kOk)
    refuse_arm(name, std::string("is no arm image: ") + firmware::name(status));
  return arm;
}

}  // namespace thimble::board
