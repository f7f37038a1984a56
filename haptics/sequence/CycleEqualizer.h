#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/dense/LevenbergMarquardt.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Options of a CycleEqualizer.
struct CycleEqualizerOptions
{
    /// >= 0; passes over all fields, in which each field is corrected with the others fixed
    int sweeps = 2;
    int corrections = 2; ///< >= 1; LevenbergMarquardt corrections for each field and sweep
    /// > 0; mean radiation pressure to keep, relative to that of the first field.
    double loudness = 1.0;

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Makes the pressure on the skin, averaged over fields in turn, more uniform between the control
/// points. It minimises, over all K fields together,
///     f = sum_l (1 - mean_k |p_l^k|^2 / s^2)^2
/// over dense points of the surface, by block coordinate descent: one field after the other, with
/// the others fixed. Phase-only: every transducer plays at full amplitude.
class CycleEqualizer
{
public:
    /// Takes threads, pool and stop token from \a solver. Throws base::InputError for options that
    /// are not valid.
    CycleEqualizer(const CycleEqualizerOptions& options, const SolverOptions& solver);

    /// Changes \a fields (K of m activations; silent ones stay silent), which then are on the
    /// array's levels. \a surface (3 x n): points where the pressure is made uniform, a third of a
    /// wavelength apart or closer. Without points, or if all fields are silent there, nothing
    /// changes. Throws base::Stopped if the solver options' token requests it.
    void even(const Eigen::Matrix3Xd& surface,
              const TransducerArray& array,
              const Medium& medium,
              std::vector<Eigen::VectorXcf>& fields);

private:
    CycleEqualizerOptions _options;
    int _threads;
    base::StopToken _stop;
    FieldProblem _dense;
    LevenbergMarquardt _descent;
};

} // namespace midair::haptics
