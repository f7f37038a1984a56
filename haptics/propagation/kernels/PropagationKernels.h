#pragma once

#include "haptics/base/simd/Kernel.h"

#include <cstdint>

/// Kernels that loop over transducers, compiled for each instruction set and selected at run time,
/// see haptics/base/simd. Each kernel's comment states its error bound and the input range for
/// which it holds. All pointers are aligned to 64 bytes, all widths multiples of kLanes. Kernels
/// don't allocate.
namespace midair::haptics::kernels
{

constexpr int kLanes = 32; ///< floats in two of the widest registers

constexpr int kGroup = kLanes; ///< transducers of one group

/// Adjacent transducers; distances from a control point are expanded about their centre.
struct GroupGeometry
{
    double x, y, z;   ///< centre, wavelengths
    float nx, ny, nz; ///< common normal, if planar
    float radius;     ///< wavelengths
    float strongest;  ///< the largest |strength|
    bool planar; ///< all have one normal and lie, with the centre, in one plane perpendicular to it
};

/// Transducers of one block, lengths in wavelengths.
struct BlockGeometry
{
    const float *x, *y, *z;      ///< position relative to the centre of the transducer's group
    const float* square;         ///< squared distance from that centre
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
    int row[kSize];                      ///< row in the block's data
    int count;                           ///< 1 .. kSize
};

/// log2 D as a function of theta, linear between multiples of ten degrees: value at 0 and change of
/// slope at each of them.
struct DirectivityTable
{
    static constexpr int kSteps = 9;
    float largest; ///< upper bound of D
    float start;
    float bend[kSteps]; ///< change of slope per ten degrees; bend[0] is the first slope
};

/// Coefficients of D as a cubic in cos(theta), clamped at 0.
struct DirectivityCubic
{
    float largest; ///< upper bound of D for cosines up to 1
    float c0, c1, c2, c3;
};

/// D = 1 in all directions.
struct DirectivityPoint
{
};

/// Destination of a block's rows. FLOAT: row l is [re width][im width] at l * 2 * width. FIXED: re
/// (low) and im (high) as 16-bit numbers in one lane, relative to a bound of the row's entries, at
/// l * width. FIXED halves the memory, whose bandwidth limits solves of many points, at an error of
/// 2e-5 of the bound.
struct FloatRows
{
    float* entries;
};
struct FixedRows
{
    std::int32_t* entries;
    float* scale; ///< for each row: Pa per unit of the numbers in its lanes as the kernels read
                  ///< them
};
/// FIXED with distances in single precision: in half of the time, less exactly.
struct QuickRows : FixedRows
{
};

// The error bounds below assume these limits.

/// Largest attenuation times distance, Np.
constexpr double kMostDecay = 1.0;
/// Largest radius of a group, wavelengths; in larger groups R - R0 has errors over 1e-5 of a turn.
constexpr double kLargestRadius = 6.5;

/// Computes rows of one block of G, and sum_i |G_li| of each row into \a sums (one float per point,
/// Pa). \a decay is the attenuation in Np per wavelength, with decay R <= kMostDecay; points are at
/// least 1/4 wavelength from every transducer, and groups at most kLargestRadius large. A float
/// entry is within 7e-5 + (decay radius)^3 / 6 of strength D.largest exp(-decay R) / R, for the
/// largest group radius; in fixed point the error is larger by up to 0.8 of scale * 65536.
/// QuickRows are within 1.5e-3 + 5e-6 R + (decay radius)^2 / 2 of it, R in wavelengths, plus 1.5 of
/// scale * 65536; strengths are not negative.
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
                                    float* sums),
                               void(const BlockGeometry& block,
                                    const PointBatch& points,
                                    float decay,
                                    const Model& D,
                                    const QuickRows& rows,
                                    float* sums)>;

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
extern const BuildRows<DirectivityCubic> buildCubic;
extern const BuildRows<DirectivityTable> buildTable;
extern const BuildRows<DirectivityPoint> buildPoint;

/// inverse_i = 1/sqrt(x_i) to a relative error of 2e-7 for 1e-30 <= x_i <= 1e30. \a count: a
/// multiple of kLanes; the arrays must not overlap. The last bits differ between processor makers
/// because AVX2's estimates do.
extern const base::Kernel<void(int count, const float* x, float* inverse)> inverseRoots;

/// Converts a row of finite entries to fixed point and returns its scale. Both parts of an entry
/// are within 1.6e-5 of the row's largest |part|.
extern const base::Kernel<float(int width, const float* re, const float* im, std::int32_t* row)>
    packRow;

