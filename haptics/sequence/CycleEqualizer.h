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

/// How fields that are played in turn are made even; isValid() names the first setting that is out
/// of its range.
struct CycleEqualizerOptions
{
    int sweeps = 2; ///< >= 0; over all fields, each evened out with the others as they are then
    int corrections = 2; ///< >= 1; of LevenbergMarquardt for each field and sweep
    /// > 0; the mean radiation pressure to be kept, over that of the first field.
    double loudness = 1.0;

    bool isValid(std::string* error = nullptr) const;
};

/// Evens out the pressure that the skin feels, averaged over fields in turn, between the points
/// that each field is for. All K fields together are descended on
///     f = sum_l (1 - mean_k |p_l^k|^2 / s^2)^2
/// over dense points of the surface, one field after the other with what the others give there
/// (block coordinate descent). Phase-only: every transducer plays at full amplitude.
class CycleEqualizer
{
public:
    /// \a solver gives threads, pool and stop token. Throws base::InputError for options that are
    /// not valid.
    CycleEqualizer(const CycleEqualizerOptions& options, const SolverOptions& solver);

    /// Changes \a fields (K of m activations; silent ones stay silent), which end on the array's
    /// levels. \a surface (3 x n): where they are evened out, a third of a wavelength apart or
    /// closer; without points, or without a field that sounds there, nothing changes. Throws
    /// base::Stopped where the solver options' token asks for that.
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
