#pragma once

#include "haptics/base/simd/Kernel.h"

#include <cstdint>

/// The loops over transducers that take the time, each compiled for every instruction set and
/// chosen at run time, see haptics/base/simd. Each says how far it is from the exact result, and
/// for what. All pointers are aligned to 64 bytes, all widths multiples of kLanes; no kernel
/// allocates.
namespace midair::haptics::kernels
{

constexpr int kLanes = 32; ///< floats in two of the widest registers

/// Which variant this machine runs: "AVX-512", "AVX2", "x86-64", or "generic" without run-time
/// choice.
const char* isaName();

constexpr int kGroup = kLanes; ///< transducers about one centre

/// Transducers that stand close together: distances from a control point are expanded about their
/// centre.
struct GroupGeometry
{
    double x, y, z;   ///< centre, wavelengths
    float nx, ny, nz; ///< normal of them all if planar
    float radius;     ///< wavelengths
    float strongest;  ///< the largest |strength|
    bool planar;      ///< all have one normal and stand in one plane across it, as does the centre
};

/// Transducers of one block, lengths in wavelengths.
struct BlockGeometry
{
    const float *x, *y, *z;      ///< from the centre of the transducer's group
    const float* square;         ///< of that distance
    const float *nx, *ny, *nz;   ///< unit normals
    const float* strength;       ///< P0 gain_i / lambda, Pa
    const float* offset_turns;   ///< phase offset over 2 pi, or null
    const GroupGeometry* groups; ///< one for every kGroup transducers
    int width;
};

/// Control points whose rows are built together.
struct PointBatch
{
    static constexpr int kSize = 16;
    double x[kSize], y[kSize], z[kSize]; ///< wavelengths
    int row[kSize];                      ///< of the block's data
    int count;                           ///< 1 .. kSize
};

/// log2 D over theta, linear between multiples of ten degrees: its value at 0 and how its slope
/// changes at each of them.
struct DirectivityTable
{
    static constexpr int kSteps = 9;
    float largest; ///< D at most
    float start;
    float bend[kSteps]; ///< per ten degrees; bend[0] is the first slope
};

/// Coefficients of D as a cubic in cos(theta), clamped at 0.
struct DirectivityCubic
{
    float largest; ///< D at most, for cosines up to 1
    float c0, c1, c2, c3;
};

/// D = 1 in all directions.
struct DirectivityPoint
{
};

/// Where rows of a block go. FLOAT: row l is [re width][im width] at l * 2 * width. FIXED: 15 bits
/// and a sign of a bound of the row's entries, re (low) and im (high) in one lane, at l * width:
/// half of the memory, which is what a solve of many points waits for, at 2e-5 of the bound.
struct FloatRows
{
    float* entries;
};
struct FixedRows
{
    std::int32_t* entries;
    float* scale; ///< row by row: Pa a unit of the lane's numbers as the kernels read them
};

/// What a group and a point may be, so that the rows below are as exact as they say.
constexpr double kMostDecay = 1.0; ///< attenuation in Np a wavelength, times the distance
/// Wavelengths: groups of transducers farther apart lose more than 1e-5 of a turn in R - R0.
constexpr double kLargestRadius = 6.5;

/// Rows of one block of G, and sum_i |G_li| of each row into \a sums (a float a point, Pa). \a
/// decay is the attenuation in Np a wavelength, with decay R <= kMostDecay; no point is nearer to a
/// transducer than 1/4 wavelength, and no group is larger than kLargestRadius. An entry in float is
/// within 7e-5 + (decay radius)^3 / 6 of strength D.largest exp(-decay R) / R, for the largest
/// radius of a group; in fixed point 0.8 of scale * 65536 comes to that.
template<typename Model>
using BuildRows = base::Kernel<void(const BlockGeometry& block,
                                    const PointBatch& points,
                                    float decay,
                                    const Model& D,
                                    const FloatRows& rows,
                                    float* sums),
                               void(const BlockGeometry& block,
                                    const PointBatch& points,
                                    float decay,
                                    const Model& D,
                                    const FixedRows& rows,
                                    float* sums)>;

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
extern const BuildRows<DirectivityCubic> buildCubic;
extern const BuildRows<DirectivityTable> buildTable;
extern const BuildRows<DirectivityPoint> buildPoint;

/// 1/sqrt(x_i) to 2e-7 of itself for 1e-30 <= x_i <= 1e30; \a count a multiple of kLanes; the two
/// don't overlap. Estimates of AVX2 differ from maker to maker in their last bits, within that.
extern const base::Kernel<void(int count, const float* x, float* inverse)> inverseRoots;

/// A row that was computed otherwise into fixed point; returns its scale. Both parts of an entry
/// are within 1.6e-5 of the row's largest |part|; finite entries.
extern const base::Kernel<float(int width, const float* re, const float* im, std::int32_t* row)>
    packRow;

/// z = G* w over one block: z_i = sum_l conj(G_li) w_l, in float: within 2e-6 of sum_l |G_li w_l|,
/// n <= 1000. G: n rows of [re width][im width], or rows in fixed point of which row l times
/// scale_l is in Pa.
extern const base::Kernel<void(const float* G,
                               int n,
                               int width,
                               const float* wRe,
                               const float* wIm,
                               float* zRe,
                               float* zIm),
                          void(const std::int32_t* G,
                               const float* scale,
                               int n,
                               int width,
                               const float* wRe,
                               const float* wIm,
                               float* zRe,
                               float* zIm)>
    backward;

/// p += G q over one block: p_l is within 1e-5 of |p_l| + sum_i |G_li q_i|, width <= 512. In fixed
/// point what is read of an entry's imaginary part, the upper half, differs from it by up to half a
/// unit: 1.6e-5 of the row's bound times sum_i |q_i| more.
extern const base::Kernel<void(const float* G,
                               int n,
                               int width,
                               const float* qRe,
                               const float* qIm,
                               float* pRe,
                               float* pIm),
                          void(const std::int32_t* G,
                               const float* scale,
                               int n,
                               int width,
                               const float* qRe,
                               const float* qIm,
                               float* pRe,
                               float* pIm)>
    forward;

/// q_i = z_i / |z_i| to 3e-7 (1 where |z_i| <= 1e-18), and inverse_i = 1 / |z_i| to 3e-7 of itself
/// (0 there); |z_i| < 1e18.
extern const base::Kernel<void(
    int width, const float* zRe, const float* zIm, float* qRe, float* qIm, float* inverse)>
    projectToUnit;

/// out_i = exp(j 2 pi L_i / levels), L_i the multiple nearest to the phase of q_i; levels = 0:
/// out_i = q_i / |q_i|. Within 8e-7 of that; half-way between two levels, to 1e-6 of a turn, it may
/// be either. |q_i| >= 1e-30, or 0, whose phase is 0.
extern const base::Kernel<void(
    int width, int levels, const float* qRe, const float* qIm, float* outRe, float* outIm)>
    quantisePhase;

/// J_li = -Im(conj(u_l) G_li r_i) over one block, in the units of row l of G, r_i = q_i root_i with
/// |r_i| <= 1: how |p_l| changes with the phase of q_i. Two rows share a row of lanes, l (low) and
/// l + 1 (high), (n + 1)/2 rows of \a width. Within 3e-4 of the row's bound; width <= kMaxWidth.
extern const base::Kernel<void(const std::int32_t* G,
                               int n,
                               int width,
                               const float* uRe,
                               const float* uIm,
                               const float* rRe,
                               const float* rIm,
                               std::int32_t* J)>
    formJacobian;

/// t_i = sum_l J_li x_l over one block; n even. Of J as its lanes are read: within 2e-6 of sum_l
/// |J_li x_l|, n <= 1000.
extern const base::Kernel<void(const std::int32_t* J, int n, int width, const float* x, float* t)>
    transposedJacobian;

/// r_l += scale_l sum_i J_li t_i over one block; n even. Of J as its lanes are read: within 1e-5 of
/// |r_l| + scale_l sum_i |J_li t_i|, width <= 512.
extern const base::Kernel<void(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r)>
    applyJacobian;

/// q_i turned by root_i t_i, at most \a limit radians (<= 0.5): within 4e-7 of |q_i|.
extern const base::Kernel<void(
    int width, const float* root, const float* t, float limit, float* qRe, float* qIm)>
    turn;

/// How the drive \a q differs from \a before: sums over transducers.
struct DriveDifference
{
    float phaseSteps; ///< |arg(q_i conj(before_i))|, rad
    float change;     ///< |q_i - before_i|^2
    float power;      ///< |q_i|^2
};
/// Within 1e-5 of themselves for up to 4096 transducers; 2e-7 rad a transducer more for the steps,
/// and 1e-7 sqrt(change power) more for the change; |q_i| <= 1.
extern const base::Kernel<DriveDifference(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm)>
    compareDrives;

struct InnerProduct
{
    float re, im;
};
/// sum_i before_i conj(q_i), within 1e-5 of sum_i |before_i q_i| for up to 4096 transducers.
extern const base::Kernel<InnerProduct(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm)>
    innerProduct;

/// q_i times the complex number (re, im), or times the real number factor_i: within 2e-7 of the
/// product's size.
extern const base::Kernel<void(int width, float re, float im, float* qRe, float* qIm),
                          void(int width, const float* factor, float* qRe, float* qIm)>
    scaleBy;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
