#pragma once

#include "haptics/solvers/production/QuietPoints.h"

#include <vector>

namespace midair::haptics
{

/// Rounds the last transducers of each block to the device's phase levels such that |p| stays at
/// the targets (SOLVER.md, "Rounding"): each in turn takes the level with the smallest total error.
/// This also removes errors from rounding the other transducers, from linearisation and from CG.
class ShapedRounding
{
public:
    /// Number of shaped transducers, and largest phase change from the correction's result.
    struct Effort
    {
        float share = 0.25f; ///< share of each block's transducers, 0 .. 1; less for many points
        int passes = 3;      ///< number of choices of each, >= 1
        float reach = 1.5f;  ///< levels
    };

    /// First shaped lane of block \a block, counted from the block's begin; the caller rounds those
    /// before it.
    static int first(const FieldProblem& field, int block, const Effort& effort);
    /// Largest difference of a level from the rounded phase, in whole levels.
    static float reach(const FieldProblem& field, const Effort& effort);

    /// Expects field.q with continuous phases for the lanes to shape, and its field.p, y and u;
    /// leaves them as played. The targets are \a s a_l, and errors are in the yards of \a quiet. \a
    /// amplitudes: |q_i| for each lane; null: all 1. field.drive().phaseLevels is not 0. Doesn't
    /// allocate after the first call for a size and effort.
    void shape(FieldProblem& field,
               const QuietPoints& quiet,
               const float* amplitudes,
               float s,
               const Effort& effort);

private:
    /// Shaped lanes of one block.
    struct Part
    {
        int lane = 0;  // first lane
        int count = 0; // lanes
        int place = 0; // index of its first lane in the vectors below
    };

    /// Shaped lanes.
    struct Lanes
    {
        int count = 0;
        base::AlignedBuffer<float> wanted; // in levels, as the next
        base::AlignedBuffer<float> level;
        base::AlignedBuffer<float> amplitude;
        SplitVector drive;
    };
    /// Rows of the equations.
    struct Rows
    {
        int stride = 0; // their number, rounded up; the length of each
        base::AlignedBuffer<float> error;
        base::AlignedBuffer<float> aim; // wanted |p|, in the columns' units
        SplitVector p;
    };
    /// Change of each row per turn of each lane: count x stride, in units of the level times the
    /// yards.
    struct Columns
    {
        base::AlignedBuffer<float> first;
        base::AlignedBuffer<float> second; // used for coarse levels only
        base::AlignedBuffer<float> square; // count, |first|^2
    };

    void reserve(const FieldProblem& field, const Effort& effort);
    void weigh(const FieldProblem& field, const QuietPoints& quiet);
    void findFactors(const FieldProblem& field, int thread, int block, float s, bool turned);
    void formColumns(const FieldProblem& field,
                     int thread,
                     int block,
                     const float* qRe,
                     const float* qIm,
                     base::AlignedBuffer<float>& columns);
    void chooseFine(FieldProblem& field, const QuietPoints& quiet, float s, const Effort& effort);
    void chooseCoarse(FieldProblem& field, const float* amplitudes, float s, const Effort& effort);
    void take(FieldProblem& field, int block, const float* amplitudes);

    std::vector<Part> _parts;
    Eigen::VectorXf _yard;   // n, units of errors
    std::vector<int> _twice; // points so quiet that rounding matters in the orthogonal direction,
                             // too
    Equations _equations;
    Lanes _lanes;
    Rows _rows;
    Columns _columns;
    SplitVector _factor; // threads x stride
    SplitVector _change; // m
};

} // namespace midair::haptics
