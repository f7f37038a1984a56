#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/scattering/Scatterer.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/FlatFaces.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Rigid things beside an array whose images its rows may have.
struct RigidThings
{
    std::vector<Reflector> plates; ///< thin ones, of which plateOf() makes screens
    std::vector<ReflectingBody> bodies;
    std::vector<Reflector> faces; ///< of the bodies, that are among the array's reflectors

    bool isEmpty() const { return plates.empty() && bodies.empty(); }
    bool operator==(const RigidThings& other) const
    {
        return plates == other.plates && bodies == other.bodies && faces == other.faces;
    }
};

/// A held field at rest beside rigid things.
struct FieldBesideThings
{
    ControlPoints points;
    TransducerArray array; ///< the field was solved for it
    TransducerArray heard; ///< the same with all reflectors, also those that aren't solved for
    RigidThings things;
    Medium medium;
    std::string solver;           ///< one of solverNames()
    SolverOptions options;        ///< the field's
    Eigen::VectorXcf multipliers; ///< HologramSolver::multipliers() of the field (n)
};

/// That field, solved for the full waves of the things.
struct FieldForThings
{
    Eigen::VectorXcf drive;  ///< m; empty: there is none, and why says why
    OutsideField outside;    ///< what the full waves add to those of FieldBesideThings::heard
    SolveReport report;      ///< with the full waves
    double rmsBefore = 0.0;  ///< of the given field, with the full waves
    double highest_Pa = 0.0; ///< largest |p| at the points, with the full waves
    std::string why;
};

/// Solves fields at rest for the full waves of rigid plates (ThinScreen) and bodies (RigidBody), of
/// which rows know images at most. Keeps their matrices while they stay where they are. One call at
/// a time.
class RestScattering
{
public:
    /// Elements of things, and the memory that they take, to be told beforehand.
    struct Size
    {
        double elements = 0.0;
        double bytes = 0.0;
    };
    static Size sizeOf(const RigidThings& things, double wavelength_m);

    /// Starts from the multipliers of \a given, so that the new field is near it. Takes seconds for
    /// large plates, minutes for large bodies. Throws InputError for what can't be a ThinScreen or
    /// RigidBody and for more than 1.5 GB, Stopped.
    FieldForThings solve(const FieldBesideThings& given);

private:
    void make(const FieldBesideThings& given);

    RigidThings _things;        // of the scatterers
    double _wavelength_m = 0.0; // of the scatterers
    std::vector<std::shared_ptr<const Scatterer>> _scatterers;
};

} // namespace midair::haptics
