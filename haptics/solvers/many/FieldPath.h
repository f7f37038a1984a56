#pragma once

#include "haptics/solvers/many/ManyFields.h"
#include "haptics/solvers/production/PhaseSearch.h"
#include "haptics/solvers/production/ShapedRounding.h"

#include <vector>

namespace midair::haptics
{

/// Solves successive fields of one path on the calling thread, for ManyFields.
class FieldPath
{
public:
    FieldPath(const TransducerArray& array, const Medium& medium, const ManyFieldsOptions& options);
    FieldPath(const FieldPath&) = delete; // _search refers to _tuning
    FieldPath& operator=(const FieldPath&) = delete;

    /// The next field is the first of path \a path.
    void begin(int path);
    /// Solves field \a field of \a all, valid ones. \a figures may be null. Throws InputError if a
    /// point is out of reach.
    void solve(const ManyPoints& all, int field, std::uint8_t* phases, ManyFieldsFigures* figures);

private:
    void assign(const ManyPoints& all, int field);
    void startPhases();
    void checkReach(int field) const;
    bool isShaped() const;
    void alignToLast();
    bool keepNear(float most);
    void correct();
    void round();
    void write(std::uint8_t* phases) const;
    ManyFieldsFigures measure();
    const QuietPoints& quiet() const { return _search.quiet(); }
    double phaseStep_rad() const { return ManyFields::phaseStepOf_rad(_array); }
    float levels() const { return static_cast<float>(_array.drive.phaseLevels); }
    // A difference of levels as the nearest one by whole turns.
    float wrapped(float difference) const;

    const ManyFieldsOptions _options;
    TransducerArray _array; // with ManyFields' levels
    const Medium _medium;
    GaussNewtonTuning _tuning;
    FieldProblem _field;
    PhaseSearch _search;
    GaussNewtonStep _step;
    ShapedRounding _rounding;
    Pace _pace; // without a deadline
    ControlPoints _points;
    std::vector<int> _active;          // 0 .. points - 1
    base::AlignedBuffer<float> _level; // of each lane, about -levels() / 2 .. levels() / 2
    base::AlignedBuffer<float> _last;  // of the last field
    int _path = 0;
    bool _isFirst = true;
};

} // namespace midair::haptics
