// How a host proves that it has the key of a board, without sending it: service 29 of ISO 14229-1 with a challenge and HMAC-SHA256
// (BearSSL, which allocates nothing and takes a time that does not depend on its data). Both ends of the link use this header; nothing
// can fail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::firmware::link {

inline constexpr std::size_t kKeyBytes = 32;
using Key = std::array<std::uint8_t, kKeyBytes>;
using Challenge = std::array<std::uint8_t, 32>;
using Proof = std::array<std::uint8_t, 32>;

// Service 29: sub-functions, and what the answers say.
enum class Authentication : std::uint8_t { kRequestChallenge = 0x05, kVerifyProof = 0x06 };
inline constexpr std::uint8_t kRequestAccepted = 0x00;
inline constexpr std::uint8_t kOwnershipVerified = 0x12;
// Of HMAC-SHA256, in both requests and answers: its object identifier 1.2.840.113549.2.9 in BER, filled up with 0.
inline constexpr std::array<std::uint8_t, 16> kAlgorithm = {0x06, 0x08, 0x2A, 0x86, 0x48,
                                                            0x86, 0xF7, 0x0D, 0x02, 0x09};

// Of the host with this address, for the board with this node number: HMAC-SHA256 of "thimble proof", node, address and challenge.
[[nodiscard]] Proof proof_of(const Key& key, std::uint8_t node, std::uint8_t address,
                             const Challenge& challenge) noexcept;

// A board's challenge number `count` since its start number `start`, asked for at `now`: HMAC-SHA256 of "thimble challenge" and these. So it
// needs no source of random numbers: without the key nobody can tell the next one, and one comes again only where start (16 bits, of the
// journal), count and microsecond are the same.
[[nodiscard]] Challenge challenge_of(const Key& key, std::uint32_t start, std::uint32_t count,
                                     std::uint64_t now) noexcept;

// In a time that does not depend on where they differ. False if their sizes differ.
[[nodiscard]] bool same(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) noexcept;

}  // namespace thimble::firmware::link
