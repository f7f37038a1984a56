#pragma once

#include "haptics/TransducerArray.h"

#include <cstdint>

/// The loops over transducers that take the time, each compiled for plain x86-64, AVX2 and AVX-512 and chosen at run
/// time. All pointers are aligned to 64 bytes, all widths multiples of kLanes; no kernel allocates.
namespace midair::haptics::kernels
{

constexpr int kLanes = 16; ///< floats in the widest register

/// Which variant this machine runs: "AVX-512", "AVX2", "x86-64", or "generic" without run-time choice.
const char* isaName();

/// Transducers of one block, lengths in wavelengths. A coordinate is split into hi, a multiple of 1/32, and a rest lo of at
/// most 1/64, so that differences and squares of the hi parts are exact in float.
struct BlockGeometry
{
    const float *xHi, *yHi, *zHi;
    const float *xLo, *yLo, *zLo;
    const float *nx, *ny, *nz; ///< unit normals
    const float* strength;     ///< P0 gain_i / lambda, Pa
    const float* offset_turns; ///< phase offset over 2 pi, or null
    int width;
};

/// One control point, and the attenuation expanded about a distance in the middle of the array.
struct PointSetup
{
    float xHi, yHi, zHi;
    float xLo, yLo, zLo;
    float middle;         ///< distance in wavelengths about which exp(-beta R) is expanded
    float attenuation[4]; ///< exp(-beta R) as a cubic in middle - R
};

/// log2 D over theta, linear between multiples of ten degrees: its value at 0 and how its slope changes at each of them.
struct DirectivityTable
{
    static constexpr int kSteps = 9;
    float start;
    float bend[kSteps]; ///< per ten degrees; bend[0] is the first slope
};

/// Coefficients of D as a cubic in cos(theta), clamped at 0.
struct DirectivityCubic
{
    float c0, c1, c2, c3;
};

/// One row of one block of G into \a re and \a im; returns sum_i |G_li|.
float buildCubic(const BlockGeometry& block,
                 const PointSetup& point,
                 const DirectivityCubic& D,
                 float* re,
                 float* im);
float buildTable(const BlockGeometry& block,
                 const PointSetup& point,
                 const DirectivityTable& D,
                 float* re,
                 float* im);
float buildPoint(const BlockGeometry& block, const PointSetup& point, float* re, float* im);

/// z = G* w over one block: z_i = sum_l conj(G_li) w_l. G: n rows of [re width][im width].
void backward(
    const float* G, int n, int width, const float* wRe, const float* wIm, float* zRe, float* zIm);
/// p += G q over one block.
void forward(
    const float* G, int n, int width, const float* qRe, const float* qIm, float* pRe, float* pIm);
/// q_i = z_i / |z_i| (1 where z_i = 0); inverse_i = 1 / |z_i| if wanted.
void projectToUnit(
    int width, const float* zRe, const float* zIm, float* qRe, float* qIm, float* inverse);

/// out_i = exp(j 2 pi L_i / levels), L_i the multiple nearest to the phase of q_i; levels = 0: out_i = q_i / |q_i|.
void quantisePhase(
    int width, int levels, const float* qRe, const float* qIm, float* outRe, float* outIm);

/// J_li = -scale_l Im(conj(u_l) G_li q_i) root_i over one block, n rows of \a width floats: how |p_l| changes with the phase of
/// q_i, in units of 1/scale_l and 1/root_i.
void formJacobian(const float* G,
                  int n,
                  int width,
                  const float* uRe,
                  const float* uIm,
                  const float* scale,
                  const float* qRe,
                  const float* qIm,
                  const float* root,
                  float* J);
/// t_i = sum_l J_li x_l over one block.
void transposedJacobian(const float* J, int n, int width, const float* x, float* t);
/// r_l += sum_i J_li t_i over one block.
void applyJacobian(const float* J, int n, int width, const float* t, float* r);
/// q_i turned by root_i t_i, at most \a limit radians (<= 0.5).
void turn(int width, const float* root, const float* t, float limit, float* qRe, float* qIm);

/// How the drive \a q differs from \a before: sums over transducers.
struct DriveDifference
{
    float phaseSteps;       ///< |arg(q_i conj(before_i))|, rad
    float change;           ///< |q_i - before_i|^2
    float power;            ///< |q_i|^2
    float innerRe, innerIm; ///< before_i conj(q_i)
};
DriveDifference compareDrives(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm);
/// q_i times the complex number (re, im).
void multiply(int width, float re, float im, float* qRe, float* qIm);
/// q_i times the real number factor_i.
void scaleBy(int width, const float* factor, float* qRe, float* qIm);

} // namespace midair::haptics::kernels
