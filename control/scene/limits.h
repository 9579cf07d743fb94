// The limits of the controller: named constants. The compiler refuses scenes that exceed them, and `thimble
// info` prints them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace thimble::control {

inline constexpr std::size_t kMaxArms = 2;
inline constexpr std::size_t kMaxObjects = 64;
inline constexpr std::size_t kMaxHeightSamples = 1U << 19U;  // of one height field: two triangles each
inline constexpr std::size_t kMaxTriangles = (1U << 20U) + (1U << 14U);  // of all meshes of a scene
inline constexpr std::size_t kMaxVertices = 1U << 20U;                   // of one mesh
inline constexpr std::size_t kMaxBodies = 16;                            // objects that move
inline constexpr std::size_t kMaxBodyContacts = 96;  // points where bodies touch something
inline constexpr std::size_t kMaxPieces = 16;        // convex, of a mesh that moves
inline constexpr std::size_t kMinPieceCorners = 4;
inline constexpr std::size_t kMaxPieceCorners = 128;          // of one piece
inline constexpr std::size_t kMaxTextureSamples = 1U << 16U;  // of one texture
inline constexpr std::size_t kMaxMapSamples = 1U << 16U;      // of one stiffness map
inline constexpr std::size_t kMaxVolumes = 16;                // objects that are volumes
inline constexpr std::size_t kMaxFieldSamples = 1U << 21U;    // of one potential field
inline constexpr std::size_t kMaxSubvolumes = 64;             // of one vector field
inline constexpr std::size_t kMaxSubvolumeSides = 16;
inline constexpr std::size_t kMaxLayers = 32;       // of one needle track
inline constexpr std::size_t kMaxCurvePoints = 32;  // of one control element
inline constexpr std::size_t kMaxImageBytes = std::size_t{64} << 20U;
inline constexpr std::size_t kMaxBvhDepth = 48;
inline constexpr std::size_t kMaxLeafTriangles = 8;
inline constexpr float kMaxStiffness_N_m = 1.0e5F;
inline constexpr float kMaxDamping_N_s_m = 1.0e3F;
inline constexpr float kMaxFriction = 10.0F;
inline constexpr float kMaxPotential = 1.0e3F;  // of a field's coefficient, m or J
inline constexpr float kMinFieldStep_m = 1.0e-5F;
inline constexpr float kMaxCoordinate_m = 10.0F;    // of any vertex, offset, size or pose
inline constexpr float kMaxTurn_rad = 100.0F;       // of a control element: its widest stops
inline constexpr float kMaxControlEffort = 100.0F;  // of a control element, N or N m
inline constexpr float kMinDetentPitch = 1.0e-4F;   // m or rad
// sqrt(stiffness / inertia) of a control element's own efforts: 0.25 rad in a tick at 4 kHz, stable down to
// 500 Hz.
inline constexpr float kMaxControlRate_rad_s = 1000.0F;
inline constexpr float kMaxFieldForce_N = 100.0F;  // of a force field, along each axis
inline constexpr std::size_t kMaxTrial = 255;      // of a force field
inline constexpr float kMaxTear_N = 100.0F;        // of a needle's layer: its tear strength and its friction
inline constexpr float kMaxViscosity_N_s_m2 = 1.0e4F;  // of a needle's layer
inline constexpr float kMinRelaxedShare = 1.0e-3F;     // of a tissue's stiffness, when held long
inline constexpr float kMinRecovery_s = 1.0e-3F;       // of a tissue's dimple
inline constexpr float kMaxRecovery_s = 3600.0F;
inline constexpr float kMinMass_kg = 1.0e-3F;  // of a body
inline constexpr float kMaxMass_kg = 1.0e3F;
inline constexpr float kMinInertia_kg_m2 = 1.0e-9F;
inline constexpr float kMaxInertia_kg_m2 = 1.0e6F;
inline constexpr float kMaxAngularDamping_N_m_s = 1.0e3F;
inline constexpr float kMaxBodySpeed_m_s = 10.0F;          // the speed is limited to this
inline constexpr float kMaxBodySpin_rad_s = 100.0F;        // at the start, and of a body that turns
inline constexpr float kMaxSmallBodySpin_rad_s = 1000.0F;  // of a free body that rolls
// K / m of a body with the stiffness K of its material: a mass on a spring is stable at the period T when K
// T^2 / m < 4, and two fingertips can press on it.
inline constexpr float kMaxStiffnessPerMass_1_s2 = 1.0e6F;
inline constexpr float kMaxClick_N = 20.0F;  // of an impact at 0.1 m/s
inline constexpr float kMinClickFrequency_Hz = 1.0F;
inline constexpr float kMaxClickFrequency_Hz = 1000.0F;
inline constexpr float kMinClickDecay_per_s = 1.0F;
inline constexpr float kMaxClickDecay_per_s = 1.0e4F;
inline constexpr float kMaxRelief_m = 0.01F;        // depth of a texture below the surface
inline constexpr float kMaxTextureGradient = 3.0F;  // of a mesh's coordinates for a texture, m/m
// Where several solids are near, the god object is a ball of this radius about a point above the surface, so that it
// cannot enter a gap narrower than twice as much. Far above the rounding of a coordinate (1e-6 m at 10 m).
inline constexpr float kPointRadius_m = 3.0e-5F;
inline constexpr float kFaceMargin_m = 1.0e-5F;    // level faces go on over gaps up to this width
inline constexpr float kMinTipRadius_m = 1.0e-4F;  // of fingertips that are no points
inline constexpr float kMaxTipRadius_m = 0.01F;    // of the fingertips: spheres, if it is not 0
inline constexpr float kMinSpacing_m = 1.0e-5F;    // of a texture's or a map's samples; encoders resolve 2e-5

}  // namespace thimble::control
