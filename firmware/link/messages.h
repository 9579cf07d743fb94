// The messages of messages.def as structs, with encoder, decoder and a visitor over their fields.
//
// Who calls it: the controller encodes telemetry and records, the host decodes them. encode() and decode()
// are bounded by the number of fields; they fail only when the buffer is too short.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "firmware/link/can_frame.h"

namespace thimble::firmware::link {

inline constexpr std::uint16_t kProtocolVersion = 1;
inline constexpr std::uint16_t kImageVersion = 1;  // of control/scene/scene.fbs

namespace wire {
using u8 = std::uint8_t;
using u16 = std::uint16_t;
using u32 = std::uint32_t;
using i16 = std::int16_t;
using i32 = std::int32_t;
using f32 = float;
}  // namespace wire

#define FRAME(Type, base_id, node, description)              \
  struct Type {                                              \
    static constexpr const char* kName = #Type;              \
    static constexpr const char* kDescription = description; \
    static constexpr bool kIsFrame = true;                   \
    static constexpr bool kPerNode = node;                   \
    static constexpr std::uint16_t kId = base_id;
#define RECORD(Type, did, description)                       \
  struct Type {                                              \
    static constexpr const char* kName = #Type;              \
    static constexpr const char* kDescription = description; \
    static constexpr bool kIsFrame = false;                  \
    static constexpr bool kPerNode = false;                  \
    static constexpr std::uint16_t kId = did;
#define FIELD(name, wire_type, type, scale, unit, description) type name{};
#define END(Type) \
  }               \
  ;
#include "firmware/link/messages.def"
#undef FRAME
#undef RECORD
#undef FIELD
#undef END

// Calls visit(wire value type{}, name, value&, scale, unit, description) for every field of a message, in
// wire order.
#define FRAME(Type, base_id, node, description)               \
  template <class Message, class Visit>                       \
  requires std::is_same_v<std::remove_const_t<Message>, Type> \
  constexpr void visit_fields(Message& message, Visit&& visit) {
#define RECORD(Type, did, description) FRAME(Type, did, false, description)
#define FIELD(name, wire_type, type, scale, unit, description) \
  visit(wire::wire_type{}, #name, message.name, static_cast<float>(scale), unit, description);
#define END(Type) }
#include "firmware/link/messages.def"
#undef FRAME
#undef RECORD
#undef FIELD
#undef END

// Calls visit(Type{}) for every message.
// NOLINTBEGIN(bugprone-macro-parentheses): Type names a type
template <class Visit>
constexpr void visit_messages(Visit&& visit) {
#define FRAME(Type, base_id, node, description) visit(Type{});
#define RECORD(Type, did, description) visit(Type{});
#define FIELD(name, wire_type, type, scale, unit, description)
#define END(Type)
#include "firmware/link/messages.def"
#undef FRAME
#undef RECORD
#undef FIELD
#undef END
}
// NOLINTEND(bugprone-macro-parentheses)

namespace wire {

template <class Wire, class Value>
[[nodiscard]] Wire to_wire(Value value, float scale) noexcept {
  if constexpr (std::is_same_v<Wire, Value>) {
    return value;
  } else {
    // Not-a-number travels as 0: an integer on the wire has no word for it, and faults report it.
    const float scaled = std::nearbyint(static_cast<float>(value) / scale);
    if (!(scaled == scaled)) return 0;
    if (scaled >= static_cast<float>(std::numeric_limits<Wire>::max()))
      return std::numeric_limits<Wire>::max();
    if (scaled <= static_cast<float>(std::numeric_limits<Wire>::min()))
      return std::numeric_limits<Wire>::min();
    return static_cast<Wire>(scaled);
  }
}

template <class Value, class Wire>
[[nodiscard]] Value from_wire(Wire value, float scale) noexcept {
  if constexpr (std::is_same_v<Wire, Value>) {
    return value;
  } else {
    return static_cast<Value>(static_cast<float>(value) * scale);
  }
}

template <std::size_t kBytes>
using Unsigned = std::conditional_t<kBytes == 1, u8, std::conditional_t<kBytes == 2, u16, u32>>;

}  // namespace wire

// Bytes of a message on the wire.
template <class Message>
[[nodiscard]] constexpr std::size_t wire_size() noexcept {
  std::size_t size = 0;
  const Message message{};
  visit_fields(message, [&size](auto wire_value, auto&&...) { size += sizeof(wire_value); });
  return size;
}

// Writes a message; returns the bytes written, or 0 when `out` is too short.
template <class Message>
[[nodiscard]] std::size_t encode(const Message& message, std::span<std::uint8_t> out) noexcept {
  if (out.size() < wire_size<Message>()) return 0;
  std::size_t at = 0;
  visit_fields(message, [&](auto wire_value, const char*, const auto& value, float scale, auto&&...) {
    using Wire = decltype(wire_value);
    using Bits = wire::Unsigned<sizeof(Wire)>;
    const auto bits = std::bit_cast<Bits>(wire::to_wire<Wire>(value, scale));
    for (std::size_t i = 0; i < sizeof(Wire); ++i) out[at++] = static_cast<std::uint8_t>(bits >> (8U * i));
  });
  return at;
}

// Reads a message; false when `in` is too short. Longer input is accepted: later versions append fields.
template <class Message>
[[nodiscard]] bool decode(std::span<const std::uint8_t> in, Message& message) noexcept {
  if (in.size() < wire_size<Message>()) return false;
  std::size_t at = 0;
  visit_fields(message, [&](auto wire_value, const char*, auto& value, float scale, auto&&...) {
    using Wire = decltype(wire_value);
    using Bits = wire::Unsigned<sizeof(Wire)>;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < sizeof(Wire); ++i) bits |= static_cast<std::uint32_t>(in[at++]) << (8U * i);
    value = wire::from_wire<std::remove_reference_t<decltype(value)>>(
        std::bit_cast<Wire>(static_cast<Bits>(bits)), scale);
  });
  return true;
}

// A real-time frame, ready to send.
template <class Message>
[[nodiscard]] CanFrame to_frame(const Message& message, std::uint8_t node) noexcept {
  static_assert(Message::kIsFrame && wire_size<Message>() <= kClassicDataBytes);
  CanFrame frame;
  frame.id = Message::kId + (Message::kPerNode ? std::uint32_t{node} : 0U);
  frame.size = static_cast<std::uint8_t>(encode(message, frame.data));
  return frame;
}

// True, and `message` set, when the frame is this message from this node.
template <class Message>
[[nodiscard]] bool from_frame(const CanFrame& frame, std::uint8_t node, Message& message) noexcept {
  static_assert(Message::kIsFrame);
  if (frame.extended || frame.remote) return false;
  if (frame.id != Message::kId + (Message::kPerNode ? std::uint32_t{node} : 0U)) return false;
  return decode(frame.bytes(), message);
}

}  // namespace thimble::firmware::link
