// A libm that rounds otherwise, for LD_PRELOAD (other_libm_test.py): a third of the calls of a function that is not exact return the
// neighbour of the usual result. What depends on it would be another image with another libm.
#include <dlfcn.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace {

unsigned calls = 0;

double nudged(double value) {
  static const char* const phase = std::getenv("OTHER_LIBM_PHASE");
  if (++calls % 3 != (phase != nullptr && *phase == '1' ? 1U : 0U)) return value;
  return std::nextafter(value, calls % 2 == 0 ? std::numeric_limits<double>::infinity() : -1.0e300);
}

// libm's own.
template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

// Shows the test that it is loaded, and what is called.
struct Told {
  ~Told() { std::fprintf(stderr, "other libm: %u calls\n", calls); }
} told;

}  // namespace

#define THIMBLE_ONE(name)                                                   \
  extern "C" __attribute__((visibility("default"))) double name(double x) { \
    static auto* const usual = real<double(double)>(#name);                 \
    return nudged(usual(x));                                                \
  }
#define THIMBLE_TWO(name)                                                             \
  extern "C" __attribute__((visibility("default"))) double name(double x, double y) { \
    static auto* const usual = real<double(double, double)>(#name);                   \
    return nudged(usual(x, y));                                                       \
  }

THIMBLE_ONE(sin)
THIMBLE_ONE(cos)
THIMBLE_ONE(tan)
THIMBLE_ONE(asin)
THIMBLE_ONE(acos)
THIMBLE_ONE(atan)
THIMBLE_ONE(exp)
THIMBLE_ONE(exp2)
THIMBLE_ONE(expm1)
THIMBLE_ONE(log)
THIMBLE_ONE(log2)
THIMBLE_ONE(log10)
THIMBLE_ONE(log1p)
THIMBLE_ONE(cbrt)
THIMBLE_ONE(sinh)
THIMBLE_ONE(cosh)
THIMBLE_ONE(tanh)
THIMBLE_TWO(atan2)
THIMBLE_TWO(pow)
THIMBLE_TWO(hypot)

extern "C" __attribute__((visibility("default"))) void sincos(double x, double* sine, double* cosine) {
  *sine = sin(x);
  *cosine = cos(x);
}
