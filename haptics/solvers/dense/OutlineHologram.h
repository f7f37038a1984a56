#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/solvers/dense/LevenbergMarquardt.h"
#include "haptics/surface/Outline.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Settings of OutlineHologram; isValid() names the first one that is out of range.
struct OutlineOptions
{
    double spacing = 0.245; ///< 0.1 .. 1, in wavelengths; spacing of the control points
    int starts = 8;         ///< 1 .. 1000; number of starts, with different phases
    int finalists = 3;      ///< >= 1; number of starts that are fully corrected
    int rounds = 30;        ///< >= 1; rounds of weighted projections from each start
    int corrections = 60;   ///< >= 0; maximum for a finalist before its goal is raised
    /// > 0; required mean radiation pressure, relative to the loudest field for points a wavelength
    /// apart
    double loudness = 1.0;
    /// true: the last field is the only start if it had as many points and transducers
    bool warmStart = true;
    std::uint64_t seed = 1;                 ///< seed of the random starts
    int threads = 1;                        ///< >= 1
    std::shared_ptr<base::ThreadPool> pool; ///< as SolverOptions::pool
    base::StopToken stop;                   ///< on its request solve() throws Stopped

    /// Returns false if a setting is out of range; \a error, if given, then names it.
    bool isValid(std::string* error = nullptr) const;
};

/// Result, measured for the activations as the device plays them.
struct OutlineReport
{
    /// A start and its figures: for finalists after all corrections, for others after the first.
    struct Start
    {
        std::string name;     ///< "equal", "ramp of 1", "random 0", "last field", ..
        double mean_Pa = 0.0; ///< mean radiation pressure, as OutlineReport::along
        double coefficientOfVariation = 0.0;
        bool finalist = false;
    };

    int points = 0;
    std::vector<Start> starts;
    int chosen = -1; ///< index into starts
    /// Radiation pressure over the square of the target, sampled every tenth of a wavelength along
    /// the outlines
    SurfaceStatistics along;
    SurfaceStatistics apart; ///< the same for the loudest field with points a wavelength apart
    bool loudEnough = false; ///< along.mean_Pa is at least loudness times apart.mean_Pa
    int corrections = 0;     ///< corrections of the chosen start
    double solve_ms = 0.0;
};

/// Computes one stationary field for outlines, nearly without ripples. Control points a quarter of
/// a wavelength apart are solved for by weighted projections and then LevenbergMarquardt. The
/// result depends on the starting phases, so equal ones, ramps along the curve and random ones are
/// tried. Among the fields as loud as one for points a wavelength apart, the smoothest is chosen.
/// Phase-only: all transducers play at full amplitude.
class OutlineHologram
{
public:
    /// Throws InputError for options that are not valid.
    explicit OutlineHologram(const OutlineOptions& options = {});

    /// Sets \a q to m activations on the array's levels. Throws InputError if outlines, array or
    /// medium are invalid or the outlines are too long (Limits.h), and Stopped on a stop request.
    OutlineReport solve(const std::vector<Outline>& outlines,
                        const TransducerArray& array,
                        const Medium& medium,
                        Eigen::VectorXcf& q);

    const OutlineOptions& options() const { return _options; }
    /// Returns the control points of the last field, with the targets of their outlines.
    const ControlPoints& points() const { return _points; }
    /// Returns mean_l sum_i |G_li| at these points, Pa: the mean pressure of a single focus there.
    double meanRowSum_Pa() const { return _field.unit_Pa() * _field.meanRowSum(); }

private:
    struct Candidate
    {
        int start = 0;
        double goal_Pa = 0.0;
        int corrections = 0;
        SurfaceStatistics along;
        Eigen::VectorXcf q; // unit amplitudes; phases not rounded
    };

    struct Scene
    {
        const std::vector<Outline>& outlines;
        const TransducerArray& array;
        const Medium& medium;
        Eigen::Matrix3Xd dense;  // samples for measuring the pressure
        Eigen::VectorXd targets; // target of the outline at each of them
        double unit_Pa;          // radiation pressure of 1 Pa peak
    };

    void checkLength(const std::vector<Outline>& outlines, double wavelength_m) const;
    void place(const Scene& scene, double spacing_m);
    std::string start(int index);
    SurfaceStatistics judge(const Scene& scene, Eigen::VectorXcf* played = nullptr);
    SurfaceStatistics solveApart(const Scene& scene, double spacing_m);
    void follow(const Scene& scene, int corrections, Candidate& candidate);
    void raise(const Scene& scene, double floor_Pa, Candidate& candidate);
    std::vector<Candidate> begin(const Scene& scene, double floor_Pa, OutlineReport& report);
    void finish(const Scene& scene,
                double floor_Pa,
                std::vector<Candidate>& candidates,
                OutlineReport& report,
                Eigen::VectorXcf& q);

    OutlineOptions _options;
    FieldProblem _field;
    LevenbergMarquardt _even;
    ControlPoints _points;      // points of the present solve
    std::vector<double> _along; // for each of them: share of the outline's length up to it
    Eigen::VectorXcf _last;     // q of the last field before rounding; empty: none
    int _lastPoints = 0;
    SurfaceStatistics _lastApart;
};

} // namespace midair::haptics
