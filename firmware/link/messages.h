// The messages of messages.def as structs, with encoder, decoder and visitors over their fields, and the names of the
// numbers that travel.
//
// Who calls it: the controller encodes telemetry and records, the host decodes them. encode() and decode()
// are bounded by the number of fields; they fail only when the buffer is too short.
#pragma once

#include <algorithm>
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

inline constexpr std::uint16_t kProtocolVersion = 3;
inline constexpr std::uint16_t kImageVersion = 1;  // of control/scene/scene.fbs

// What messages have room for. A controller sends what its arms have.
inline constexpr std::size_t kMaxLinkArms = 4;
inline constexpr std::size_t kMaxJoints = 7;  // of an arm
inline constexpr std::size_t kMaxMotors = kMaxLinkArms * kMaxJoints;
inline constexpr std::size_t kClassicCounts = 3;   // of joints, in a RecordingCounts
inline constexpr std::size_t kFrozenJoints = 3;    // in a FreezeFrame: 64 of them fit in an answer
inline constexpr unsigned kRecordedTickBits = 11;  // of the number of a tick, in the frames of a recording
inline constexpr unsigned kSequenceBits = 4;       // of the count of telemetry records
inline constexpr unsigned kPictureBits = 6;        // of the count of pictures of the scene
inline constexpr std::size_t kHostNameBytes = 24;  // of the name of a host

namespace wire {
using u8 = std::uint8_t;
using u16 = std::uint16_t;
using u32 = std::uint32_t;
using i16 = std::int16_t;
using i32 = std::int32_t;
using f32 = float;

// The smallest unsigned type that holds so many bits.
template <unsigned kBits>
using Bits = std::conditional_t<(kBits <= 8), u8, std::conditional_t<(kBits <= 16), u16, u32>>;
}  // namespace wire

// ---------------------------------------------------------------------------------- the numbers that have names

// NOLINTBEGIN(bugprone-macro-parentheses): rows of messages.def give types and names, which stand without parentheses
#define ENUM(Type, description) enum class Type : std::uint8_t {
#define FLAG_SET(Type, description) enum Type : std::uint8_t {
#define VALUE(enumerator, number, name, description) enumerator = number,
#define END_ENUM(Type) \
  }                    \
  ;
#include "firmware/link/messages.def"

struct EnumRow {
  unsigned number;  // a mask in a FLAG_SET
  const char* name;
  const char* description;
};

// Of each ENUM and FLAG_SET: kName, kDescription, kIsFlagSet, kRows.
template <class Enum>
struct EnumTable;

