// Whether this is the build under ASan and UBSan, several times slower: the longest runs are shorter there.
#pragma once

#if defined(__has_feature)  // clang's way of saying it
#define THIMBLE_UNDER_SANITIZERS __has_feature(address_sanitizer)
#elif defined(__SANITIZE_ADDRESS__)  // and GCC's
#define THIMBLE_UNDER_SANITIZERS 1
#else
#define THIMBLE_UNDER_SANITIZERS 0
#endif

namespace thimble::test {

inline constexpr bool kUnderSanitizers = THIMBLE_UNDER_SANITIZERS;

}  // namespace thimble::test