/// z = G* w for one block: z_i = sum_l conj(G_li) w_l, in float: within 2e-6 of sum_l |G_li w_l|,
/// n <= 1000. G: n rows of [re width][im width], or rows in fixed point, with row l times scale_l
/// in Pa.
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

/// p += G q for one block: p_l is within 1e-5 of |p_l| + sum_i |G_li q_i|, width <= 512. In fixed
/// point the imaginary part, the upper half, is read with an error of up to half a unit, which adds
/// 1.6e-5 of the row's bound times sum_i |q_i|; it reads \a width lanes of rows \a stride lanes
/// apart.
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
                               int stride,
                               int width,
                               const float* qRe,
                               const float* qIm,
                               float* pRe,
                               float* pIm)>
    forward;

/// q_i = z_i / |z_i| to 3e-7 (1 where |z_i| <= 1e-18), and inverse_i = 1 / |z_i| to a relative
/// error of 3e-7 (0 where |z_i| <= 1e-18); |z_i| < 1e18.
extern const base::Kernel<void(
    int width, const float* zRe, const float* zIm, float* qRe, float* qIm, float* inverse)>
    projectToUnit;

/// out_i = exp(j 2 pi L_i / levels), with L_i nearest to the phase of q_i; levels = 0: out_i = q_i
/// / |q_i|. Error within 8e-7; within 1e-6 of a turn of the middle between two levels either may
/// result. |q_i| >= 1e-30, or 0, which has phase 0.
extern const base::Kernel<void(
    int width, int levels, const float* qRe, const float* qIm, float* outRe, float* outIm)>
    quantisePhase;

/// J_li = -Im(conj(u_l) G_li r_i) for one block, in the units of row l of G, with r_i = q_i root_i,
/// |r_i| <= 1: root_i times the derivative of |p_l| with respect to the phase of q_i. Two rows
/// share a row of lanes, l (low) and l + 1 (high), (n + 1)/2 rows of \a width. Within 3e-4 of the
/// row's bound; width <= kMaxWidth.
extern const base::Kernel<void(const std::int32_t* G,
                               int n,
                               int width,
                               const float* uRe,
                               const float* uIm,
                               const float* rRe,
                               const float* rIm,
                               std::int32_t* J)>
    formJacobian;

/// t_i = sum_l J_li x_l for one block; n even. With J as read from its lanes: within 1e-4
/// of sum_l |J_li| max |x|, n <= 1000.
extern const base::Kernel<void(const std::int32_t* J, int n, int width, const float* x, float* t)>
    transposedJacobian;

/// r_l += scale_l sum_i J_li t_i for one block; n even. With J as read from its lanes: within 1e-5
/// of |r_l| + scale_l sum_i |J_li t_i|, width <= 512.
extern const base::Kernel<void(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r)>
    applyJacobian;

/// Turns the phase of q_i by root_i t_i, limited to \a limit radians (<= 0.5); error within 4e-7 of
/// |q_i|.
extern const base::Kernel<void(
    int width, const float* root, const float* t, float limit, float* qRe, float* qIm)>
    turn;

/// Difference of the drive \a q from \a before, as sums over transducers.
struct DriveDifference
{
    float phaseSteps; ///< |arg(q_i conj(before_i))|, rad
    float change;     ///< |q_i - before_i|^2
    float power;      ///< |q_i|^2
};
/// Relative errors within 1e-5 for up to 4096 transducers; plus 2e-7 rad per transducer for the
/// steps, and 1e-7 sqrt(change power) for the change; |q_i| <= 1.
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

/// Multiplies q_i by the complex number (re, im), or by the real number factor_i; relative error
/// within 2e-7.
extern const base::Kernel<void(int width, float re, float im, float* qRe, float* qIm),
                          void(int width, const float* factor, float* qRe, float* qIm)>
    scaleBy;

/// Positions of \a count transducers as three arrays, and of a listener; metres.
struct HeardFrom
{
    const float *x, *y, *z;
    float at[3];
    float nearest; ///< smallest distance in the model
};
/// Multiplies G_i by exp(-(decay + j turn) R_i), R_i the distance; \a turn and \a decay in 1/m.
/// Error within 2e-6 of G_i for |turn R| <= 0.3 and |decay R| <= 0.015. No alignment needed.
extern const base::Kernel<void(
    int count, const HeardFrom& from, float turn, float decay, float* gRe, float* gIm)>
    turnByDistance;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
