// Whether this is the build under ASan and UBSan, several times slower: the longest runs are shorter there.
#pragma once

namespace thimble::test {

#if !defined(__has_feature)
#define THIMBLE_HAS_FEATURE(name) 0
#else
#define THIMBLE_HAS_FEATURE(name) __has_feature(name)
#endif
#if defined(__SANITIZE_ADDRESS__) || \
    THIMBLE_HAS_FEATURE(address_sanitizer)  // GCC's way of saying it, and clang's
inline constexpr bool kUnderSanitizers = true;
#else
inline constexpr bool kUnderSanitizers = false;
#endif
#undef THIMBLE_HAS_FEATURE

}  // namespace thimble::test
