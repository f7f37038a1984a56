#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <complex>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Solver of a program's own: control points in, activations out. Derive from it and register it by
/// a name. What it finds is checked, rounded to the device's levels, capped and measured.
class FieldMethod
{
public:
    /// What is asked for, in the array's frame; valid during solve() only.
    struct Problem
    {
        unsigned int points = 0;           ///< n, at least 1
        unsigned int transducers = 0;      ///< m
        const double* positions = nullptr; ///< 3 n: x, y, z of each point, m
        /// n, all above 0: the peak pressure wanted, Pa if isAbsolute, else only the ratios count
        const double* targets = nullptr;
        bool isAbsolute = false;
        /// n x m, row by row: peak pressure in Pa at the point that the transducer alone gives at
        /// full drive and phase 0; zeros of dead ones. For activations q the pressures are G q.
        const std::complex<float>* matrix = nullptr;
        double loudness = 1.0;    ///< see haptics::SolverSettings
        bool phaseOnly = true;    ///< all |q| are to be equal
        int maxIterations = 0;    ///< 0: the solver's own limit
        double deadline_ms = 0.0; ///< 0: none
        /// Returns true when nobody waits for the field any more; return false then soon.
        std::function<bool()> isStopped;
    };

    virtual ~FieldMethod() = default;

    /// Finds \a activations, m, zeros when it is called: |q| = 1 is full drive. Returns false, with
    /// the reason in \a error, if there is no field; nothing is played then. One call at a time,
    /// on any thread.
    virtual bool
    solve(const Problem& problem, std::complex<float>* activations, std::string& error) = 0;
};

/// Makes a solver; null counts as a solver that has no field.
using FieldMethodFactory = std::function<std::shared_ptr<FieldMethod>()>;

/// Registers the name \a name, 1 .. 32 small letters, digits and dashes, for the rest of the
/// program. Returns false, with the reason in \a error, if it has another form or is taken. From
/// any thread.
bool registerMethod(const std::string& name, FieldMethodFactory make, std::string& error);

/// Returns the names that were registered. From any thread.
std::vector<std::string> ownSolverNames();

/// Makes the solver \a name: one that the application registered, else one of haptics'. Throws
/// base::InputError, with the known names, if there is none.
std::unique_ptr<haptics::HologramSolver> makeAnySolver(const std::string& name,
                                                       const haptics::SolverOptions& options);

} // namespace midair::bridge