#define ENUM(Type, description)                              \
  template <>                                                \
  struct EnumTable<Type> {                                   \
    static constexpr const char* kName = #Type;              \
    static constexpr const char* kDescription = description; \
    static constexpr bool kIsFlagSet = false;                \
    static constexpr EnumRow kRows[] = {
#define FLAG_SET(Type, description)                          \
  template <>                                                \
  struct EnumTable<Type> {                                   \
    static constexpr const char* kName = #Type;              \
    static constexpr const char* kDescription = description; \
    static constexpr bool kIsFlagSet = true;                 \
    static constexpr EnumRow kRows[] = {
#define VALUE(enumerator, number, name, description) {number, name, description},
#define END_ENUM(Type) \
  }                    \
  ;                    \
  }                    \
  ;
#include "firmware/link/messages.def"

template <class Enum>
concept TableEnum = requires {
  EnumTable<Enum>::kRows;
};

// "armed"; "unknown" for a number that the table does not have.
template <TableEnum Enum>
[[nodiscard]] constexpr const char* name(Enum value) noexcept {
  for (const EnumRow& row : EnumTable<Enum>::kRows)
    if (row.number == static_cast<unsigned>(value)) return row.name;
  return "unknown";
}

// False for a number that the table does not have.
template <TableEnum Enum>
[[nodiscard]] constexpr bool has_name(Enum value) noexcept {
  for (const EnumRow& row : EnumTable<Enum>::kRows)
    if (row.number == static_cast<unsigned>(value)) return true;
  return false;
}

// Calls visit(EnumTable<Type>{}) for every ENUM and FLAG_SET.
template <class Visit>
constexpr void visit_enums(Visit&& visit) {
#define ENUM(Type, description) visit(EnumTable<Type>{});
#define FLAG_SET(Type, description) visit(EnumTable<Type>{});
#define VALUE(enumerator, number, name, description)
#define END_ENUM(Type)
#include "firmware/link/messages.def"
}

// ------------------------------------------------------------------------------------------------- the structs

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
#define PART(Type, description)                              \
  struct Type {                                              \
    static constexpr bool kIsPart = true;                    \
    static constexpr const char* kName = #Type;              \
    static constexpr const char* kDescription = description; \
    friend bool operator==(const Type&, const Type&) = default;
#define FIELD(name, wire_type, type, scale, unit, description) type name{};
#define ARRAY(name, wire_type, type, count, scale, unit, description) std::array<type, count> name{};
#define BITS(name, bits, type, description) type name{};
#define BIT_ARRAY(name, bits, type, count, description) std::array<type, count> name{};
#define FLAGS(name, bits, Set, description) std::uint8_t name{};
#define NESTED(name, Type, description) Type name{};
#define SCALED_BITS(name, wire_type, bits, type, scale, unit, description) type name{};
#define SCALED_BIT_ARRAY(name, wire_type, bits, type, count, scale, unit, description) \
  std::array<type, count> name{};
#define SPARE(bits)
#define KIND(name, bits, Enum, enumerator)        \
  static constexpr Enum kKind = Enum::enumerator; \
  Enum name = kKind;
#define REST(bytes) static constexpr std::size_t kLeastBytes = bytes;
#define END(Type) \
  }               \
  ;
#include "firmware/link/messages.def"

// What the table says of a field besides its value.
template <class WireType, unsigned kWidth, class FlagSet = void, bool kMultiplexer = false>
struct Row {
  using Wire = WireType;
  static constexpr bool kIsKind = kMultiplexer;
  using Flags = FlagSet;                     // void: no flags
  static constexpr unsigned kBits = kWidth;  // of each one, where the field is an array
  const char* name;
  unsigned at;  // first bit, counted from bit 0 of byte 0
  float scale;
  const char* unit;
  const char* description;
};
// Of a NESTED part.
struct PartRow {
  const char* name;
  unsigned at;
  const char* description;
};

template <class Value>
inline constexpr bool kIsPart = requires {
  Value::kIsPart;
};
template <class Value>
inline constexpr bool kIsArray = false;
template <class Value, std::size_t kCount>
inline constexpr bool kIsArray<std::array<Value, kCount>> = true;

// Calls visit(row, value&) for every field of a message or part, in the order on the wire. `at`: its first bit. Returns the
// first bit behind it.
#define FRAME(Type, base_id, node, description)               \
  template <class Message, class Visit>                       \
  requires std::is_same_v<std::remove_const_t<Message>, Type> \
  constexpr unsigned visit_fields(Message& message, Visit&& visit, unsigned at = 0) {
#define RECORD(Type, did, description) FRAME(Type, did, false, description)
#define PART(Type, description) FRAME(Type, 0, false, description)
#define FIELD(name, wire_type, type, scale, unit, description)                                        \
  visit(Row<wire::wire_type, 8 * sizeof(wire::wire_type)>{#name, at, static_cast<float>(scale), unit, \
                                                          description},                               \
        message.name);                                                                                \
  at += 8 * sizeof(wire::wire_type);
#define ARRAY(name, wire_type, type, count, scale, unit, description)                                 \
  visit(Row<wire::wire_type, 8 * sizeof(wire::wire_type)>{#name, at, static_cast<float>(scale), unit, \
                                                          description},                               \
        message.name);                                                                                \
  at += 8 * sizeof(wire::wire_type) * (count);
#define BITS(name, bits, type, description)                                           \
  visit(Row<wire::Bits<bits>, bits>{#name, at, 1.0F, "", description}, message.name); \
  at += bits;
#define BIT_ARRAY(name, bits, type, count, description)                               \
  visit(Row<wire::Bits<bits>, bits>{#name, at, 1.0F, "", description}, message.name); \
  at += (bits) * (count);
#define FLAGS(name, bits, Set, description)                                                \
  visit(Row<wire::Bits<bits>, bits, Set>{#name, at, 1.0F, "", description}, message.name); \
  at += bits;
#define NESTED(name, Type, description)                 \
  visit(PartRow{#name, at, description}, message.name); \
  at = visit_fields(                                    \
      message.name, [](auto&&...) {}, at);
#define SCALED_BITS(name, wire_type, bits, type, scale, unit, description)                                  \
  visit(Row<wire::wire_type, bits>{#name, at, static_cast<float>(scale), unit, description}, message.name); \
  at += bits;
#define SCALED_BIT_ARRAY(name, wire_type, bits, type, count, scale, unit, description)                      \
  visit(Row<wire::wire_type, bits>{#name, at, static_cast<float>(scale), unit, description}, message.name); \
  at += (bits) * (count);
#define SPARE(bits) at += bits;
#define KIND(name, bits, Enum, enumerator)                                                           \
  visit(Row<wire::Bits<bits>, bits, void, true>{#name, at, 1.0F, "", "of the frame"}, message.name); \
  at += bits;
#define REST(bytes)
#define END(Type) \
  return at;      \
  }
#include "firmware/link/messages.def"

// Where a number stands within its message.
struct Place {
  const char* part = nullptr;  // the field that is a part, if it is in one
  int index = -1;              // in an array
};

// Calls visit(row, value&, place) for every single number of a message: what is in parts and arrays, one by one. row.at is
// its own first bit.
template <class Message, class Visit>
constexpr void visit_numbers(Message& message, Visit&& visit, unsigned at = 0, const char* part = nullptr) {
  visit_fields(
      message,
      [&visit, part](auto row, auto& value) {
        using Value = std::remove_cvref_t<decltype(value)>;
        if constexpr (kIsPart<Value>) {
          visit_numbers(value, visit, row.at, row.name);
        } else if constexpr (kIsArray<Value>) {
          int index = 0;
          for (auto& one : value) {
            visit(row, one, Place{part, index++});
            row.at += decltype(row)::kBits;
          }
        } else {
          visit(row, value, Place{part, -1});
        }
      },
      at);
}

// Calls visit(Type{}) for every message.
template <class Visit>
constexpr void visit_messages(Visit&& visit) {
#define FRAME(Type, base_id, node, description) visit(Type{});
#define RECORD(Type, did, description) visit(Type{});
#define PART(Type, description)
#define FIELD(name, wire_type, type, scale, unit, description)
#define ARRAY(name, wire_type, type, count, scale, unit, description)
#define BITS(name, bits, type, description)
#define BIT_ARRAY(name, bits, type, count, description)
#define FLAGS(name, bits, Set, description)
#define NESTED(name, Type, description)
#define SCALED_BITS(name, wire_type, bits, type, scale, unit, description)
#define SCALED_BIT_ARRAY(name, wire_type, bits, type, count, scale, unit, description)
#define SPARE(bits)
#define KIND(name, bits, Enum, enumerator)
#define REST(bytes)
#define END(Type)
#include "firmware/link/messages.def"
}
// NOLINTEND(bugprone-macro-parentheses)

// --------------------------------------------------------------------------------------------------- the codec

namespace wire {

template <unsigned kBits>
inline constexpr u32 kMask = kBits >= 32 ? ~u32{0} : (u32{1} << kBits) - 1;

// A float as the whole number that travels: rounded, and clamped to so many bits.
template <class Wire, unsigned kBits = 8 * sizeof(Wire)>
[[nodiscard]] Wire to_wire(float value, float scale) noexcept {
  constexpr unsigned kUnused = 8 * sizeof(Wire) - kBits;
  constexpr auto kMost = static_cast<Wire>(std::numeric_limits<Wire>::max() >> kUnused);
  constexpr auto kLeast = static_cast<Wire>(std::numeric_limits<Wire>::min() >> kUnused);
  // Not-a-number travels as 0: an integer on the wire has no word for it, and faults report it.
  const float scaled = std::nearbyint(value / scale);
  if (!(scaled == scaled)) return 0;
  if (scaled >= static_cast<float>(kMost)) return kMost;
  if (scaled <= static_cast<float>(kLeast)) return kLeast;
  return static_cast<Wire>(scaled);
}

template <class Wire>
[[nodiscard]] float from_wire(Wire value, float scale) noexcept {
  return static_cast<float>(value) * scale;
}

// The bits of a number, as they travel.
template <class Row, class Value>
[[nodiscard]] u32 to_bits(Value value, float scale) noexcept {
  using Wire = typename Row::Wire;
  if constexpr (std::is_same_v<Wire, float>) {
    return std::bit_cast<u32>(static_cast<float>(value));
  } else if constexpr (std::is_floating_point_v<Value>) {
    return static_cast<u32>(to_wire<Wire, Row::kBits>(static_cast<float>(value), scale)) & kMask<Row::kBits>;
  } else {
    return static_cast<u32>(value) & kMask<Row::kBits>;
  }
}

template <class Row, class Value>
[[nodiscard]] Value from_bits(u32 bits, float scale) noexcept {
  using Wire = typename Row::Wire;
  if constexpr (std::is_same_v<Wire, float>) {
    return std::bit_cast<float>(bits);
  } else if constexpr (std::is_floating_point_v<Value>) {
    constexpr unsigned kUnused = 8 * sizeof(Wire) - Row::kBits;  // shifted out again, with the sign
    return from_wire(static_cast<Wire>(static_cast<Wire>(bits << kUnused) >> kUnused), scale);
  } else {
    return static_cast<Value>(static_cast<Wire>(bits));
  }
}

// `out` is 0 where they are put.
inline void put_bits(std::span<u8> out, unsigned at, unsigned count, u32 bits) noexcept {
  while (count > 0) {
    const unsigned shift = at % 8, now = std::min(8 - shift, count);
    out[at / 8] = static_cast<u8>(out[at / 8] | (bits & ((1U << now) - 1)) << shift);
    bits = now < 32 ? bits >> now : 0;
    at += now;
    count -= now;
  }
}

[[nodiscard]] inline u32 get_bits(std::span<const u8> in, unsigned at, unsigned count) noexcept {
  u32 bits = 0;
  for (unsigned got = 0; got < count;) {
    const unsigned shift = (at + got) % 8, now = std::min(8 - shift, count - got);
    bits |= (static_cast<u32>(in[(at + got) / 8]) >> shift & ((1U << now) - 1)) << got;
    got += now;
  }
  return bits;
}

}  // namespace wire

// Bytes of a message on the wire.
template <class Message>
[[nodiscard]] constexpr std::size_t wire_size() noexcept {
  const Message message{};
  return (visit_fields(message, [](auto&&...) {}) + 7) / 8;
}

// Writes a message; returns the bytes written, or 0 when `out` is too short.
template <class Message>
[[nodiscard]] std::size_t encode(const Message& message, std::span<std::uint8_t> out) noexcept {
  constexpr std::size_t kSize = wire_size<Message>();
  if (out.size() < kSize) return 0;
  std::fill_n(out.begin(), kSize, std::uint8_t{0});
  visit_numbers(message, [&](auto row, const auto& value, Place) {
    wire::put_bits(out, row.at, row.kBits, wire::to_bits<decltype(row)>(value, row.scale));
  });
  return kSize;
}

// The bytes that a message has at least, without what may be left out.
template <class Message>
[[nodiscard]] constexpr std::size_t least_size() noexcept {
  if constexpr (requires { Message::kLeastBytes; }) {
    return Message::kLeastBytes;
  } else {
    return wire_size<Message>();
  }
}

// Reads a message; false when `in` is too short, or of another kind. Longer input is accepted: later versions append fields.
// What is left out (REST) is 0.
template <class Message>
[[nodiscard]] bool decode(std::span<const std::uint8_t> in, Message& message) noexcept {
  if (in.size() < least_size<Message>()) return false;
  if constexpr (requires { Message::kKind; }) {
    Message kind;
    bool other = false;
    visit_numbers(kind, [&](auto row, auto& value, Place) {
      if constexpr (decltype(row)::kIsKind)
        other = wire::get_bits(in, row.at, row.kBits) != static_cast<std::uint32_t>(value);
    });
    if (other) return false;
  }
  visit_numbers(message, [&](auto row, auto& value, Place) {
    using Value = std::remove_reference_t<decltype(value)>;
    const bool there = row.at + row.kBits <= 8 * in.size();
    value =
        wire::from_bits<decltype(row), Value>(there ? wire::get_bits(in, row.at, row.kBits) : 0, row.scale);
  });
  return true;
}

// A real-time frame, ready to send: a CAN FD frame where 8 bytes are too few for it.
template <class Message>
[[nodiscard]] CanFrame to_frame(const Message& message, std::uint8_t node) noexcept {
  constexpr std::size_t kSize = wire_size<Message>();
  static_assert(Message::kIsFrame && kSize <= kFdDataBytes);
  CanFrame frame;
  frame.id = Message::kId + (Message::kPerNode ? std::uint32_t{node} : 0U);
  static_cast<void>(encode(message, frame.data));
  frame.fd = kSize > kClassicDataBytes;
  frame.bit_rate_switch = frame.fd;
  frame.size = frame.fd ? fd_size(kSize) : static_cast<std::uint8_t>(kSize);
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
