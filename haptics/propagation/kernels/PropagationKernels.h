#pragma once

#include "haptics/array/TransducerArray.h"

#include <cstdint>

/// The loops over transducers that take the time, each compiled for plain x86-64, AVX2 and AVX-512 and chosen at run
/// time. All pointers are aligned to 64 bytes, all widths multiples of kLanes; no kernel allocates.
namespace midair::haptics::kernels
{

constexpr int kLanes = 32; ///< floats in two of the widest registers

/// Which variant this machine runs: "AVX-512", "AVX2", "x86-64", or "generic" without run-time choice.
const char* isaName();

constexpr int kGroup = kLanes; ///< transducers about one centre

/// Transducers that stand close together: distances from a control point are expanded about their centre.
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

/// log2 D over theta, linear between multiples of ten degrees: its value at 0 and how its slope changes at each of them.
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

/// Where rows of a block go. FLOAT: row l is [re width][im width] at l * 2 * width. FIXED: 15 bits and a sign of a bound of
/// the row's entries, re (low) and im (high) in one lane, at l * width: half of the memory, which is what a solve of many
/// points waits for, at 2e-5 of the bound.
struct FloatRows
{
    float* entries;
};
struct FixedRows
{
    std::int32_t* entries;
    float*
        scale; ///< row by row: what the lane's numbers, as the kernels read them, are to be multiplied by to be Pa
};

/// Rows of one block of G, and sum_i |G_li| of each into \a sums; \a decay: beta lambda, with decay R <= kMostDecay.
void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FloatRows& rows,
                float* sums);
void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FixedRows& rows,
                float* sums);
void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FloatRows& rows,
                float* sums);
void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FixedRows& rows,
                float* sums);
void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const FloatRows& rows,
                float* sums);
void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const FixedRows& rows,
                float* sums);
/// 1/sqrt(x_i) to 2e-7, x_i > 0; \a count a multiple of kLanes. Estimates of AVX2 differ from maker to maker in their last bits,
/// within that.
void inverseRoots(int count, const float* x, float* inverse);
constexpr double kMostDecay = 1.0;
/// Wavelengths: groups of transducers farther apart lose more than 1e-5 of a turn in R - R0.
constexpr double kLargestRadius = 6.5;
/// A row that was computed otherwise into fixed point; returns its scale.
float packRow(int width, const float* re, const float* im, std::int32_t* row);

/// z = G* w over one block: z_i = sum_l conj(G_li) w_l. G: n rows of [re width][im width].
void backward(
    const float* G, int n, int width, const float* wRe, const float* wIm, float* zRe, float* zIm);
/// p += G q over one block.
void forward(
    const float* G, int n, int width, const float* qRe, const float* qIm, float* pRe, float* pIm);
/// The same two on rows in fixed point; row l times scale_l is in Pa.
void backward(const std::int32_t* G,
              const float* scale,
              int n,
              int width,
              const float* wRe,
              const float* wIm,
              float* zRe,
              float* zIm);
void forward(const std::int32_t* G,
             const float* scale,
             int n,
             int width,
             const float* qRe,
             const float* qIm,
             float* pRe,
             float* pIm);
/// q_i = z_i / |z_i| (1 where z_i = 0); inverse_i = 1 / |z_i| if wanted.
void projectToUnit(
    int width, const float* zRe, const float* zIm, float* qRe, float* qIm, float* inverse);

/// out_i = exp(j 2 pi L_i / levels), L_i the multiple nearest to the phase of q_i; levels = 0: out_i = q_i / |q_i|.
void quantisePhase(
    int width, int levels, const float* qRe, const float* qIm, float* outRe, float* outIm);

/// J_li = -Im(conj(u_l) G_li r_i) over one block, in the units of row l of G, r_i = q_i root_i with |r_i| <= 1: how |p_l|
/// changes with the phase of q_i. Two rows share a row of lanes, l (low) and l + 1 (high), (n + 1)/2 rows of \a width.
/// Within 3e-4 of the row's bound.
void formJacobian(const std::int32_t* G,
                  int n,
                  int width,
                  const float* uRe,
                  const float* uIm,
                  const float* rRe,
                  const float* rIm,
                  std::int32_t* J);
/// t_i = sum_l J_li x_l over one block; n even.
void transposedJacobian(const std::int32_t* J, int n, int width, const float* x, float* t);
/// r_l += scale_l sum_i J_li t_i over one block; n even.
void applyJacobian(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r);
/// q_i turned by root_i t_i, at most \a limit radians (<= 0.5).
void turn(int width, const float* root, const float* t, float limit, float* qRe, float* qIm);

/// How the drive \a q differs from \a before: sums over transducers.
struct DriveDifference
{
    float phaseSteps; ///< |arg(q_i conj(before_i))|, rad
    float change;     ///< |q_i - before_i|^2
    float power;      ///< |q_i|^2
};
DriveDifference compareDrives(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm);
/// sum_i before_i conj(q_i).
struct InnerProduct
{
    float re, im;
};
InnerProduct innerProduct(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm);
/// q_i times the complex number (re, im).
void multiply(int width, float re, float im, float* qRe, float* qIm);
/// q_i times the real number factor_i.
void scaleBy(int width, const float* factor, float* qRe, float* qIm);

} // namespace midair::haptics::kernels
