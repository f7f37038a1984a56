#pragma once

#include "haptics/solvers/production/QuietPoints.h"

#include <vector>

namespace midair::haptics
{

/// Rounds the last transducers of each block to the device's phase levels such that |p| stays at
/// the targets (SOLVER.md, "Rounding"): one after the other takes the level that leaves the least
/// error, which the next ones inherit. It also removes what rounding the other transducers, the
/// linearisation and CG left.
class ShapedRounding
{
public:
    /// How much is shaped, and how far a phase may go from where the correction put it.
    struct Effort
    {
        float share = 0.25f; ///< of each block's transducers, 0 .. 1; less if there are many points
        int passes = 3;      ///< times that each of them chooses, >= 1
        float reach = 1.5f;  ///< levels
    };

    /// The first lane of block \a block that is shaped, counted from the block's begin; those
    /// before it are rounded by the caller.
    static int first(const FieldProblem& field, int block, const Effort& effort);

    /// Expects field.q with continuous phases for the lanes to be shaped and field.p, y and u to
    /// belong to it; leaves them as they are played. The targets are \a s a_l, and errors count by
    /// the yards of \a quiet. \a amplitudes: |q_i| for each lane; null: all 1.
    /// field.drive().phaseLevels is not 0. Allocates nothing after the first call for a size and
    /// effort.
    void shape(FieldProblem& field,
               const QuietPoints& quiet,
               const float* amplitudes,
               float s,
               const Effort& effort);

private:
    /// What is shaped of one block.
    struct Part
    {
        int lane = 0;  // first lane
        int count = 0; // lanes
        int place = 0; // of its first lane in the vectors below
    };

    /// The lanes that are shaped.
    struct Lanes
    {
        int count = 0;
        base::AlignedBuffer<float> wanted; // in levels, as the next
        base::AlignedBuffer<float> level;
        base::AlignedBuffer<float> amplitude;
        SplitVector drive;
    };
    /// The rows of the equations.
    struct Rows
    {
        int stride = 0; // their number, rounded up; the length of each
        base::AlignedBuffer<float> error;
        base::AlignedBuffer<float> aim; // |p| wanted, in the columns' units
        SplitVector p;
    };
    /// What a turn of each lane changes in each row: count x stride, in units of the level times
    /// the yards.
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
    Eigen::VectorXf _yard;   // n, what errors count by
    std::vector<int> _twice; // points so quiet that rounding is felt at right angles, too
    Equations _equations;
    Lanes _lanes;
    Rows _rows;
    Columns _columns;
    SplitVector _factor; // threads x stride
    SplitVector _change; // m
};

} // namespace midair::haptics
