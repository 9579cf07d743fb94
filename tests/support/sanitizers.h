// Whether this is the build under ASan and UBSan, several times slower: the longest runs are shorter there.
#pragma once

#define THIMBLE_UNDER_SANITIZERS 0
#if defined(__has_feature)  // clang's way of saying it
#if __has_feature(address_sanitizer)
#undef THIMBLE_UNDER_SANITIZERS
#define THIMBLE_UNDER_SANITIZERS 1
#endif
#elif defined(__SANITIZE_ADDRESS__)  // and GCC's
#undef THIMBLE_UNDER_SANITIZERS
#define THIMBLE_UNDER_SANITIZERS 1
#endif

namespace thimble::test {

inline constexpr bool kUnderSanitizers = THIMBLE_UNDER_SANITIZERS;

}  // namespace thimble::test
