#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>

namespace midair::samples
{

/// The played field for some control points, with its report.
struct PaperField
{
    haptics::ControlPoints points;
    haptics::SolveReport report;
    Eigen::VectorXcf played;     ///< m
    Eigen::VectorXd achieved_Pa; ///< n, peak
    double evenness() const;     ///< ratio of the weakest to the strongest pressure at the points
};

/// Parameters of a solve of the paper's scenes.
struct PaperSolve
{
    std::string solver;     ///< a name of haptics::solverNames()
    bool phaseOnly = false; ///< true: full drive; false: also solves for duties, as the paper does
    double lambda = 0.1;    ///< Tikhonov regularisation of GS and SDP, relative to trace(K)/n
    /// 0: equal starting phases; else the seed of random ones and of the solver's random numbers.
    std::uint64_t start = 0;
};

/// The paper's array at 14.5 degrees Celsius, where the wavelength is the paper's 8.5 mm.
class PaperArray
{
public:
    PaperArray();

    /// Solves for equal targets at \a positions (3 x n, metres) in at most 1000 iterations and
    /// evaluates the played field.
    PaperField solve(const Eigen::Matrix3Xd& positions, const PaperSolve& how) const;

    /// Returns the peak pressures of \a field at \a points, Pa.
    Eigen::VectorXd pressure(const Eigen::Matrix3Xd& points, const PaperField& field) const;

    /// Returns the full width at half pressure, metres, of the spot at \a centre along \a direction
    /// (unit vector).
    double halfWidth_m(const PaperField& field,
                       const Eigen::Vector3d& centre,
                       const Eigen::Vector3d& direction) const;

    /// Returns sum_i P0 D(theta_i) exp(-beta R_i) / R_i, the pressure at \a point if all waves
    /// arrive in phase.
    double inPhase_Pa(const Eigen::Vector3d& point) const;

    void draw(const PaperField& field, const std::string& title, const std::string& path) const;

    const haptics::Medium& medium() const { return _medium; }

private:
    void randomise(haptics::HologramSolver& solver, std::uint64_t seed) const;

    haptics::TransducerArray _array;
    haptics::Medium _medium;
};

/// Returns five tips, five notches and the centre of a pentagram in the cross-section xz, 3 x 11;
/// \a width_m is the distance from tip to tip across, metres, > 0.
Eigen::Matrix3Xd flatStar(double width_m);

/// Solves flat stars with GS, SDP relaxation and the default solver from an equal start and
/// \a starts random ones, >= 1, and prints the distribution of the ratio of weakest to strongest
/// pressure.
void printStarStarts(const PaperArray& paper, int starts);

/// Redraws the paper's figures 3, 4, 6 and 7 into \a folder, as paper_figure3.png and so on, and
/// prints their numbers next to the paper's: the flat star of 34 mm by GS and by SDP relaxation,
/// the focus and the line. Of \a starts >= 1 random starts, the star with the median evenness is
/// drawn. Throws base::InputError if a file can't be written.
void drawPaperFigures(const PaperArray& paper, int starts, const std::string& folder);

} // namespace midair::samples
