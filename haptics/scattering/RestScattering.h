#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/scattering/Scatterer.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// A held field at rest beside rigid plates.
struct FieldBesidePlates
{
    ControlPoints points;
    TransducerArray array; ///< the field was solved for it; plates are images in its rows
    TransducerArray heard; ///< the same with all reflectors, also those that aren't solved for
    std::vector<Reflector> plates; ///< those among its reflectors that are thin and rigid
    Medium medium;
    std::string solver;           ///< one of solverNames()
    SolverOptions options;        ///< the field's
    Eigen::VectorXcf multipliers; ///< HologramSolver::multipliers() of the field (n)
};

/// That field, solved for the full waves of the plates.
struct FieldForPlates
{
    Eigen::VectorXcf drive;  ///< m; empty: there is none, and why says why
    OutsideField outside;    ///< what the full waves add to those of FieldBesidePlates::heard
    SolveReport report;      ///< with the full waves
    double rmsBefore = 0.0;  ///< of the given field, with the full waves
    double highest_Pa = 0.0; ///< largest |p| at the points, with the full waves
    std::string why;
};

/// Solves fields at rest for the full waves of rigid plates (ThinScreen), of which rows know images
/// alone. Keeps the plates' matrices while they stay where
/// they are. One call at a time.
class RestScattering
{
public:
    /// Returns the rigid rectangles with ends among \a reflectors.
    static std::vector<Reflector> platesAmong(const std::vector<Reflector>& reflectors);
    /// Returns the number of cells of \a plates, which take about 0.5 kB each.
    static double cellsOf(const std::vector<Reflector>& plates, double wavelength_m);

    /// Starts from the multipliers of \a given, so that the new field is near it. Takes seconds for
    /// large plates. Throws InputError for plates with too many cells, Stopped.
    FieldForPlates solve(const FieldBesidePlates& given);

private:
    void makeScreens(const std::vector<Reflector>& plates, double wavelength_m);

    std::vector<Reflector> _plates; // of the screens
    double _wavelength_m = 0.0;     // of the screens
    std::vector<std::shared_ptr<const Scatterer>> _screens;
};

} // namespace midair::haptics
