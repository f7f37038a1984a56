#pragma once

#include "haptics/base/simd/Kernel.h"

#include <cstdint>

/// Kernels of shaped rounding (haptics/SOLVER.md, "Rounding"), compiled for each instruction set
/// and selected at run time. Kernels don't allocate. All pointers are aligned to 64 bytes.
namespace midair::haptics::kernels
{

constexpr int kShapingLanes = 16; ///< lanes and points are multiples of this
constexpr int kShapingGroup = 8;  ///< transducers that choose simultaneously

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
/// Columns of the Jacobian, one transducer after another: J[i * stride + l] = -Im(c_l G_li q_i) for
/// \a count transducers of a block and \a n points, zeros for l = n .. stride, and square_i = sum_l
/// J_il^2. G: fixed point, rows of \a width lanes, at the first transducer; c: conj(u_l) times the
/// factor on row l. \a count and \a stride: multiples of kShapingLanes; count <= kMaxWidth. |c| and
/// |q| <= 1: J is within 0.6 units of G's upper half plus 2e-6 of |c_l G_li q_i|.
extern const base::Kernel<void(const std::int32_t* G,
                               int n,
                               int width,
                               int count,
                               const float* cRe,
                               const float* cIm,
                               const float* qRe,
                               const float* qIm,
                               int stride,
                               float* J,
                               float* square)>
    jacobianColumns;

/// Moves each of \a count transducers once to the level that minimises |e|^2, where e_l + d J_li is
/// the error after phase i turns by d: level_i becomes the integer nearest to level_i -
/// (e.J_i)/(J_i.J_i)/step, limited to \a reach around wanted_i; e is updated. J and square: from
/// jacobianColumns; \a step: radians per level; wanted: phases in levels. kShapingGroup
/// transducers, count / kShapingGroup apart, choose simultaneously and independently: neighbours
/// are so similar that all would correct the same error. e is within 1e-5 of its largest value on
/// the way.
extern const base::Kernel<void(int count,
                               int stride,
                               const float* J,
                               const float* square,
                               float step,
                               float reach,
                               const float* wanted,
                               float* level,
                               float* e)>
    shapeLevels;

/// The same without linearisation, for coarse levels: among the levels at most \a reach from its
/// wanted one, transducer i takes the one that minimises sum_l (|p_l + g_li dq_i| - aim_l)^2. g:
/// columns of G in the units of p and aim (stride), one transducer after another, zero for padding,
/// where p and aim are 1; amplitude: |q_i|. q and p are updated, with relative errors of 1e-5.
extern const base::Kernel<void(int count,
                               int stride,
                               const float* gRe,
                               const float* gIm,
                               float levels,
                               int reach,
                               const float* amplitude,
                               const float* wanted,
                               float* level,
                               float* qRe,
                               float* qIm,
                               const float* aim,
                               float* pRe,
                               float* pIm)>
    shapeCoarseLevels;

/// Phases of q in levels: within 2e-7 * levels of arg(q_i) levels / (2 pi), -levels/2 .. levels/2.
extern const base::Kernel<void(
    int width, float levels, const float* qRe, const float* qIm, float* phase)>
    phaseInLevels;

/// q_i = exp(j 2 pi level_i / levels) to 8e-7, |level_i| <= levels.
extern const base::Kernel<void(int width, float levels, const float* level, float* qRe, float* qIm)>
    unitAtLevel;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
