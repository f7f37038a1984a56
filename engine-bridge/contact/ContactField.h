#pragma once

#include "engine-bridge/contact/ContactTracker.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Options for playing foci; isValid() names the first setting that is out of its range.
struct ContactFieldOptions
{
    /// True: foci have their pressures in Pa, as far as the array can. False: only their ratios
    /// count, and the array plays as loud as it can.
    bool absolute = true;
    /// True: transducers behind the finger stay off, because their sound presses its other side.
    /// Keeps those with cos > maskCosine, the cosine of the angle between the direction from the
    /// contact to the transducer and the direction into the object (AUTDController32_1_1.cs of
    /// github.com/shinolab/midair-haptics-unity). With several contacts, a transducer is on if one
    /// of them keeps it.
    bool mask = false;
    double maskCosine = -0.3; ///< -1 .. 1
    /// 0 .. 0.1; the mask is recomputed when a contact moved farther than this (or turned by 5
    /// degrees), so that tremor doesn't change it
    double maskMotion_m = 2e-3;

    bool isValid(std::string* error = nullptr) const;
};

/// Places, normals and pressures (Pa) of \a foci, as control points.
haptics::ControlPoints pointsOf(const std::vector<ContactFocus>& foci);

/// Computes activations for the foci of one moment by the default solver, starting from the last
/// field; conjugate phases for one focus. The common phase, which can't be felt, is rotated so that
/// each field is as near as possible to the last one.
class ContactField
{
public:
    static constexpr int kMostFoci = 200; ///< of all contacts together

    /// Throws InputError for an array, medium or options that are not valid.
    ContactField(const haptics::TransducerArray& array,
                 const haptics::Medium& medium,
                 const ContactFieldOptions& options = {});

    /// Sets \a q to m activations, |q_i| <= 1; zero for no foci. Returns false, with q zero and a
    /// message in \a error (may be null), for numbers that aren't finite or are out of range, for
    /// more than kMostFoci, and if the solver refuses them.
    bool solve(const std::vector<ContactFocus>& foci, Eigen::VectorXcf& q, std::string* error);

    /// Report of the last solve() with foci.
    const haptics::SolveReport& report() const { return _report; }
    int driven() const { return _driven; } ///< transducers that the mask keeps
    const haptics::TransducerArray& array() const { return _array; }
    /// Solves for other reflectors from the next field on.
    void setReflectors(const std::vector<haptics::Reflector>& reflectors)
    {
        _array.reflectors = _masked.reflectors = reflectors;
        _isArrayKnown = false;
    }

private:
    /// Position of a contact when the mask was computed.
    struct Place
    {
        std::uint64_t contact = 0;
        Eigen::Vector3d centre;
        Eigen::Vector3d normal;
    };

    void mask(const std::vector<ContactFocus>& foci);
    bool isMaskOf(const std::vector<Place>& places) const;
    bool solveFor(const std::vector<ContactFocus>& foci, Eigen::VectorXcf& q, std::string* error);

    ContactFieldOptions _options;
    haptics::Medium _medium;
    haptics::TransducerArray _array;
    haptics::TransducerArray _masked; ///< with gains of 0 behind the finger
    std::vector<Place> _places;       ///< contacts of the mask
    std::vector<bool> _isOn;          ///< m
    int _driven = 0;
    std::unique_ptr<haptics::HologramSolver> _solver;
    bool _isArrayKnown = false; ///< to the solver, as it is now
    haptics::SolveReport _report;
    Eigen::VectorXcf _last; ///< the last field; empty: none
};

} // namespace midair::bridge
