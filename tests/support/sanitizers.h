// True in the build with ASan and UBSan, which is several times slower; the longest runs are shorter there.
#pragma once

#define THIMBLE_UNDER_SANITIZERS 0
#if defined(__has_feature)  // clang
#if __has_feature(address_sanitizer)
#undef THIMBLE_UNDER_SANITIZERS
#define THIMBLE_UNDER_SANITIZERS 1
#endif
#elif defined(__SANITIZE_ADDRESS__)  // GCC
#undef THIMBLE_UNDER_SANITIZERS
#define THIMBLE_UNDER_SANITIZERS 1
#endif

namespace thimble::test {

inline constexpr bool kUnderSanitizers = THIMBLE_UNDER_SANITIZERS;

}  // namespace thimble::test
