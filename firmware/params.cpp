#include "firmware/params.h"

namespace thimble::firmware {
namespace {

constexpr std::size_t at(Param param) { return static_cast<std::size_t>(param); }

std::uint32_t to_bits(ParamType type, float value) {
  return type == ParamType::kFloat ? std::bit_cast<std::uint32_t>(value) : static_cast<std::uint32_t>(value);
}

}  // namespace

Params::Params() noexcept {
  for (std::size_t i = 0; i < kParamCount; ++i)
    bits_[i].set(to_bits(kParamTable[i].type, kParamTable[i].initial));
}

float Params::get(Param param) const noexcept {
  const std::uint32_t bits = bits_[at(param)].get();
  return kParamTable[at(param)].type == ParamType::kFloat ? std::bit_cast<float>(bits)
                                                          : static_cast<float>(bits);
}

std::uint32_t Params::get_unsigned(Param param) const noexcept { return bits_[at(param)].get(); }

ParamStatus Params::read(std::uint16_t id, std::uint32_t& bits) const noexcept {
  for (std::size_t i = 0; i < kParamCount; ++i) {
    if (kParamTable[i].id != id) continue;
    bits = bits_[i].get();
    return ParamStatus::kOk;
  }
  return ParamStatus::kUnknown;
}

ParamStatus Params::check(std::uint16_t id, std::uint32_t bits, bool at_rest) const noexcept {
  const ParamRow* row = find_param(id);
  if (row == nullptr) return ParamStatus::kUnknown;
  if (row->access == Access::kAtRest && !at_rest) return ParamStatus::kNotWhileArmed;
  const float value = row->type == ParamType::kFloat ? std::bit_cast<float>(bits) : static_cast<float>(bits);
  // Refuses NaN too.
  return value >= row->min && value <= row->max ? ParamStatus::kOk : ParamStatus::kOutOfRange;
}

ParamStatus Params::write(std::uint16_t id, std::uint32_t bits, bool at_rest) noexcept {
  const ParamStatus status = check(id, bits, at_rest);
  if (status == ParamStatus::kOk)
    bits_[static_cast<std::size_t>(find_param(id) - kParamTable.data())].set(bits);
  return status;
}

}  // namespace thimble::firmware
