// An arm image for tests of what stores it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "firmware/link/crc32.h"
#include "firmware/store/arm_store.h"
#include "thimble_arm_schema/arm_generated.h"

namespace thimble::test {

// A lever of 0.1 m with a motor. `drive`: without, the image is refused (no_drive).
inline std::vector<std::byte> paddle_image(const std::string& name, bool drive = true,
                                           bool commissioned = true, float max_force_N = 3) {
  flatbuffers::FlatBufferBuilder builder;
  const std::array<float, 9> eye = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const arm::Mat3 unit{flatbuffers::span<const float, 9>(eye)};
  const arm::Encoder encoder(0, arm::EncoderKind::Quadrature, 32, 1, 4000, 10, 0);
  const arm::Drive amplifier(0, arm::DriveKind::AnalogCurrent, 1, 10, 0);
  const arm::Motor motor(0.05F, 1, 1e-3F, 1e-6F, 3, 0.1F, 5, 10, 20, 500, 100);
  const std::vector<arm::Joint> joints{arm::Joint(false, arm::Vec3(0, 0, 0), unit, arm::Vec3(0, 1, 0))};
  const std::vector<flatbuffers::Offset<arm::Axis>> axes{arm::CreateAxisDirect(
      builder, "lever", -1, 1, 0, &encoder, drive ? &amplifier : nullptr, drive ? &motor : nullptr)};
  const std::vector<float> one{1}, zero{0};
  const arm::Vec3 tip(0.1F, 0, 0);
  const auto chain = builder.CreateVectorOfStructs(joints);
  const auto root = arm::CreateArm(builder, builder.CreateString(name), &unit, arm::Platform::NONE, 0, chain,
                                   &tip, 1, builder.CreateVector(one), builder.CreateVector(zero),
                                   builder.CreateVector(axes), 0, 0, max_force_N, 10, 1000, 24, commissioned);
  arm::FinishArmBuffer(builder, root);
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {bytes.begin(), bytes.end()};
}

inline firmware::StoreStatus upload(firmware::ArmStore& store, std::size_t arm,
                                    const std::vector<std::byte>& image) {
  using firmware::StoreStatus;
  StoreStatus status = store.begin(arm, image.size(), firmware::crc32(image));
  for (std::size_t at = 0; status == StoreStatus::kOk && at < image.size(); at += 64)
    status = store.write(at, std::span(image).subspan(at, std::min<std::size_t>(64, image.size() - at)));
  if (status == StoreStatus::kOk) status = store.verify();
  if (status == StoreStatus::kOk) status = store.commit();
  return status;
}

}  // namespace thimble::test
