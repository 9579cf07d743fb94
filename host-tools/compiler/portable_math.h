// Sine, cosine and arc tangent of which every machine gives the same bits: +, -, * and / of IEEE 754 alone. A libm may round these
// differently, as musl's does and glibc's, and a mesh's image would follow: where the normals of faces cancel, the last bit of an angle
// decides the sign of what remains. The compiler names no other function of libm that is not exact; compiler_test compares.
//
// Less than one unit of the last place off (compiler_test: against long double, over a million arguments).
#pragma once

namespace thimble::host::portable {

// |x| at most 1e4.
[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);

// The angle of the vector (x, y), -pi to pi; 0 or pi, with the sign of y, where y is 0. Each at most 1e150.
[[nodiscard]] double atan2(double y, double x);

}  // namespace thimble::host::portable
